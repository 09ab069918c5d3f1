"""A policy trained by `activesuit train` (needs the extra `train`)."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError


def algorithm_class(name: str) -> Any:
    """Returns Stable-Baselines3's class for "ppo" or "sac".

    Raises:
        InputError: Stable-Baselines3 is not installed.
    """
    try:
        import stable_baselines3
    except ImportError as error:
        raise InputError(
            "training and trained policies need Stable-Baselines3: in a clone of the repository, "
            "pip install '.[train]' -c constraints.txt"
        ) from error
    return getattr(stable_baselines3, name.upper())


def training_config(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the options that a policy was trained with: env, algo, suit, gravity, ...

    Raises:
        InputError: The folder is not a training run.
    """
    try:
        config = json.loads((Path(folder) / "config.json").read_text(encoding="utf-8"))
        return {**config, "env": config["env"], "algo": config["algo"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{str(folder)!r} is neither a policy name nor a run of `activesuit train`: it has no "
            "readable config.json"
        ) from error


def load_network(algorithm: str, path: Path, **options: Any) -> Any:
    """Returns the Stable-Baselines3 model in `path`.

    Raises:
        InputError: The file is damaged, or Stable-Baselines3 is not installed.
    """
    learner = algorithm_class(algorithm)
    try:
        return learner.load(path, device="cpu", **options)
    except Exception as error:  # a damaged file fails wherever it is damaged
        raise InputError(
            f"{str(path)!r} is not a readable policy ({error}): restore it, or train again"
        ) from error


class TrainedPolicy:
    """Takes the mean action of a trained network.

    Args:
        folder: Folder of a run of `activesuit train`, with `config.json` and `model.zip`.
        observation_size: Number of values that the environment observes; it must fit the network.

    Raises:
        InputError: The folder holds no finished checkpoint, or the network does not fit.
    """

    def __init__(self, folder: str | os.PathLike[str], observation_size: int) -> None:
        folder, algorithm = Path(folder), training_config(folder)["algo"]
        if not (folder / "model.zip").is_file():
            raise InputError(f"{str(folder)!r} has no model.zip: train it first, or with --resume")
        self._network = load_network(algorithm, folder / "model.zip")
        size = self._network.observation_space.shape[0]
        if size != observation_size:
            raise InputError(
                f"the policy in {str(folder)!r} observes {size} numbers and the environment shows "
                f"{observation_size}: evaluate it with the options it was trained with, which are "
                f"in {folder / 'config.json'}"
            )

    def reset(self) -> None:
        """Does nothing, because the network has no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the network's mean action."""
        del info
        action, _ = self._network.predict(observation, deterministic=True)
        return np.asarray(action, dtype=np.float64)
