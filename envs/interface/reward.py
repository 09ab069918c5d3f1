"""The reward of a control period, in [0, 1], and the costs that are reported beside it.

With x the root mean square over four joints of torque over strength, e the root mean square of the
tracking error, and d the root mean square of the command's change over both motors,

    reward = 1 / (1 + (x / E)² + (e / 0.1 rad)² + (d / 0.25)²)

where E is the effort of the suited arm without an exoskeleton, a constant of the configuration
(`suited_effort`). The reward is never negative, so that an episode that ends early gains nothing.
"""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ..model.cuffs import FORCE_LIMITS
from ..person import isometric_strength, strength_limits
from ..simulation import Simulation
from ..simulation.bound_kernels import bound
from ..simulation.episode_plan import Plan
from ..simulation.inverse_dynamics import Chain, arm_torques
from ..simulation.kinematics import Arm
from ..simulation.measurements import ANGLE, ASSIST, CUFFS, EFFORT, LOAD, RATE, TARGET
from ..simulation.structs import Bools, Episode, Saved, Scratch, Whole, allocated, saved
from ..simulation.wearer_control import COCONTRACTION
from ..tasks import Task
from ..tasks.task import Limit

TERMS = ("effort", "tracking", "smoothness")
ERROR_SCALE = 0.1  # rad
CHANGE_SCALE = 0.25
LOST = 1.0  # [rad], tracking error of an assisted joint that ends an episode
LEAST_EFFORT = 0.01  # share of strength, least effort of an arm

COST_MEANINGS = {
    "cuff_force": "greatest force of a cuff over what a person should bear [1]",
    "heat": "greatest load of a motor over its continuous torque [1]",
    "wrong_way_work": "work of the motors against the motion [J]",
    "chatter": "sum of the squared changes of the action [1]",
    "range_stops": "time in which a joint is at the end of its range [s]",
    "effort": "root mean square of effort [1]",
    "hand_error": "greatest distance of the hand from its place, where it is watched [m]",
    "tilt": "greatest error of the hand's pitch there [rad]",
    "slowness": "greatest share of its intended speed that the hand lacks there [1]",
    "tracking": "root mean square of the tracking error over time and joints [rad]",
    "worst_joint": "root mean square of the tracking error of the worst joint [rad]",
}
COSTS = tuple(COST_MEANINGS)
CUFF, HEAT, WRONG_WAY, CHATTER, STOPS, STRAIN, HAND, TILT, SLOWNESS, JOINT = range(10)
WIDTH = JOINT + len(JOINTS)  # columns of costs; the last are sums of squared errors by joint
TERM, COST = 0, len(TERMS)  # columns at which terms and costs begin
PERIODS, CLIPPED, DIVERGED, ENDED, SUMS = range(COST + WIDTH, COST + WIDTH + 5)
SLOW = 0.01  # [m/s], greatest speed of a hand that need not be quick
NEAR = 0.001  # [rad], distance from the end of its range at which a joint is at its stop
LIMITS = np.array(list(FORCE_LIMITS.values()))  # N
EVERY = 5  # samples between those that `suited_effort` uses


def suited_effort(simulation: Simulation, plans: Sequence[Plan]) -> float:
    """Returns the effort of motions in the suit and without an exoskeleton.

    The effort is the root mean square, over time and four joints, of the torque of inverse dynamics
    and the usual co-contraction over the strength of a still joint. Weight and inertia of the load
    in the hand are part of the torque.
    """
    wearer, dt, squares = simulation.config.wearer, simulation.control_dt, []
    chain, arm = Chain.of(simulation.model, dressed=True), simulation.arm_of(0)
    contraction = simulation.control.impedance(wearer)[COCONTRACTION]
    for plan in plans:
        motion = plan.motion
        angle, rate, acceleration = (part[::EVERY].copy() for part in motion)
        torque = arm_torques(chain, angle, rate, acceleration)
        if plan.mass is not None or plan.push is not None:
            torque += arm.torque_of(angle, _force(arm, plan, dt)[::EVERY])
        for joint, entry in simulation.suit.items():
            column = JOINTS.index(joint)
            time = dt * np.arange(len(motion[0]))
            torque[:, column] += entry.response(motion[0][:, column], time=time)[::EVERY]
        low, high = strength_limits(isometric_strength(wearer), angle, np.zeros_like(angle))
        flexors, extensors = np.maximum(torque, 0), np.maximum(-torque, 0)
        load = np.maximum((flexors + contraction) / high, (extensors + contraction) / -low)
        squares.append(np.mean(load**2))
    return max(LEAST_EFFORT, float(np.sqrt(np.mean(squares))))


def _force(arm: Arm, plan: Plan, dt: float) -> Array:
    """Returns the force of load and push on the grip [N], shape (samples, 3)."""
    force = np.zeros((len(plan.motion[0]), 3)) if plan.push is None else plan.push.copy()
    if plan.mass is not None:
        places = arm.places(plan.motion[0])
        acceleration = np.gradient(np.gradient(places, dt, axis=0), dt, axis=0)
        force += plan.mass[:, None] * (arm.gravity - acceleration)
    return force


