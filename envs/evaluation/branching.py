"""Counterfactuals: what the next second of one motion would be under each of some policies.

A base policy moves the arm up to a branch point, and its whole state there is kept. From it the
motion goes on under each policy in turn, with the same wearer, intention and noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...checks import check_seed, number, once
from ...errors import InputError
from ..model import ASSISTED
from ..policies import AnyPolicy, Policy, PolicySpec, make_policy, needed_options, policy_spec
from ..simulation.measurements import COLUMNS
from ..vector_env import ArmVectorEnv
from .bounds import BOUNDS, clairvoyant
from .wearers import Wearers

BEST = "best-known-plan"
SERIES = (
    *("angle", "target_angle", "human_torque", "suit_torque", "assist_torque"),
    "effort",
)
Observation = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Stretch:
    """A stretch of one motion, sampled after every control period.

    Attributes:
        time: Time since the reset [s], shape (n,).
        angle: Joint angles [rad], shape (n, 4), columns as `JOINTS`.
        target_angle: Intended angles [rad], shape (n, 4).
        human_torque: The wearer's torque [N·m], shape (n, 4).
        suit_torque: The suit's torque on the joints [N·m], shape (n, 4).
        assist_torque: The motors' torque [N·m], shape (n, 2), columns as `ASSISTED`.
        effort: The wearer's torque over the strength of a still joint, shape (n, 4).
        lost: Whether it ended because the arm was lost.
    """

    time: Array
    angle: Array
    target_angle: Array
    human_torque: Array
    suit_torque: Array
    assist_torque: Array
    effort: Array
    lost: bool = False

    @property
    def mean_effort(self) -> float:
        """Root mean square of the effort over time and joints."""
        return _rms(self.effort)

    def to_dict(self) -> dict[str, Any]:
        """Returns what the stretch amounts to, as plain values; torque and error by joint."""
        return {
            "effort": self.mean_effort,
            "tracking_rad": self.tracking,
            "human_torque_nm": _rms_by(JOINTS, self.human_torque),
            "suit_torque_nm": _rms_by(JOINTS, self.suit_torque),
            "assist_torque_nm": _rms_by(ASSISTED, self.assist_torque),
            "lost": self.lost,
        }

    @property
    def tracking(self) -> float:
        """Root mean square of the tracking error over time and joints [rad]."""
        return _rms(self.angle - self.target_angle)


@dataclass(frozen=True, eq=False)
class Fork:
    """One state of a motion, and what would follow from it.

    Attributes:
        at: Time of the branch point [s].
        past: The motion up to it under the base policy, which all branches share.
        futures: What follows under each policy, by its name, and under the best known plan.
    """

    at: float
    past: Stretch
    futures: dict[str, Stretch]

    def regret(self, policy: str) -> float:
        """Returns the effort under a policy less that under the best known plan.

        Both are means over the branch, so that this is what every second of it costs more.
        """
        return self.futures[policy].mean_effort - self.futures[BEST].mean_effort

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers of every branch as plain values."""
        futures = {
            name: {**one.to_dict(), "regret": self.regret(name)}
            for name, one in self.futures.items()
        }
        return {"at": self.at, "past": self.past.to_dict(), "futures": futures}


def branch(
    env_id: str,
    policies: Sequence[AnyPolicy],
    *,
    base: AnyPolicy = "feedforward",
    at: Sequence[float] = (2.0,),
    horizon: float = 1.0,
    seed: int = 0,
    **env_options: Any,
) -> list[Fork]:
    """Moves an arm under a base policy, and from each branch point on under each policy.

    Every policy has watched: it got the observations of the past, so that its memory is right, and
    what it answered to them did not count. The bounds plan the whole motion, and their plans are
    taken from the branch point on. The wearer has learned nothing of suit and exoskeleton, because
    what a wearer would have learned depends on the policy. An arm that is lost ends its branch.

    Args:
        env_id: Id of a registered environment.
        policies: Policies as `policy_spec` takes them, or names of bounds.
        base: Policy of the past.
        at: Times of the branch points [s].
        horizon: Duration of a branch [s].
        seed: Seed of the motion.
        **env_options: Options of the environment (`suit`, `gravity`, ...). The sensors are all that
            any of the policies needs.

    Returns:
        A fork for each branch point.

    Raises:
        InputError: An environment or policy is unknown, a branch would begin before the motion or
            end after it, or the base policy loses the arm before.
    """
    check_seed(seed)
    if not len(at):
        raise InputError("no branch point is given: name at least one time")
    chosen = [one if one in BOUNDS else policy_spec(one, beside=BOUNDS) for one in policies]
    once("policies", chosen)
    once("branch points", at)
    named = {str(one): one for one in (*chosen, BEST)}
    past_spec = policy_spec(base)
    causal = [past_spec, *(one for one in named.values() if not isinstance(one, str))]
    wearers = Wearers(env_id, 1, **{**env_options, **_seeing(causal)})
    arms = wearers.arms
    points = [_period(arms, one, horizon) for one in at]
    made = {name: _made(one, wearers, seed) for name, one in named.items()}
    states, seen, measured = _moved(arms, make_policy(past_spec, arms), seed, points)
    forks = []
    for point, state in zip(points, states, strict=True):
        futures = {}
        for name, policy in made.items():
            arms.set_state(state)
            observation = _watched(policy, seen[: point + 1])
            futures[name] = _stretch(
                *_run(arms, policy, observation, round(horizon / arms.control_dt))
            )
        forks.append(Fork(point * arms.control_dt, _stretch(measured[:point]), futures))
    wearers.close()
    return forks


