"""A trained policy: the folder of `activesuit train` or of `save_policy`."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError, shown, unknown_name
from ..model import ArmConfig
from ..plant import Plant
from .network import CARD, contract_of, observed, read_card, read_network

OWN_SUIT = "suit.json"  # a copy of the suit file that a run was given
OBSERVATION = ("sensors", "normalize", "history")
ARM = (
    *("suit", "pressure", "gravity", "wearer", "coupling", "payload", "side", "tilt"),
    *("preconditioned", "allow_uncertified"),
)
_ENVIRONMENT = ("env", "level", *OBSERVATION, *ARM)


def environment_of(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the environment that a policy was trained in: env, suit, gravity, sensors, ...

    Raises:
        InputError: The folder has no card, or an option is unknown or cannot be used.
    """
    folder = Path(folder)
    path, found = folder / CARD, dict(read_card(folder).environment)
    for name in found:
        if name not in _ENVIRONMENT:
            raise unknown_name(f"option in {str(path)!r}", name, _ENVIRONMENT)
    if not isinstance(found.get("env"), str):
        raise InputError(f"{str(path)!r} has the env {shown(found.get('env'))}: it must be an id")
    if found.get("suit") == OWN_SUIT:
        found["suit"] = str(folder / OWN_SUIT)
    try:
        ArmConfig.from_dict({name: found[name] for name in ARM if name in found})
    except InputError as error:
        raise InputError(f"{str(path)!r}: {error}") from error
    return found


def training_of(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns how a policy was trained: algo, seed, steps, and what else its card says.

    Raises:
        InputError: The folder has no card, or a value cannot be used.
    """
    path, found = Path(folder) / CARD, dict(read_card(folder).training)
    if not isinstance(found.get("algo"), str):
        raise InputError(
            f"{str(path)!r} has the algo {shown(found.get('algo'))}: it must be a name"
        )
    if not isinstance(found.get("hyperparameters", {}), dict):
        raise InputError(f"{str(path)!r} has hyperparameters that are no object: restore it")
    for name, least in (("seed", 0), ("steps", 1), ("rows", 1)):
        value = found.get(name, least)
        if type(value) is not int or value < least:
            raise InputError(
                f"{str(path)!r} has {name} {shown(value)}: it must be a whole number of at least "
                f"{least}"
            )
    return found


class TrainedPolicy:
    """Takes the mean action of a trained network, by NumPy alone.

    The folder has the network's numbers in `policy.safetensors` and all else in `policy.json`, so
    that a folder of someone else runs no code.

    Args:
        folder: Folder of a run of `activesuit train`, or of `save_policy`.
        plant: What the policy may know of the arms.

    Raises:
        InputError: The folder has no finished checkpoint, a file is damaged, or the network
            observes something else than these arms show.
    """

    def __init__(self, folder: str | os.PathLike[str], plant: Plant) -> None:
        card = read_card(folder)
        self._network = read_network(folder, card)
        _check_observed(Path(folder), card.observation, observed(plant))
        self._memory: Array | None = None

    def reset(self) -> None:
        """Forgets what a network with memory has seen."""
        self._memory = None

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the network's mean action."""
        rows = observation.reshape(-1, observation.shape[-1])
        if self._memory is None or self._memory.shape[1] != len(rows):
            self._memory = self._network.memory(len(rows))
        action = self._network.act(rows, self._memory)
        return action.reshape(*observation.shape[:-1], -1)


def _check_observed(folder: Path, trained: dict[str, Any], here: dict[str, Any]) -> None:
    if contract_of(trained) == contract_of(here):
        return
    name = next((name for name in here if trained.get(name) != here[name]), "observation")
    raise InputError(
        f"the policy in {str(folder)!r} was trained with the {name} {shown(trained.get(name))}, "
        f"and the environment has {shown(here[name])}: make it with the sensors that the policy "
        "was trained with, or train again"
    )
