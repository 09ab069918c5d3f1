"""A learner of Stable-Baselines3: environments, start, and a resume that is exact bit for bit."""

import io
from copy import deepcopy
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from ...checks import HIGHEST_SEED
from ...envs.making import make_arms
from ...envs.policies.network import Residual
from ...envs.policies.saving import network_of
from ...errors import InputError, install_line
from ..folders import RunFolder
from .hyperparameters import algorithm_class, arguments

REPLAY = "replay.pkl"  # replay buffer in a checkpoint
MONITORED = ("episode_returns", "episode_lengths")
LSTM_STATES = "_last_lstm_states"


def begin_torch(threads: int) -> None:
    """Sets the number of threads of torch; refuses to train where torch is not installed."""
    try:
        import torch
    except ImportError as error:
        raise InputError(
            "training needs torch: use `make train` in a clone of the repository, or "
            f"{install_line('train')}"
        ) from error
    torch.set_num_threads(threads)


def training_seeds(seed: int, count: int, part: int = 0) -> list[int]:
    """Returns seeds of rows for a part of a training, which differ from all other parts.

    Gymnasium gives row i the seed `seed + i`, so that the trainings 0 and 1 would have the same
    motions and persons in all rows except one.
    """
    drawn = np.random.SeedSequence((seed, part)).generate_state(count, np.uint64)
    return (drawn & np.uint64(HIGHEST_SEED)).tolist()


def training_environments(
    env: str, rows: int, options: dict[str, Any], residual: Residual | None = None
) -> Any:
    """Returns the environments of a training as an environment of Stable-Baselines3."""
    from stable_baselines3.common.vec_env import VecMonitor

    from ...envs.sb3 import ArmVecEnv, ResidualVecEnv

    arms = make_arms(env, rows, **options, autoreset_mode="SameStep", stagger=True)
    rows_of_arms: Any = ArmVecEnv(arms)
    if residual is not None:
        rows_of_arms = ResidualVecEnv(rows_of_arms, residual.policy, residual.scale)
    return VecMonitor(rows_of_arms)


def new_learner(
    algo: str, environments: Any, folder: RunFolder, seed: int, settings: dict[str, Any]
) -> Any:
    """Returns an untrained learner; the network of a correction begins with the output zero."""
    import torch

    usual = {"env": environments, "seed": seed, "device": "cpu"}
    usual["tensorboard_log"] = str(folder.subfolder("tensorboard"))
    try:
        learner = algorithm_class(algo)(**usual, **arguments(deepcopy(settings)))
    except InputError:
        raise
    except Exception as error:  # a value of the wrong kind can raise any error
        raise InputError(
            f"{algo} refuses its hyperparameters ({type(error).__name__}: {error}): change the file"
        ) from error
    network_of(learner)  # refuses a learner without a network that can be exported
    if _residual(environments):
        policy = learner.policy
        last = policy.actor.mu if hasattr(policy, "actor") else policy.action_net
        with torch.no_grad():
            last.weight.zero_()
            last.bias.zero_()
    return learner


def check_finite(learner: Any) -> None:
    """Checks that all numbers of a learner's networks are finite."""
    import torch

    if not all(torch.isfinite(one).all() for one in learner.policy.parameters()):
        raise InputError(
            f"the training diverged within {learner.num_timesteps} steps, as numbers of its "
            "network are not finite: use a smaller learning_rate"
        )


def update_length(learner: Any) -> int:
    """Returns the number of steps between two updates of a learner."""
    return learner.n_envs * (getattr(learner, "n_steps", None) or learner.train_freq.frequency)


def draw_anew(learner: Any, seed: int) -> None:
    """Seeds the random numbers until the next update by the seed and the number of steps so far.

    So a resumed training draws the same random numbers as an uninterrupted training.
    """
    drawn = np.random.SeedSequence((seed, learner.num_timesteps)).generate_state(1)
    learner.set_random_seed(int(drawn[0]))
    if getattr(learner, "use_sde", False):  # the noise of the next rollout is drawn already
        learner.policy.reset_noise(learner.n_envs)


def save_learner(learner: Any, path: Path) -> None:
    """Writes a learner, its replay buffer, and the state of its arms into one file."""
    monitor, residual = learner.env, _residual(learner.env)
    learner.memory = {
        "arms": monitor.unwrapped.arms.get_state(),
        "monitor": {name: getattr(monitor, name).copy() for name in MONITORED},
        "residual": residual and residual.get_memory(),
        LSTM_STATES: getattr(learner, LSTM_STATES, None),
    }
    learner.save(path)
    if hasattr(learner, "save_replay_buffer"):
        learner.save_replay_buffer(experience := io.BytesIO())
        with ZipFile(path, "a") as archive:  # one file, so that all parts are of the same step
            archive.writestr(REPLAY, experience.getbuffer())


def resumed_learner(algo: str, environments: Any, content: bytes, path: Path) -> Any:
    """Returns the learner of a checkpoint; this runs any code that the checkpoint holds.

    The resumed training gives the same numbers as an uninterrupted training, to the last bit.
    """
    file = io.BytesIO(content)
    try:
        learner = algorithm_class(algo).load(
            file, env=environments, device="cpu", force_reset=False
        )
        if hasattr(learner, "load_replay_buffer"):
            with ZipFile(file) as archive:
                learner.load_replay_buffer(io.BytesIO(archive.read(REPLAY)))
        if (memory := getattr(learner, "memory", None)) is None:
            learner._last_obs = None  # a checkpoint before the first episode
            return learner
        environments.reset()
        arms, state = environments.unwrapped.arms, memory["arms"]
        # The path of the suit file changes when the folder of the run is moved.
        state["config"]["suit"] = arms.get_state()["config"]["suit"]
        arms.set_state(state)
        for name in MONITORED:
            getattr(environments, name)[:] = memory["monitor"][name]
        if memory["residual"]:
            _residual(environments).set_memory(memory["residual"])
        setattr(learner, LSTM_STATES, memory[LSTM_STATES])
    except Exception as error:  # a damaged file can raise any error
        raise unreadable(path, error) from error
    return learner


def unreadable(path: Path, error: Exception) -> InputError:
    """Returns the message about a checkpoint that cannot be restored."""
    reason = next(iter(str(error).splitlines()), type(error).__name__)
    return InputError(
        f"{str(path)!r} is not a readable checkpoint ({reason}): restore it, or train again"
    )


def _residual(environments: Any) -> Any:
    """Returns the layer of environments that adds a correction to a policy, or None."""
    below = getattr(environments, "venv", None)
    return below if hasattr(below, "residual") else None
