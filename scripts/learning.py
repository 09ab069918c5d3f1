"""Learners of Stable-Baselines3: new ones, saved ones, and the checkpoints between."""

import io
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..envs.making import make_arms
from ..envs.policies.network import Card, files_of
from ..errors import InputError
from .hyperparameters import algorithm_class, arguments
from .output import Bar, RunFolder
from .own_files import is_own, note

CHECKPOINT, REPLAY = "model.zip", "replay.pkl"
CHECKPOINTS = 10  # number per run
MONITORED = ("episode_returns", "episode_lengths")
LATEST = ("_last_episode_starts", "_last_lstm_states")


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


def training_environments(env: str, rows: int, seed: int, options: dict[str, Any]) -> Any:
    """Returns the environments that a learner trains in, as one of Stable-Baselines3."""
    from stable_baselines3.common.vec_env import VecMonitor

    from ..envs.sb3 import ArmVecEnv

    arms = make_arms(env, rows, **options, autoreset_mode="SameStep", stagger=True)
    environments = VecMonitor(ArmVecEnv(arms))
    environments.seed(seed)
    return environments


def new_learner(
    algo: str, environments: Any, folder: RunFolder, seed: int, settings: dict[str, Any]
) -> Any:
    """Returns a learner that knows nothing yet.

    Raises:
        InputError: The algorithm refuses a hyperparameter.
    """
    logs = str(folder.subfolder("tensorboard"))
    usual = {"seed": seed, "device": "cpu", "tensorboard_log": logs}
    try:
        return algorithm_class(algo)(
            settings["policy"], environments, **usual, **arguments(settings)
        )
    except InputError:
        raise
    except Exception as error:  # whatever a value of the wrong kind leads to
        raise InputError(
            f"{algo} refuses its hyperparameters ({type(error).__name__}: {error}): change the file"
        ) from error


def resumed_learner(algo: str, environments: Any, checkpoint: Checkpoint) -> Any:
    """Returns the learner of a checkpoint; this runs whatever code the checkpoint holds.

    What it learns next is what it would have learned without the break, to the last bit: see
    `_remember`.

    Raises:
        InputError: A file is damaged or belongs to another run.
    """
    try:
        file = io.BytesIO(checkpoint.learner)
        learner = algorithm_class(algo).load(
            file, env=environments, device="cpu", force_reset=False
        )
    except Exception as error:  # a damaged file fails wherever it is damaged
        reason = next(iter(str(error).splitlines()), type(error).__name__)
        raise InputError(
            f"{str(checkpoint.path)!r} is not a readable checkpoint ({reason}): restore it, or "
            "train again"
        ) from error
    if checkpoint.replay is not None:
        _load_replay(learner, checkpoint.replay, checkpoint.path.with_name(REPLAY))
    _go_back(learner, checkpoint.path)
    return learner


def _remember(learner: Any) -> None:
    """Puts into a learner what its next update depends on beside it; a checkpoint has it then.

    That is the state of the arms, of the monitor of their episodes, of a recurrent network, and of
    all random generators.
    """
    import torch

    if learner._last_obs is None:  # interrupted before the first episode
        return
    monitor = learner.env
    memory = {
        "arms": monitor.unwrapped.arms.get_state(),
        "monitor": {name: getattr(monitor, name).copy() for name in MONITORED},
        "python": random.getstate(),
        "numpy": np.random.get_state(),  # noqa: NPY002 - the generator that learners use
        "torch": torch.get_rng_state().numpy(),
        "actions": learner.action_space.np_random.bit_generator.state,
    }
    learner.memory = memory | {name: getattr(learner, name, None) for name in LATEST}


def _go_back(learner: Any, path: Path) -> None:
    """Restores what `_remember` has put into a learner."""
    import torch

    memory = getattr(learner, "memory", None)
    if memory is None:
        learner._last_obs = None
        return
    monitor = learner.env
    try:
        monitor.reset()
        observation, _ = monitor.unwrapped.arms.set_state(memory["arms"])
        for name in MONITORED:
            getattr(monitor, name)[:] = memory["monitor"][name]
        for name in LATEST:
            if memory[name] is not None:
                setattr(learner, name, memory[name])
        learner._last_obs = observation
        learner.action_space.np_random.bit_generator.state = memory["actions"]
        random.setstate(memory["python"])
        np.random.set_state(memory["numpy"])  # noqa: NPY002
        torch.set_rng_state(torch.from_numpy(memory["torch"]))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{str(path)!r} does not tell the state of its arms ({error}): train anew"
        ) from error


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


def save(learner: Any, folder: RunFolder, card: Card) -> bool:
    """Writes a checkpoint and the policy, and notes them as ours; returns whether that worked."""
    from ..envs.policies.saving import network_of

    _remember(learner)
    noted = _write(folder, CHECKPOINT, learner.save)
    if hasattr(learner, "save_replay_buffer"):
        noted &= _write(folder, REPLAY, learner.save_replay_buffer)
    training = {**card.training, "done": int(learner.num_timesteps)}
    card = card.model_copy(update={"training": training})
    return write_own(folder, files_of(card, network_of(learner))) and noted


def write_own(folder: RunFolder, contents: Mapping[str, bytes]) -> bool:
    """Writes files that belong together and notes them as ours; returns whether that worked."""
    with ExitStack() as all_written:  # they take their places when the last one is complete
        noted = True
        for name, content in contents.items():
            scratch = all_written.enter_context(folder.replacing(name))
            scratch.write_bytes(content)
            noted &= note(scratch, folder / name)
    return noted


def _write(folder: RunFolder, name: str, write: Callable[[Path], Any]) -> bool:
    # Noted before it is in its place: a run that is killed in between is still ours.
    with folder.replacing(name) as scratch:
        write(scratch)
        return note(scratch, folder / name)


def checkpoints(learner: Any, folder: RunFolder, card: Card, bar: Bar, steps: int) -> Any:
    """Returns a callback that saves ten times a run, logs episodes, and moves the progress bar."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Checkpoints(BaseCallback):
        next_save = learner.num_timesteps + steps // CHECKPOINTS

        def _on_rollout_start(self) -> None:  # between updates, so that a resume can be exact
            if self.num_timesteps >= self.next_save:
                self.next_save = self.num_timesteps + steps // CHECKPOINTS
                save(learner, folder, card)

        def _on_step(self) -> bool:
            bar.move_to(self.num_timesteps)
            for info in self.locals["infos"]:
                for name, value in info.get("episode_costs", {}).items():
                    learner.logger.record_mean(f"arm/{name}", value)
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
