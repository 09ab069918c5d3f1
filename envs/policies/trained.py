"""A policy trained by `activesuit train` (needs the extra `train`)."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from ...errors import InputError, shown, unknown_name
from ...json_files import read_json
from ..model import ArmConfig
from ..plant import Plant
from .network import ARCHITECTURES, load_actor

CONFIG, CHECKPOINT = "config.json", "model.zip"
OWN_SUIT = "suit.json"  # a copy of the suit file that a run was given
_RUN = ("env", "algo", "seed", "steps")
_ARM = (
    *("suit", "pressure", "gravity", "wearer", "coupling", "payload", "side", "tilt"),
    *("preconditioned", "allow_uncertified"),
)


def training_config(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the options that a policy was trained with: env, algo, suit, gravity, ...

    Raises:
        InputError: The folder is not a training run, or an option is unknown or cannot be used.
    """
    folder = Path(folder)
    path = folder / CONFIG
    if not path.is_file():
        raise InputError(
            f"{str(folder)!r} is neither a policy name nor a run of `activesuit train`: it has no "
            f"readable {CONFIG}"
        )
    config = read_json(path, "training run")
    if not isinstance(config, dict):
        raise InputError(f"{str(path)!r} is {shown(config)}: it must be an object of options")
    for name in config:
        if name not in (*_RUN, *_ARM):
            raise unknown_name(f"option in {str(path)!r}", name, (*_RUN, *_ARM))
    for name, kind, example in (("env", str, "an id"), ("algo", str, "'ppo' or 'sac'")):
        if not isinstance(config.get(name), kind):
            raise InputError(
                f"{str(path)!r} has the {name} {shown(config.get(name))}: it must be {example}"
            )
    if config["algo"] not in ARCHITECTURES:
        raise unknown_name(f"algo in {str(path)!r}", config["algo"], ARCHITECTURES)
    for name, least in (("seed", 0), ("steps", 1)):
        value = config.get(name, least)
        if type(value) is not int or value < least:
            raise InputError(
                f"{str(path)!r} has {name} {shown(value)}: it must be a whole number of at least "
                f"{least}"
            )
    if config.get("suit") == OWN_SUIT:
        config["suit"] = str(folder / OWN_SUIT)
    _check_arm({name: config[name] for name in _ARM if name in config}, path)
    return config


def _check_arm(options: dict[str, Any], path: Path) -> None:
    try:
        ArmConfig.from_dict(options)
    except InputError as error:
        raise InputError(f"{str(path)!r}: {error}") from error


class TrainedPolicy:
    """Takes the mean action of a trained network.

    Only the numbers of the network are read from the folder, never the Python objects in it, so
    that a folder of someone else runs no code.

    Args:
        folder: Folder of a run of `activesuit train`, with `config.json` and `model.zip`.
        plant: What the policy may know of the arms.

    Raises:
        InputError: The folder holds no finished checkpoint, or the network does not fit.
    """

    def __init__(self, folder: str | os.PathLike[str], plant: Plant) -> None:
        folder, algorithm = Path(folder), training_config(folder)["algo"]
        path = folder / CHECKPOINT
        if not path.is_file():
            raise InputError(
                f"{str(folder)!r} has no {CHECKPOINT}: train it first, or with --resume"
            )
        actions = Box(-1.0, 1.0, (plant.motors,), np.float32)
        self._actor = load_actor(algorithm, path, plant.observation_space, actions)

    def reset(self) -> None:
        """Does nothing, because the network has no memory."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the network's mean action."""
        action, _ = self._actor.predict(observation, deterministic=True)
        return np.asarray(action, dtype=np.float64)
