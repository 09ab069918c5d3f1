"""A trained policy: the folder of `activesuit train` or of `save_policy`."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import load_suit, suit_names
from ...checks import at_least
from ...errors import InputError, shown, unknown_name
from ..model import ArmConfig
from ..model.config import NO_SUIT
from ..plant import Plant
from ..setup import OF_ARM, OPTIONS
from .network import CARD, Card, Network, contract_of, observed, read_card

SHIPPED = Path(__file__).parents[2] / "assets" / "policies"
OWN_SUIT = "suit.json"  # a copy of the suit file that a run was given
OBSERVATION = ("sensors", "normalize", "history", "belief")
ARM = (
    *("suit", "pressure", "gravity", "wearer", "coupling", "payload", "side", "tilt"),
    *("preconditioned", "allow_uncertified"),
)
_ENVIRONMENT = {"env", "max_episode_steps"} | OPTIONS - {"reward", "randomize"}


def shipped_policies() -> dict[str, str]:
    """Returns the folders of the trained policies that this package ships, by their names."""
    return {path.parent.name: str(path.parent) for path in sorted(SHIPPED.glob(f"*/{CARD}"))}


def folder_of(name: str) -> str | None:
    """Returns the folder of a trained policy, shipped or of a user; None if there is none."""
    return shipped_policies().get(name) or (name if os.path.isdir(name) else None)


def environment_of(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the scene in which the policy of a folder was trained.

    The scene is the id of the environment as "env" and the options as plain data:
    `gymnasium.make(scene.pop("env"), **scene)` makes the environment.
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
    if isinstance(found.get("belief"), dict):
        check_portable(found["belief"].get("suit"))
    try:
        ArmConfig.from_dict({name: found[name] for name in OF_ARM & found.keys()})
        at_least("max_episode_steps", found.get("max_episode_steps", 1), 1)
    except InputError as error:
        raise InputError(f"{str(path)!r}: {error}") from error
    return found


def training_of(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the data of a policy's training: algo, seed, steps and others of its card."""
    path, found = Path(folder) / CARD, dict(read_card(folder).training)
    algo = found.get("algo")
    if not isinstance(algo, str):
        raise InputError(f"{str(path)!r} has the algo {shown(algo)}: it must be a name")
    if not isinstance(found.get("hyperparameters", {}), dict):
        raise InputError(f"{str(path)!r} has hyperparameters that are no object: restore it")
    for name, least in (("seed", 0), ("steps", 1), ("rows", 1), ("motions", 0), ("patience", 1)):
        value, need = found.get(name, least), f"a whole number of at least {least}"
        if type(value) is not int or value < least:
            raise InputError(f"{str(path)!r} has {name} {shown(value)}: it must be {need}")
    return found


def portable(suit: str) -> str | dict[str, Any]:
    """Returns a suit as a card keeps it: the name of a shipped suit, or the content of a file."""
    if suit in suit_names():
        return suit
    return json.loads(load_suit(suit).model_dump_json(exclude_none=True))


def check_portable(suit: Any) -> None:
    """Refuses a suit of a card that names a file, since a foreign card could name any file."""
    if isinstance(suit, str) and suit not in (NO_SUIT, *suit_names()):
        raise InputError(
            f"the card names the suit {shown(suit)}: a card names shipped suits, or has the "
            "content of a file; restore it, or train again"
        )


class TrainedPolicy:
    """Acts by the mean action of a trained network, with NumPy alone; `name` is for messages."""

    def __init__(self, card: Card, network: Network, plant: Plant, name: str) -> None:
        trained, here = card.observation, observed(plant)
        if contract_of(trained) != contract_of(here):
            part = next((part for part in here if trained.get(part) != here[part]), "observation")
            raise InputError(
                f"the policy in {name!r} was trained with the {part} {shown(trained.get(part))}, "
                f"and the environment has {shown(here[part])}: make the environment with the "
                "sensors of the training, or train again"
            )
        self._network = network
        self._memory: Array | None = None

    def reset(self) -> None:
        """Clears the memory of the network."""
        self._memory = None

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the network's mean action."""
        rows = observation.reshape(-1, observation.shape[-1])
        if self._memory is None or self._memory.shape[1] != len(rows):
            self._memory = self._network.memory(len(rows))
        action = self._network.act(rows, self._memory)
        return action.reshape(*observation.shape[:-1], -1)