class Score(NamedTuple):
    """Rewards and costs of the episodes, and their constants."""

    sums: Annotated[Array, Saved("n sums")]  # reward terms and costs of the episode so far
    reward: Annotated[Array, Scratch("n")]  # reward of the last control period
    terminated: Annotated[Bools, Scratch("n")]
    truncated: Annotated[Bools, Scratch("n")]
    ranges: Array  # ranges of the joints [rad], (4, 2)
    scale: float  # effort of the suited arm
    has_cuffs: bool
    assisted: Whole  # positions of the assisted joints
    faults: Whole  # fault flags of the suits in plugin_state


class Watch(NamedTuple):
    """Places at which a task judges the hand; without samples if it does not judge the hand."""

    watched: Annotated[Bools, Saved("n samples")]  # samples that are judged
    hand_places: Annotated[Array, Saved("n samples 3")]  # intended places of the hand [m]
    last_hand: Annotated[Array, Saved("n 3")]  # place of the hand one control period ago [m]
    hand: Whole  # place of the hand in sensordata, (3,)


class Judged(NamedTuple):
    """Arrays on which `judge` and `judge_hand` work."""

    plugin_state: Array  # state of the suits, (n, size)
    sensordata: Array  # sensors of the physics, (n, size)
    episode: Episode
    change: Array  # last change of the command, (n, motors)
    measured: Array  # measurements, (n, columns)
    score: Score
    watch: Watch


class Judge:
    """Judges the episodes of a task: rewards and costs (`score`), ends, and the hand (`watch`).

    Rewards are scaled by `effort_scale`, the effort of the suited arm over strength.
    """

    def __init__(self, simulation: Simulation, task: Task, effort_scale: float) -> None:
        state, at = simulation.state, simulation.addresses
        samples = simulation.samples if task.watches else 0
        sizes = {"n": simulation.n, "sums": SUMS, "samples": samples}
        self.score = allocated(
            Score,
            sizes,
            ranges=simulation.model.jnt_range[: len(JOINTS)],
            scale=effort_scale,
            has_cuffs="cuff_force" in simulation.columns,
            assisted=at.assisted,
            faults=at.faults,
        )
        self.watch = allocated(Watch, sizes, hand=at.hand)
        self._simulation = simulation
        arms = Judged(
            plugin_state=simulation.plugin_state,
            sensordata=simulation.sensordata,
            episode=state.episode,
            change=state.motors.change,
            measured=state.sensors.measured,
            score=self.score,
            watch=self.watch,
        )
        rows = np.arange(simulation.n)
        self._judge = bound(judge, (rows, True), arms)
        self._look = bound(judge_hand, (rows,), arms) if task.watches else None

    def arrays(self) -> dict[str, NDArray]:
        """Returns the arrays that are state of episodes, by name."""
        marked = {**saved(self.score), **saved(self.watch)}
        return {name: values for name, (values, _) in marked.items()}

    def begin(self, rows: Whole) -> None:
        """Judges the beginning of the episodes of some rows."""
        if self._look:
            hands = self._simulation.sensordata[rows[:, None], self.watch.hand]
            self.watch.last_hand[rows] = hands
        self._judge(rows, False)

    def judge(self, rows: Whole) -> None:
        """Judges the control period that has passed in some rows."""
        self._judge(rows, True)
        if self._look:
            self._look(rows)

    def restore(self, rows: Whole) -> None:
        """Judges the present moment of some rows, without adding to costs."""
        self._judge(rows, False)


@njit(cache=True)
def judge(rows: Whole, moved: bool, arms: Judged) -> None:
    """Computes rewards of the last control period of some rows, and which episodes have ended.

    An episode terminates when the arm is lost, at a pole of the suit's torque, or diverged; the
    last period then earns nothing. If rows have `moved`, the period is added to the costs of their
    episodes.
    """
    change, episode, measured, score = arms.change, arms.episode, arms.measured, arms.score
    sums, assisted = score.sums, score.assisted
    for k in range(rows.shape[0]):
        row = rows[k]
        effort, tracking, unsteady, worst = 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            effort += measured[row, EFFORT + j] ** 2 / 4.0
            tracking += (measured[row, ANGLE + j] - measured[row, TARGET + j]) ** 2 / 4.0
        for j in range(assisted.shape[0]):
            at = assisted[j]
            worst = max(worst, abs(measured[row, ANGLE + at] - measured[row, TARGET + at]))
        for j in range(change.shape[1]):
            unsteady += change[row, j] ** 2 / change.shape[1]
        sums[row, TERM] = effort / score.scale**2
        sums[row, TERM + 1] = tracking / ERROR_SCALE**2
        sums[row, TERM + 2] = unsteady / CHANGE_SCALE**2
        diverged, step = episode.diverged[row], episode.step[row]
        ended = worst > LOST or diverged
        for j in range(score.faults.shape[0]):
            ended = ended or arms.plugin_state[row, score.faults[j]] == 1.0
        score.terminated[row] = ended
        size = sums[row, TERM] + sums[row, TERM + 1] + sums[row, TERM + 2]
        score.reward[row] = 0.0 if ended else 1.0 / (1.0 + size)
        score.truncated[row] = step >= episode.limit[row]
        sums[row, PERIODS], sums[row, CLIPPED] = step, episode.clipped[row]
        sums[row, DIVERGED], sums[row, ENDED] = diverged, ended
        if moved and not diverged:
            for j in range(4):
                error = measured[row, ANGLE + j] - measured[row, TARGET + j]
                sums[row, COST + JOINT + j] += error**2
            sums[row, COST + STRAIN] += effort
            account(row, episode.dt, change, measured, score)


