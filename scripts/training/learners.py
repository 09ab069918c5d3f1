"""Learners of Stable-Baselines3, and the environments that they learn in."""

from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import Any

import numpy as np

from ...checks import HIGHEST_SEED
from ...envs.making import make_arms
from ...envs.policies.network import Residual
from ...envs.policies.saving import network_of
from ...errors import InputError
from ..output import RunFolder
from .hyperparameters import algorithm_class, arguments


def training_seeds(seed: int, rows: int, part: int = 0) -> list[int]:
    """Returns a seed for each row of arms in a training, which no other one has.

    With Gymnasium's own, where row i has seed + i, the trainings 0 and 1 would meet the same
    motions and persons in all rows but one.

    Args:
        seed: Seed of the training.
        rows: Number of rows.
        part: Number of the part of the training, where each part begins with new seeds.
    """
    drawn = np.random.SeedSequence((seed, part)).generate_state(rows, np.uint64)
    return (drawn & np.uint64(HIGHEST_SEED)).tolist()


def training_environments(
    env: str, rows: int, options: dict[str, Any], residual: Residual | None = None
) -> Any:
    """Returns the environments that a learner trains in, as one of Stable-Baselines3.

    Args:
        env: Id of the environment.
        rows: Number of arms.
        options: Options of the environment.
        residual: Policy that the learner corrects; None if it acts alone.
    """
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
    """Returns a learner that knows nothing yet."""
    logs = str(folder.subfolder("tensorboard"))
    usual = {"seed": seed, "device": "cpu", "tensorboard_log": logs}
    try:
        learner = algorithm_class(algo)(
            settings["policy"], environments, **usual, **arguments(deepcopy(settings))
        )
    except InputError:
        raise
    except Exception as error:  # whatever a value of the wrong kind leads to
        raise InputError(
            f"{algo} refuses its hyperparameters ({type(error).__name__}: {error}): change the file"
        ) from error
    network_of(learner)
    if hasattr(getattr(environments, "venv", None), "residual"):
        _begin_at_zero(learner)
    return learner


def check_finite(learner: Any) -> None:
    """Checks the numbers of a learner's networks."""
    import torch

    if not all(torch.isfinite(one).all() for one in learner.policy.parameters()):
        raise InputError(
            f"the training diverged within {learner.num_timesteps} steps, as numbers of its "
            "network are not finite: use a smaller learning_rate"
        )


def _begin_at_zero(learner: Any) -> None:
    """Makes the mean action of a learner zero, so that a residual begins as the policy alone."""
    import torch

    policy = learner.policy
    last = policy.actor.mu if hasattr(policy, "actor") else policy.action_net
    with torch.no_grad():
        last.weight.zero_()
        last.bias.zero_()


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
