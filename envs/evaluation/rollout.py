"""Runs policies in closed loop, and keeps the motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from ...arrays import Array
from ...errors import InputError
from ..interface.reward import cost_terms
from ..person import strength_limits
from ..policies.base import Policy
from ..simulation.inverse_dynamics import Chain
from ..simulation.kinematics import Arm
from ..simulation.measurements import COLUMNS
from ..tasks.task import ROUNDING, Limit
from ..vector_env import ArmVectorEnv
from .reasons import Reason, reasons

SERIES = ("angle", "rate", "target_angle", "human_torque", "suit_torque", "assist_torque", "effort")
SOME = {"cuff_force": (3, 3), "fatigue": (2, 4), "motor_load": (2,)}  # series that some arms lack
NO_GUARD = np.zeros(0, np.int64)
FULL = 0.999  # share of the peak torque from which a motor counts as saturated


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
        guarded: Number of control periods in which the policy's guard reduced a torque; None
            without a guard.
        why: Limits of success that the episode exceeded; none for a success.
        limits: Limits of success of its task.
        strength: Torque that the extensors and the flexors of each joint could give at rest in the
            posture of the moment, with their fatigue [N·m], shape (n, 2, 4).
        fatigue: Fatigued part of the extensors and the flexors of each joint, shape (n, 2, 4); None
            where muscles do not tire.
        motor_load: Running root mean square of the motors' torque over the continuous torque, a
            measure of heat, shape (n, 2); a motor at 1 is hot and limited to the continuous torque.
            None without motors.
        peak_torque: Peak torque of the motors [N·m], shape (2,); None without motors.
        terminated: Whether the episode ended by failure.
        periods: Number of control periods of the whole motion, also of an episode that ended early.
        arm: The wearer's arm.
        dressed: Links of the arm with suit and load, but without exoskeleton.
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
    why: tuple[Reason, ...]
    limits: tuple[Limit, ...]
    strength: Array
    fatigue: Array | None
    motor_load: Array | None
    peak_torque: Array | None
    terminated: bool
    periods: int
    arm: Arm
    dressed: Chain

    @property
    def success(self) -> bool:
        """Whether the episode exceeded no limit of success, as `info["is_success"]` at its end."""
        return not self.why

    @property
    def hot_from(self) -> tuple[float, ...]:
        """First time at which each motor was hot [s]; infinite for a motor that never was."""
        if self.motor_load is None:
            return ()
        hot = self.motor_load >= 1 - ROUNDING
        return tuple(float(self.time[one.argmax()]) if one.any() else np.inf for one in hot.T)

    @property
    def saturated(self) -> tuple[float, ...]:
        """Share of time in which each motor gave its peak torque."""
        if self.peak_torque is None:
            return ()
        return tuple(
            np.mean(np.abs(self.assist_torque) >= FULL * self.peak_torque, axis=0).tolist()
        )


def rollout(
    arms: ArmVectorEnv,
    policy: Policy,
    seeds: Sequence[int],
    *,
    learned: Mapping[str, Array] | None = None,
) -> list[Trace]:
    """Runs one whole episode in every row, all under one policy.

    Args:
        arms: Vector environment with as many rows as seeds.
        policy: Policy that acts on the observations of all rows.
        seeds: Seed of each row; the row's episode is the first of that seed.
        learned: Torques that the wearers have learned [N·m], shape (rows, samples, 4) each, as
            options of a reset, for arms that were made with learned_torque=True.

    Returns:
        The episode of every row; an episode ends early if the arm is lost.
    """
    if arms.autoreset_mode is not AutoresetMode.NEXT_STEP or arms.staggered:
        raise InputError(
            f"autoreset_mode is {arms.autoreset_mode.value!r} and stagger is {arms.staggered}: "
            "rollout needs 'NextStep' without stagger: leave both options out"
        )
    observation, _ = arms.reset(seed=list(seeds), options=dict(learned or {}))
    policy.reset()
    measured, rewards, courses = [], [], []
    guarded, ends = np.zeros((2, len(seeds)), np.int64)  # control periods
    failed, acted = np.zeros(len(seeds), np.bool_), NO_GUARD
    while (ends == 0).any():
        observation, reward, terminated, truncated, _ = arms.step(policy.act(observation))
        measured.append(arms.measured())
        rewards.append(reward)
        courses.append(arms.episodes.costs.copy())
        ended = (ends == 0) & (terminated | truncated)
        ends[ended], failed[ended] = len(rewards), terminated[ended]
        acted = getattr(policy, "acted", NO_GUARD)
        if acted.size:
            guarded[ended] = acted[ended]
    series, returns, costs = np.array(measured), np.array(rewards), np.array(courses)
    episodes, simulation = arms.episodes, arms.episodes.simulation
    state, found = simulation.state, []
    for row, end in enumerate(ends.tolist()):
        now = series[:end, row]
        columns: dict[str, Any] = {name: now[:, COLUMNS[name]] for name in SERIES}
        for name, shape in SOME.items():
            present = name in simulation.columns
            columns[name] = now[:, COLUMNS[name]].reshape(end, *shape) if present else None
        strength, angle = state.muscles.strength[row], columns["angle"]
        arm = simulation.arm_of(int(state.conditions.wearer[row]))
        trace = Trace(
            **columns,
            time=now[:, COLUMNS["time"].start],
            hand=arm.in_world(angle),
            strength=strength_left(strength, angle, columns["fatigue"]),
            peak_torque=simulation.addresses.peak_torque if episodes.motors else None,
            assist_energy=float(now[-1, COLUMNS["assist_energy"].start]),
            rewards=returns[:end, row],
            costs=cost_terms(costs[end - 1, row], end),
            guarded=int(guarded[row]) if acted.size else None,
            why=reasons(now, costs[:end, row], episodes.task, lost=bool(failed[row])),
            limits=episodes.task.limits,
            terminated=bool(failed[row]),
            periods=int(state.episode.limit[row]),
            arm=arm,
            dressed=simulation.dressed(row),
        )
        found.append(trace)
    return found


def strength_left(strength: Array, angle: Array, fatigue: Array | None) -> Array:
    """Returns the torque of extensors and flexors of each joint at rest [N·m], shape (n, 2, 4).

    `strength` is as of `isometric_strength`, angles [rad] are (n, 4), fatigued parts (n, 2, 4).
    """
    low, high = strength_limits(strength, angle, np.zeros_like(angle))
    left = np.stack([-low, high], axis=1)
    return left if fatigue is None else left * (1 - fatigue)
