"""Learners of Stable-Baselines3: new ones, saved ones, and the checkpoints between."""

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..envs.making import make_arms
from ..envs.policies.network import ARCHITECTURES, algorithm_class, check_finite, unreadable
from ..envs.policies.trained import CHECKPOINT
from ..errors import InputError
from .output import Bar, RunFolder
from .own_files import is_own, note

# Short horizon: effort answers an action at once. The start is gentle (log_std) and the
# networks small, as the task is nearly a function of angle, rate and target.
SETTINGS: dict[str, dict[str, Any]] = {
    "ppo": {
        "n_steps": 256,
        "batch_size": 256,
        "gamma": 0.9,
        "gae_lambda": 0.9,
        "learning_rate": 1e-3,
        "policy_kwargs": {"log_std_init": -1.0, **ARCHITECTURES["ppo"]},
    },
    "sac": {
        "gamma": 0.9,
        "buffer_size": 100_000,
        "learning_starts": 1000,
        "policy_kwargs": ARCHITECTURES["sac"],
    },
}
PARALLEL = {"ppo": 8, "sac": 1}
CHECKPOINTS = 10  # number per run
REPLAY = "replay.pkl"


@dataclass(frozen=True)
class Checkpoint:
    """Content of the files from which a training goes on.

    Attributes:
        path: Path of the checkpoint.
        learner: Learner, with its options as Python objects.
        replay: Experience of the learner; None if it keeps none.
    """

    path: Path
    learner: bytes
    replay: bytes | None

    @classmethod
    def read(cls, out: Path, *, trust: bool) -> "Checkpoint":
        """Reads the files of a run, without looking into them.

        Args:
            out: Folder of the run.
            trust: True to take files that this machine did not write.

        Raises:
            InputError: A file is missing, or was not written on this machine.
        """
        contents: list[bytes | None] = []
        for path in (out / CHECKPOINT, out / REPLAY):
            content = path.read_bytes() if path.is_file() else None
            if content is not None and not trust and not is_own(content):
                raise InputError(
                    f"{str(path)!r} was not written by you on this machine, and to resume it runs "
                    "whatever code it holds: add --trust if you trust whoever made it, or train "
                    "anew"
                )
            contents.append(content)
        learner, replay = contents
        if learner is None:
            raise InputError(
                f"{str(out)!r} holds no {CHECKPOINT} to resume: train without --resume first"
            )
        return cls(out / CHECKPOINT, learner, replay)


def training_environments(env: str, algo: str, seed: int, options: dict[str, Any]) -> Any:
    """Returns the environments that a learner trains in, as one of Stable-Baselines3."""
    from stable_baselines3.common.vec_env import VecMonitor

    from ..envs.sb3 import ArmVecEnv

    environments = VecMonitor(
        ArmVecEnv(make_arms(env, PARALLEL[algo], **options, autoreset_mode="SameStep"))
    )
    environments.seed(seed)
    return environments


def new_learner(algo: str, environments: Any, folder: RunFolder, seed: int) -> Any:
    """Returns a learner that knows nothing yet."""
    logs = str(folder.subfolder("tensorboard"))
    return algorithm_class(algo)(
        "MlpPolicy", environments, seed=seed, device="cpu", tensorboard_log=logs, **SETTINGS[algo]
    )


def resumed_learner(algo: str, environments: Any, checkpoint: Checkpoint) -> Any:
    """Returns the learner of a checkpoint; this runs whatever code the checkpoint holds.

    Raises:
        InputError: A file is damaged or belongs to another run, or a weight is not finite.
    """
    try:
        file = io.BytesIO(checkpoint.learner)
        learner = algorithm_class(algo).load(file, env=environments, device="cpu")
    except Exception as error:  # a damaged file fails wherever it is damaged
        raise unreadable(checkpoint.path, error) from error
    check_finite(learner.policy, checkpoint.path)
    if checkpoint.replay is not None:
        _load_replay(learner, checkpoint.replay, checkpoint.path.with_name(REPLAY))
    return learner


def _load_replay(learner: Any, content: bytes, path: Path) -> None:
    try:
        learner.load_replay_buffer(io.BytesIO(content))
        replay = learner.replay_buffer
        fits = (replay.obs_shape, replay.action_dim, replay.n_envs) == (
            learner.observation_space.shape,
            learner.action_space.shape[0],
            learner.n_envs,
        )
    except Exception as error:
        raise InputError(
            f"{str(path)!r} is not a readable experience of this run ({type(error).__name__}): "
            "restore it, or remove it to go on without"
        ) from error
    if not fits:
        raise InputError(
            f"{str(path)!r} holds the experience of another run: restore it, or remove it to go on "
            "without"
        )


def save(learner: Any, folder: RunFolder) -> bool:
    """Writes a checkpoint and notes it as ours; returns whether that could be noted."""
    noted = _write(folder, CHECKPOINT, learner.save)
    if hasattr(learner, "save_replay_buffer"):
        noted &= _write(folder, REPLAY, learner.save_replay_buffer)
    return noted


def _write(folder: RunFolder, name: str, write: Callable[[Path], Any]) -> bool:
    # Noted before it is in its place: a run that is killed in between is still ours.
    with folder.replacing(name) as scratch:
        write(scratch)
        return note(scratch, folder / name)


def checkpoints(learner: Any, folder: RunFolder, bar: Bar, steps: int) -> Any:
    """Returns a callback that saves ten times a run and moves the progress bar."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Checkpoints(BaseCallback):
        next_save = learner.num_timesteps + steps // CHECKPOINTS

        def _on_step(self) -> bool:
            bar.move_to(self.num_timesteps)
            if self.num_timesteps >= self.next_save:
                self.next_save = self.num_timesteps + steps // CHECKPOINTS
                save(learner, folder)
            return True

    return Checkpoints()


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Makes torch compute with `count` threads in the block."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)
