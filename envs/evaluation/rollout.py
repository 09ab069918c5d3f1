"""Runs policies in closed loop, and keeps what happened."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.vector import AutoresetMode

from ...arrays import Array
from ...errors import InputError
from ..policies.base import Policy
from ..policies.guard import Guard
from ..reward import cost_terms, is_success
from ..simulation.kinematics import Arm
from ..simulation.measurements import COLUMNS
from ..tasks import Task
from ..vector_env import ArmVectorEnv

SERIES = (
    *("angle", "rate", "target_angle", "human_torque", "suit_torque", "assist_torque"),
    "effort",
)


@dataclass(frozen=True, eq=False)
class Trace:
    """Time series of one episode, sampled after every control period.

    Attributes:
        time: Time since the reset [s], shape (n,).
        angle: Joint angles [rad], shape (n, 4), columns as `JOINTS`.
        rate: Joint rates [rad/s], shape (n, 4).
        target_angle: Intended angles [rad], shape (n, 4).
        human_torque: The wearer's torque [N·m], shape (n, 4).
        suit_torque: The suit's torque on the joints [N·m], shape (n, 4).
        assist_torque: The motors' torque [N·m], shape (n, 2), columns as `ASSISTED`.
        effort: The wearer's torque over the strength of a still joint, shape (n, 4).
        hand: Place of the grip in the world [m], shape (n, 3).
        cuff_force: Force of the cuffs on upper arm, forearm and hand [N], shape (n, 3, 3); None
            without cuffs.
        assist_energy: Energy of the motors, the integral of |torque x rate| [J].
        rewards: Reward of each control period, shape (n,).
        costs: Cost terms of the episode, as `info["cost_terms"]` at its end.
        guarded: Number of control periods in which the policy's guard lessened a torque; None where
            it has none.
        success: Whether the episode went well, as `info["is_success"]` at its end.
        terminated: Whether the episode ended by failure.
        periods: Number of control periods of the whole motion, however early the episode ended.
        arm: The wearer's arm.
    """

    time: Array
    angle: Array
    rate: Array
    target_angle: Array
    human_torque: Array
    suit_torque: Array
    assist_torque: Array
    effort: Array
    hand: Array
    cuff_force: Array | None
    assist_energy: float
    rewards: Array
    costs: dict[str, float]
    guarded: int | None
    success: bool
    terminated: bool
    periods: int
    arm: Arm


def rollout(
    arms: ArmVectorEnv,
    policy: Policy,
    seeds: Sequence[int],
    *,
    learned: Mapping[str, Array] | None = None,
    on_step: Callable[[int], None] = lambda _: None,
) -> list[Trace]:
    """Runs one whole episode in every row, all under one policy.

    Args:
        arms: Vector environment with as many rows as seeds.
        policy: Policy that acts on the observations of all rows.
        seeds: Seed of each row; the row's episode is the first of that seed.
        learned: What the wearers have learned [N·m], shape (rows, samples, 4) each, as options of a
            reset, for arms that were made with learned_torque=True.
        on_step: Function that is called before every control period with its number, from 0.

    Returns:
        The episode of every row; one that is lost ends earlier than the others.

    Raises:
        InputError: The rows have another `autoreset_mode` than "NextStep", or are staggered.
    """
    if arms.autoreset_mode is not AutoresetMode.NEXT_STEP or arms.staggered:
        raise InputError(
            f"autoreset_mode is {arms.autoreset_mode.value!r} and stagger is {arms.staggered}: "
            "whole episodes need 'NextStep' without stagger, so leave both out"
        )
    observation, _ = arms.reset(seed=list(seeds), options=dict(learned or {}))
    policy.reset()
    measured, rewards = [], []
    guarded = np.zeros(len(seeds), np.int64)
    ends = np.zeros(len(seeds), np.int64)  # control periods of finished episodes
    failed = np.zeros(len(seeds), np.bool_)
    costs = np.zeros_like(arms.episodes.costs)
    while (ends == 0).any():
        on_step(len(rewards))
        observation, reward, terminated, truncated, _ = arms.step(policy.act(observation))
        measured.append(arms.measured())
        rewards.append(reward)
        ended = (ends == 0) & (terminated | truncated)
        ends[ended], failed[ended] = len(rewards), terminated[ended]
        costs[ended] = arms.episodes.costs[ended]
        if isinstance(policy, Guard):
            guarded[ended] = policy.acted[ended]
    series, returns = np.array(measured), np.array(rewards)
    limits = arms.episodes.simulation.state.episode.limit
    wearers = arms.episodes.simulation.state.conditions.wearer
    return [
        _trace(
            series[:end, row],
            returns[:end, row],
            costs[row],
            guarded=int(guarded[row]) if isinstance(policy, Guard) else None,
            terminated=bool(failed[row]),
            periods=int(limits[row]),
            task=arms.episodes.task,
            arm=arms.episodes.simulation.arm_of(int(wearers[row])),
            cuffs=arms.has_cuffs,
        )
        for row, end in enumerate(ends.tolist())
    ]


def _trace(
    measured: Array,
    rewards: Array,
    costs: Array,
    *,
    guarded: int | None,
    terminated: bool,
    periods: int,
    task: Task,
    arm: Arm,
    cuffs: bool,
) -> Trace:
    force = measured[:, COLUMNS["cuff_force"]].reshape(len(measured), 3, 3)
    return Trace(
        time=measured[:, COLUMNS["time"].start],
        **{name: measured[:, COLUMNS[name]] for name in SERIES},
        hand=arm.in_world(measured[:, COLUMNS["angle"]]),
        cuff_force=force if cuffs else None,
        assist_energy=float(measured[-1, COLUMNS["assist_energy"].start]),
        rewards=rewards,
        costs=cost_terms(costs, len(rewards)),
        guarded=guarded,
        success=is_success(costs, len(rewards), task, ended=terminated),
        terminated=terminated,
        periods=periods,
        arm=arm,
    )
