"""Checkpoints of a training: what a learner continues from, to the last bit."""

import io
import random
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from ...errors import InputError
from ..output import RunFolder, messages
from ..own_files import is_own, note, notes_folder
from .hyperparameters import algorithm_class

CHECKPOINT = "model.zip"
REPLAY = "replay.pkl"  # in the checkpoint: the experience of a learner that keeps one
MONITORED = ("episode_returns", "episode_lengths")
NOISE = ("exploration_mat", "exploration_matrices")
LATEST = ("_last_episode_starts", "_last_lstm_states")


@dataclass(frozen=True)
class Checkpoint:
    """Content of the file from which a training goes on.

    Attributes:
        path: Path of the checkpoint.
        learner: Learner, with its options and its experience as Python objects.
    """

    path: Path
    learner: bytes

    @classmethod
    def read(cls, out: Path, *, trust: bool) -> "Checkpoint":
        """Reads the file of a run, without looking into it.

        Args:
            out: Folder of the run.
            trust: True to take a file that this machine did not write.

        Raises:
            InputError: The file is missing, or was not written on this machine.
        """
        path = out / CHECKPOINT
        if not path.is_file():
            raise InputError(
                f"{str(out)!r} holds no {CHECKPOINT} to resume: train without --resume first"
            )
        content = path.read_bytes()
        if not trust and not is_own(content):
            raise InputError(
                f"{str(path)!r} was not written by you on this machine, and to resume it runs "
                "whatever code it holds: add --trust if you trust whoever made it, or train anew"
            )
        return cls(path, content)


def resumed_learner(algo: str, environments: Any, checkpoint: Checkpoint) -> Any:
    """Returns the learner of a checkpoint; this runs whatever code the checkpoint holds.

    What it learns next is what it would have learned without the break, to the last bit: see
    `_remember`.
    """
    try:
        file = io.BytesIO(checkpoint.learner)
        learner = algorithm_class(algo).load(
            file, env=environments, device="cpu", force_reset=False
        )
        if _has_experience(learner):
            with ZipFile(file) as archive:
                learner.load_replay_buffer(io.BytesIO(archive.read(REPLAY)))
    except Exception as error:  # a damaged file fails wherever it is damaged
        raise unreadable(checkpoint.path, error) from error
    _go_back(learner, checkpoint.path)
    return learner


def unreadable(path: Path, error: Exception) -> InputError:
    """Returns the message about a checkpoint that cannot be restored.

    Args:
        path: Path of the checkpoint.
        error: Exception that its content raises.
    """
    reason = next(iter(str(error).splitlines()), type(error).__name__)
    return InputError(
        f"{str(path)!r} is not a readable checkpoint ({reason}): restore it, or train again"
    )


def _remember(learner: Any, begun: bool) -> None:
    """Puts into a learner what its next update depends on beside it; a checkpoint has it then.

    That is the state of the arms, of the monitor of their episodes, of a recurrent network, and of
    all random generators.

    Args:
        learner: The learner.
        begun: Whether a rollout has begun, with exploration noise that is already drawn.
    """
    import torch

    if learner._last_obs is None:  # interrupted before the first episode
        return
    monitor, residual = learner.env, _residual(learner.env)
    memory = {
        "arms": monitor.unwrapped.arms.get_state(),
        "monitor": {name: getattr(monitor, name).copy() for name in MONITORED},
        "random": {
            "python": random.getstate(),
            "numpy": np.random.get_state(),  # noqa: NPY002 - the generator that learners use
            "torch": torch.get_rng_state().numpy(),
            "actions": learner.action_space.np_random.bit_generator.state,
        },
        "noise": _noise(learner) if begun else None,
        "residual": residual and residual.get_memory(),
    }
    learner.memory = memory | {name: getattr(learner, name, None) for name in LATEST}