@njit(inline="always")
def account(row: int, dt: float, change: Array, measured: Array, score: Score) -> None:
    """Adds the last control period of a row to the costs of its episode; see `COST_MEANINGS`."""
    sums, ranges = score.sums, score.ranges
    for j in range(change.shape[1]):
        sums[row, COST + HEAT] = max(sums[row, COST + HEAT], measured[row, LOAD + j])
        power = measured[row, ASSIST + j] * measured[row, RATE + score.assisted[j]]
        sums[row, COST + WRONG_WAY] += max(0.0, -power) * dt
        sums[row, COST + CHATTER] += change[row, j] ** 2
    if score.has_cuffs:
        for i in range(3):
            force = 0.0
            for j in range(3):
                force += measured[row, CUFFS + 3 * i + j] ** 2
            sums[row, COST + CUFF] = max(sums[row, COST + CUFF], np.sqrt(force) / LIMITS[i])
    stopped = False
    for j in range(4):
        angle = measured[row, ANGLE + j]
        stopped = stopped or angle < ranges[j, 0] + NEAR or angle > ranges[j, 1] - NEAR
    if stopped:
        sums[row, COST + STOPS] += dt


def cost_terms(costs: Array, periods: Any) -> dict[str, Any]:
    """Returns the costs of one or more episodes by name; see `COST_MEANINGS`.

    Costs have the shape (13,) for one episode and (n, 13) for several; `periods`, the control
    periods since the reset, has the shape () or (n,).
    """
    squares = costs[..., [STRAIN, *range(JOINT, WIDTH)]] / np.maximum(1, periods)[..., None]
    effort, joints = np.sqrt(squares[..., 0]), np.sqrt(squares[..., 1:])
    found = {name: costs[..., column] for column, name in enumerate(COSTS[:JOINT])}
    found |= {"effort": effort, "tracking": np.sqrt(np.mean(joints**2, axis=-1))}
    found["worst_joint"] = joints.max(axis=-1)
    return found if costs.ndim > 1 else {name: float(value) for name, value in found.items()}


@njit(cache=True)
def judge_hand(rows: Whole, arms: Judged) -> None:
    """Updates the greatest errors of the hands of some rows at the samples that are watched."""
    sensordata, episode, measured, watch = arms.sensordata, arms.episode, arms.measured, arms.watch
    sums, places, last = arms.score.sums, watch.hand_places, watch.last_hand
    for k in range(rows.shape[0]):
        row = rows[k]
        now = min(episode.step[row], watch.watched.shape[1] - 1)
        if watch.watched[row, now]:
            error, speed, intended, tilt = 0.0, 0.0, 0.0, 0.0
            for j in range(3):
                place = sensordata[row, watch.hand[j]]
                error += (place - places[row, now, j]) ** 2
                speed += (place - last[row, j]) ** 2
                if now > 0:
                    intended += (places[row, now, j] - places[row, now - 1, j]) ** 2
            for j in range(1, 4):
                tilt += measured[row, ANGLE + j] - measured[row, TARGET + j]
            sums[row, COST + HAND] = max(sums[row, COST + HAND], np.sqrt(error))
            sums[row, COST + TILT] = max(sums[row, COST + TILT], abs(tilt))
            if np.sqrt(intended) > SLOW * episode.dt:
                lacking = 1.0 - np.sqrt(speed / intended)
                sums[row, COST + SLOWNESS] = max(sums[row, COST + SLOWNESS], lacking)
        for j in range(3):
            last[row, j] = sensordata[row, watch.hand[j]]


def failed(costs: Array, periods: int, task: Task, *, ended: bool) -> tuple[Limit, ...]:
    """Returns the limits of success that an episode does not meet so far."""
    terms = {**cost_terms(costs, periods), "lost": float(ended)}
    return tuple(limit for limit in task.limits if not terms[limit.name] <= limit.value)


def is_success(costs: Array, periods: Any, task: Task, *, ended: Any) -> Any:
    """Returns whether episodes meet every limit of success so far; see `failed`."""
    terms = {**cost_terms(costs, periods), "lost": ended}
    found = np.all([terms[limit.name] <= limit.value for limit in task.limits], axis=0)
    return found if costs.ndim > 1 else bool(found)
