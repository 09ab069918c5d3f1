"""The speed of training by PPO in rows, against single arms, and where the time goes."""

import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..scripts.folders import RunFolder
from ..scripts.training.hyperparameters import algorithm_class, hyperparameters
from ..scripts.training.learner import begin_torch, new_learner, training_environments
from ..tables import Rows
from .timing import Row, compare

ENV, OPTIONS = "ActiveSuit/ArmTracking-v0", {"gravity": "microgravity"}
STEPS = 8192  # a measurement has whole updates of every learner
PASSES = 500
BEFORE = {"n_envs": 8, "n_steps": 256, "batch_size": 256, "n_epochs": 10}  # version 0.1 had them
AS_LONG = {"n_envs": 8, "n_steps": 1024}  # an update has as many steps as one of 64 rows
PARTS = ("environment", "forward passes", "update")
MILLION = 1_000_000
RATIO, SHARE, MINUTES = 3.0, 40.0, 5.0  # goals: at least 3 times, at most 40 % and 5 minutes


@dataclass(frozen=True, kw_only=True)
class Training:
    """Speed of a learner, and the shares of its time, each the median of the measurements.

    Attributes:
        what: Name of the learner.
        speed: Environment steps per second.
        slowest: Least steps per second of a measurement.
        fastest: Most steps per second of a measurement.
        minutes: Time of one million steps at that speed [min].
        shares: Shares of the time by part: the environment's steps and resets, the forward passes
            between them, and the updates of the networks.
    """

    what: str
    speed: float
    slowest: float
    fastest: float
    minutes: float
    shares: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


class _Learner:
    """A learner that trains on at every call, and the times of its parts.

    Attributes:
        times: Time of each part in each call, and of "all" [s].
    """

    def __init__(self, environments: Any, folder: RunFolder, settings: dict[str, Any]) -> None:
        self.ppo = new_learner("ppo", environments, folder, 0, settings)
        self.times: list[defaultdict[str, float]] = []
        clocked = zip(
            PARTS,
            (environments, self.ppo.policy, self.ppo),
            (("reset", "step"), ("forward", "predict_values"), ("train",)),
            strict=True,
        )
        for part, owner, names in clocked:
            for name in names:
                setattr(owner, name, self._clocked(part, getattr(owner, name)))

    def __call__(self) -> None:
        self.times.append(defaultdict(float))
        self._clocked("all", self.ppo.learn)(STEPS, reset_num_timesteps=False)

    def _clocked(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*values: Any, **named: Any) -> Any:
            begun = time.perf_counter()
            try:
                return function(*values, **named)
            finally:
                self.times[-1][part] += time.perf_counter() - begun

        return run

    def summary(self, what: str) -> Training:
        """Returns medians of all calls but the first, which warms up."""
        measured = self.times[1:]
        speeds = [STEPS / one["all"] for one in measured]
        speed = statistics.median(speeds)
        return Training(
            what=what,
            speed=speed,
            slowest=min(speeds),
            fastest=max(speeds),
            minutes=MILLION / speed / 60,
            shares={
                part: statistics.median(one[part] / one["all"] for one in measured)
                for part in PARTS
            },
        )


def training(repeats: int) -> tuple[list[Row], list[Training]]:
    """Trains in rows and in single arms by turns; the networks and the task are the same.

    Args:
        repeats: Number of pairs of measurements.

    Returns:
        What is compared with something else or with a goal, and the speed of each learner.

    Raises:
        InputError: The extra `train` is not installed.
    """
    algorithm_class("ppo")
    from stable_baselines3.common.env_util import make_vec_env

    usual = hyperparameters("ppo", ENV)
    with ExitStack() as opened:
        begin_torch(1)
        folder = RunFolder(Path(opened.enter_context(tempfile.TemporaryDirectory())))

        def in_rows() -> _Learner:
            arms = training_environments(ENV, usual["n_envs"], OPTIONS)
            return _Learner(opened.enter_context(closing(arms)), folder, usual)

        def in_single_arms(changes: dict[str, int]) -> _Learner:
            arms = make_vec_env(ENV, changes["n_envs"], seed=0, env_kwargs=OPTIONS)
            return _Learner(opened.enter_context(closing(arms)), folder, {**usual, **changes})

        shared: dict[str, Any] = {"repeats": repeats, "unit": "us/step", "count": STEPS}
        ours, before, as_long = in_rows(), in_single_arms(BEFORE), in_single_arms(AS_LONG)
        name = f"PPO in {usual['n_envs']} rows"
        single = f"PPO in {BEFORE['n_envs']} single arms"
        first, second = f"{single}, as version 0.1", f"{single}, updates as in rows"
        rows = [
            compare(name, ours, first, before, target=RATIO, **shared),
            compare(name, ours, second, as_long, **shared),
        ]
        found = [ours.summary(name), before.summary(first), as_long.summary(second)]
        share = 100 * found[0].shares["environment"]
        rows += [
            Row(what=f"{name}, share of environment", unit="%", ours=share, limit=SHARE),
            Row(what=f"{name}, million steps", unit="min", ours=found[0].minutes, limit=MINUTES),
            _forward_passes(ours.ppo, repeats),
        ]
    return rows, found


def _forward_passes(ppo: Any, repeats: int) -> Row:
    """Times what a step of a rollout asks of the networks: actions, their densities, values."""
    import torch

    from ..envs.policies.saving import network_of

    observation, actor = ppo._last_obs, network_of(ppo)
    critic = actor  # as large but for one output less, and so as fast
    memory, rng = actor.memory(ppo.n_envs), np.random.default_rng(0)
    log_std = np.full(actor.outputs, -2.0)  # the numbers make no difference to the time

    def in_numpy() -> tuple[Array, ...]:
        noise = rng.standard_normal((ppo.n_envs, actor.outputs))
        action = actor.act(observation, memory) + np.exp(log_std) * noise
        density = -(0.5 * noise**2 + log_std + 0.5 * np.log(2 * np.pi)).sum(axis=1)
        return action, critic.act(observation, memory), density

    @torch.no_grad()
    def in_torch() -> tuple[Any, ...]:
        action, value, density = ppo.policy(torch.as_tensor(observation))
        return action.numpy(), value, density

    return compare(
        f"forward passes of {ppo.n_envs} rows in NumPy",
        lambda: [in_numpy() for _ in range(PASSES)],
        "those of Stable-Baselines3 in torch",
        lambda: [in_torch() for _ in range(PASSES)],
        repeats=repeats,
        unit="us/pass",
        count=PASSES,
    )


def training_table(found: Sequence[Training]) -> Rows:
    """Returns the table of the learners: header and rows."""
    header = ["learner", "steps\nper s", "slowest\nfastest", "environ-\nment [%]"]
    header += ["forward\npasses [%]", "update\n[%]", "million\nsteps [min]"]
    rows = []
    for one in found:
        speed, spread = f"{one.speed:,.0f}", f"{one.slowest:,.0f}\n{one.fastest:,.0f}"
        shares = (f"{100 * share:.0f}" for share in one.shares.values())
        rows.append([one.what, speed, spread, *shares, f"{one.minutes:.1f}"])
    return header, rows