def _go_back(learner: Any, path: Path) -> None:
    """Restores what `_remember` has put into a learner."""
    memory = getattr(learner, "memory", None)
    if memory is None:
        learner._last_obs = None
        return
    monitor, residual = learner.env, _residual(learner.env)
    try:
        monitor.reset()
        observation, _ = monitor.unwrapped.arms.set_state(memory["arms"])
        for name in MONITORED:
            getattr(monitor, name)[:] = memory["monitor"][name]
        for name in LATEST:
            if memory[name] is not None:
                setattr(learner, name, memory[name])
        if residual is not None:
            residual.set_memory(memory["residual"])
            observation = residual.seen(observation)
        learner._last_obs = observation
        _restore_random(learner, memory["random"])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{str(path)!r} does not tell the state of its arms ({error}): train anew"
        ) from error


def _has_experience(learner: Any) -> bool:
    return hasattr(learner, "load_replay_buffer")


def _restore_random(learner: Any, states: Mapping[str, Any]) -> None:
    import torch

    learner.action_space.np_random.bit_generator.state = states["actions"]
    random.setstate(states["python"])
    np.random.set_state(states["numpy"])  # noqa: NPY002
    torch.set_rng_state(torch.from_numpy(states["torch"]))


def _noise(learner: Any) -> dict[str, Any] | None:
    """Returns the exploration that gSDE has drawn for a rollout; None without gSDE."""
    if not getattr(learner, "use_sde", False):
        return None
    drawn = vars(_distribution(learner))
    return {name: drawn[name].detach().numpy() for name in NOISE}


def _distribution(learner: Any) -> Any:
    policy = learner.policy
    return policy.actor.action_dist if hasattr(policy, "actor") else policy.action_dist


def begin_as_before(learner: Any) -> None:
    """Restores exploration that was drawn before a checkpoint, at the begin of its rollout."""
    import torch

    memory = getattr(learner, "memory", None)
    if memory is None or memory["noise"] is None:
        return
    for name, drawn in memory["noise"].items():
        setattr(_distribution(learner), name, torch.from_numpy(drawn))
    _restore_random(learner, memory["random"])


def _residual(environments: Any) -> Any:
    """Returns the layer of environments in which a policy is corrected; None if there is none."""
    below = environments.venv
    return below if hasattr(below, "residual") else None


def save(learner: Any, folder: RunFolder, *, begun: bool) -> bool:
    """Writes a checkpoint and notes it as ours; returns whether that worked.

    Args:
        learner: The learner.
        folder: Folder of the run.
        begun: Whether a rollout has begun.
    """

    def write(path: Path) -> None:
        learner.save(path)
        if _has_experience(learner):
            learner.save_replay_buffer(experience := io.BytesIO())
            with ZipFile(path, "a") as archive:  # one file, so that both are of the same step
                archive.writestr(REPLAY, experience.getbuffer())

    _remember(learner, begun)
    return _write(folder, {CHECKPOINT: write})


def write_own(folder: RunFolder, contents: Mapping[str, bytes]) -> bool:
    """Writes files that belong together and notes them as ours; returns whether that worked."""
    return _write(
        folder,
        {name: partial(Path.write_bytes, data=content) for name, content in contents.items()},
    )


def note_missing(noted: bool) -> None:
    """Prints what follows where files could not be noted as ours."""
    if not noted:
        _print_once(f"note: {notes_folder()} cannot be written, so that --resume will need --trust")


@cache
def _print_once(sentence: str) -> None:
    messages.print(sentence)


def _write(folder: RunFolder, writers: Mapping[str, Callable[[Path], Any]]) -> bool:
    """Writes files that take their places when the last one is complete."""
    noted = True
    with ExitStack() as all_written:
        for name, write in writers.items():
            scratch = all_written.enter_context(folder.replacing(name))
            write(scratch)
            # Noted before it is in its place: a run that is killed in between is still ours.
            noted &= note(scratch, folder / name)
    return noted