def _seeing(specs: Sequence[PolicySpec]) -> dict[str, Any]:
    """Returns options of an environment with the sensors of all policies, each once."""
    needed = (needed_options(one).get("sensors", ()) for one in specs)
    sensors = list(dict.fromkeys(name for names in needed for name in names))
    return {"sensors": sensors or ["encoders"], "normalize": False, "history": 1}


def _made(given: PolicySpec | str, wearers: Wearers, seed: int) -> Policy:
    if isinstance(given, str):
        return clairvoyant(wearers, [seed], suit_only=given != BEST)
    return make_policy(given, wearers.arms)


def _period(arms: ArmVectorEnv, at: float, horizon: float) -> int:
    """Returns the number of control periods before a branch point."""
    number("at", at, "s")
    number("horizon", horizon, "s")
    if not horizon >= arms.control_dt:
        raise InputError(f"horizon is {horizon:g} s: give at least {arms.control_dt:g} s")
    last = arms.duration - horizon
    if last < arms.control_dt:
        raise InputError(
            f"horizon is {horizon:g} s, and the motion takes {arms.duration:g} s: give less"
        )
    if not arms.control_dt <= at <= last + 1e-9:
        raise InputError(
            f"a branch of {horizon:g} s begins at {at:g} s: begin at {arms.control_dt:g} to "
            f"{last:g} s, as the motion takes {arms.duration:g} s"
        )
    return round(at / arms.control_dt)


def _moved(
    arms: ArmVectorEnv, policy: Policy, seed: int, points: Sequence[int]
) -> tuple[list[dict[str, Any]], list[Observation], list[Array]]:
    """Moves the arm up to the last point; returns the states at all points and what was seen.

    The observations begin before the first period, the measurements after it.
    """
    observation, _ = arms.reset(seed=[seed])
    policy.reset()
    seen, measured, states = [observation], [], {}
    for period in range(1, max(points) + 1):
        observation, _, terminated, _, _ = arms.step(policy.act(observation))
        if terminated.any():
            raise InputError(
                f"the base policy loses the arm after {period * arms.control_dt:g} s: branch "
                "before, or take another one"
            )
        seen.append(observation)
        measured.append(arms.measured()[0])
        if period in points:
            states[period] = arms.get_state()
    return [states[point] for point in points], seen, measured


def _watched(policy: Policy, seen: Sequence[Observation]) -> Observation:
    """Shows the past to a policy, whose answers do not count; returns the present observation."""
    policy.reset()
    for observation in seen[:-1]:
        policy.act(observation)
    return seen[-1]


def _run(
    arms: ArmVectorEnv, policy: Policy, observation: Observation, periods: int
) -> tuple[list[Array], bool]:
    """Moves the arm on; returns its measurements and whether it was lost."""
    measured = []
    for _ in range(periods):
        observation, _, terminated, _, _ = arms.step(policy.act(observation))
        measured.append(arms.measured()[0])
        if terminated.any():
            return measured, True
    return measured, False


def _stretch(measured: Sequence[Array], lost: bool = False) -> Stretch:
    rows = np.array(measured)
    return Stretch(
        time=rows[:, COLUMNS["time"].start],
        **{name: rows[:, COLUMNS[name]] for name in SERIES},
        lost=lost,
    )


def _rms_by(joints: Sequence[str], torque: Array) -> dict[str, float]:
    return {joint: _rms(torque[:, column]) for column, joint in enumerate(joints)}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
