"""Reads trained networks without running anything that a file brings along.

A checkpoint of Stable-Baselines3 holds Python objects, whose reading can run any code. Only the
numbers in its `policy.pth` are read here, into a network of our own making.
"""

import io
import zipfile
from pathlib import Path
from typing import Any

import gymnasium

from ...errors import InputError

# What `activesuit train` builds, said here because a checkpoint is not asked.
ARCHITECTURES: dict[str, dict[str, Any]] = {
    "ppo": {"net_arch": {"pi": [64, 64], "vf": [64, 64]}},
    "sac": {"net_arch": {"pi": [256, 256], "qf": [256, 256]}},
}
_FIRST_LAYER = {"ppo": "mlp_extractor.policy_net.0.weight", "sac": "actor.latent_pi.0.weight"}
WEIGHTS = "policy.pth"
LARGEST = 50_000_000  # bytes; our networks have less than 2 MB


def algorithm_class(name: str) -> Any:
    """Returns Stable-Baselines3's class for "ppo" or "sac".

    Raises:
        InputError: Stable-Baselines3 is not installed.
    """
    try:
        import stable_baselines3
    except ImportError as error:
        raise InputError(
            "training and trained policies need Stable-Baselines3: use `make train` in a clone of "
            "the repository, or pip install -e '.[train]' -c constraints.txt"
        ) from error
    return getattr(stable_baselines3, name.upper())


def load_actor(
    algorithm: str, path: Path, observations: gymnasium.Space, actions: gymnasium.Space
) -> Any:
    """Returns the network whose weights are in a checkpoint, as a policy of Stable-Baselines3.

    Args:
        algorithm: Learning algorithm, "ppo" or "sac".
        path: Path of the checkpoint.
        observations: Observation space of the environment.
        actions: Action space of the environment.

    Raises:
        InputError: The file is damaged, its network is not one of ours or does not fit the spaces,
            a weight is not a finite number, or Stable-Baselines3 is not installed.
    """
    learner = algorithm_class(algorithm)
    actor = learner.policy_aliases["MlpPolicy"](
        observations, actions, lambda _: 0.0, **ARCHITECTURES[algorithm]
    )
    (size,) = observations.shape or (0,)
    try:
        weights = _weights(path)
        observed = int(weights[_FIRST_LAYER[algorithm]].shape[1])
        if observed == size:
            actor.load_state_dict(weights)
    except Exception as error:  # a damaged file fails wherever it is damaged
        raise unreadable(path, error) from error
    if observed != size:
        raise InputError(
            f"the policy in {str(path.parent)!r} observes {observed} numbers and the environment "
            f"shows {size}: give it the sensors that it was trained with, or train again"
        )
    check_finite(actor, path)
    return actor


def check_finite(policy: Any, path: Path) -> None:
    """Checks that all weights of a policy of Stable-Baselines3 are finite.

    Raises:
        InputError: One of them is not.
    """
    if not all(bool(values.isfinite().all()) for values in policy.state_dict().values()):
        raise InputError(
            f"the network in {str(path)!r} has weights that are not finite numbers: restore it, or "
            "train again"
        )


def unreadable(path: Path, error: Exception) -> InputError:
    """Returns the error for a checkpoint that cannot be read."""
    reason = next(iter(str(error).splitlines()), type(error).__name__)
    return InputError(
        f"{str(path)!r} is not a readable policy of `activesuit train` ({reason}): restore it, or "
        "train again"
    )


def _weights(path: Path) -> dict[str, Any]:
    import torch

    content = _part(path, WEIGHTS)
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        if sum(part.file_size for part in parts.infolist()) > LARGEST:
            raise ValueError(f"{WEIGHTS} is longer than {LARGEST:,} bytes")
    return torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)


def _part(path: Path, name: str) -> bytes:
    with zipfile.ZipFile(path) as archive, archive.open(name) as part:
        content = part.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"{name} is longer than {LARGEST:,} bytes")
    return content
