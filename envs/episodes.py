"""Episodes of a task in many rows, for single and vector environments.

    >>> from activesuit.envs.tasks import TASKS
    >>> task = TASKS["ElbowFlexion"]
    >>> episodes = Episodes(task, 2, Setup.of(task, {"gravity": "moon"}))
    >>> episodes.reset(np.arange(2), seeds=[0, 1])
    >>> episodes.step(np.zeros((2, 2)))
    >>> episodes.observe().shape, episodes.truncated.tolist()
    ((2, 12), [False, False])

Environments are thin layers over `Episodes`. A row is the same to the last bit whatever the other
rows do. `observe`, `info` and `state` return new arrays; `reward`, `terminated` and `truncated` are
views that the next call overwrites.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import Array
from ..assets import JOINTS
from ..checks import check_seed, flag, within
from ..errors import InputError, shown
from .belief import LEAD, BelievedArm
from .interface.info import Info
from .interface.observation import NOISY, Observer
from .interface.reward import (
    CLIPPED,
    COST,
    DIVERGED,
    ENDED,
    PERIODS,
    TERM,
    TERMS,
    Judge,
    cost_terms,
    is_success,
    suited_effort,
)
from .setup import Setup
from .simulation import Simulation
from .simulation.episode_plan import Plan
from .simulation.measurements import ENCODER, ENCODER_RATE, SENSED, SHAPES, TIME
from .simulation.row_models import Variety
from .simulation.simulation import Start
from .simulation.state import SimulationOptions, check_state, fresh_seed, stream
from .tasks import Task

Rows = NDArray[np.int64]
TINIEST = 1e-6  # least effort that scales a reward
SCALED_BY = 5  # number of motions of the task that give the scale of efforts


class Episodes:
    """Runs episodes of one task in `n` rows.

    Args:
        task: The task.
        n: Number of rows.
        setup: Options of the environment.
        threads: Number of threads of the physics; 0 uses all cores.
        max_periods: Number of control periods after which an episode is truncated, if that is
            before the end of the intention.
        learned_torque: Whether `reset` takes the learned torque of wearers.
        effort_scale: Effort by which the reward is scaled; by default that of the suited arm.

    Attributes:
        simulation: The simulated arms.
        observer: Maker of the observations.
        reward: Reward of the last control period, shape (n,).
        terminated: Whether an episode ended by failure, shape (n,).
        truncated: Whether an episode is over, shape (n,).
        effort_scale: Effort of the suited arm over strength, by which rewards are scaled.
    """

    def __init__(
        self,
        task: Task,
        n: int,
        setup: Setup,
        *,
        threads: int = 1,
        max_periods: int | None = None,
        learned_torque: bool = False,
        effort_scale: float | None = None,
    ) -> None:
        flag("learned_torque", learned_torque)
        if effort_scale is not None:
            within("effort_scale", effort_scale, TINIEST, 1 / TINIEST, " of strength")
        self._of_rows = {
            **{"threads": threads, "max_periods": max_periods, "effort_scale": effort_scale},
            "learned_torque": learned_torque,
        }
        self.setup, self._suits = setup, setup.randomize.suits_for(setup.arm)
        self.task, self.n = task, n
        samples = round(task.duration / setup.control_dt) + 1
        self._periods = min(samples - 1, max_periods or samples)
        options = SimulationOptions(
            samples=samples,
            control_dt=setup.control_dt,
            control=setup.control,
            fatigue=setup.fatigue,
            sensing=setup.sensing,
            faults=setup.faults,
            variety=Variety(
                wearers=setup.randomize.wearers,
                suits=tuple(base.suit for base in self._suits),
                misalignments=setup.randomize.misalignment > 0,
                loads=task.carries or setup.randomize.payload is not None,
                places=bool(setup.randomize.gravity),
            ),
            noisy=any(suite in setup.sensors for suite in NOISY),
            carries=task.carries,
            learned=learned_torque,
        )
        self.simulation = Simulation(setup.arm, n, options, task.edits, threads)
        columns, history = self.simulation.columns, setup.history
        self.observer = Observer(setup.sensors, columns, normalize=setup.normalize, history=history)
        size = self.observer.space.shape[0] // history if history > 1 else 0
        self._frames = np.zeros((n, history - 1, size), np.float32)
        self._belief, self._belief_state = np.zeros((n, 4)), np.zeros((n, 0))
        if setup.belief is not None:
            believed = BelievedArm(setup.belief, task.edits, setup.control_dt)
            self._suit, self._weight = believed.suit(), believed.whole_weight()
            self._assisted = self.simulation.addresses.assisted
            self._belief_state = np.zeros((n, self._suit.size))
        self.motors = self.simulation.addresses.motors.size
        self._all = np.arange(n)
        if effort_scale is None:
            streams = (stream(i, 0, "motion") for i in range(SCALED_BY))
            plans = [self.simulation.checked(self._plan(one)) for one in streams]
            effort_scale = suited_effort(self.simulation, plans)
        self.effort_scale = effort_scale
        self._judge = Judge(self.simulation, task, effort_scale)
        self._score, self._watch = self._judge.score, self._judge.watch
        self.reward, self.terminated = self._score.reward, self._score.terminated
        self.truncated = self._score.truncated
        state = self.simulation.state
        self._counters, self._measured = state.episode, state.sensors.measured
        own = {"belief": self._belief, "belief_state": self._belief_state, "frames": self._frames}
        self._drawn: dict[str, NDArray] = {
            "suit_number": np.zeros(n, np.int64),
            "suit_spring": np.ones((n, len(JOINTS))),
            "suit_loop": np.ones((n, len(JOINTS))),
        }
        self._own: dict[str, NDArray] = {**self._judge.arrays(), **self._drawn, **own}

    # --- Episodes -----------------------------------------------------------------------------

    def reset(
        self,
        rows: Rows,
        seeds: Sequence[int | None] | None = None,
        *,
        stagger: bool = False,
        learned: Mapping[str, Array] | None = None,
    ) -> None:
        """Begins new episodes in some rows, shape (k,).

        `seeds` has a seed for each of these rows; None keeps the seed of the row. With `stagger`,
        the episodes end at random times, so that later episodes do not all begin together.
        `learned` has what the wearers have learned [N·m], shape (k, samples, 4) each:
        `learned_torque`, added to that of their bare arms, and `learned_contraction`, beyond the
        usual co-contraction.
        """
        episode = self._counters
        next_gains = self.simulation.state.wearer.learning.next_gains
        for row, seed in zip(rows.tolist(), seeds or [None] * len(rows), strict=True):
            if seed is not None or episode.episode[row] < 0:
                episode.seed[row] = fresh_seed() if seed is None else check_seed(seed)
                episode.episode[row], next_gains[row] = -1, 0.0
        episode.episode[rows] += 1
        episode.limit[rows] = self._periods
        if stagger:
            episode.limit[rows] = [
                self._stream(row, "stagger").integers(1, self._periods + 1) for row in rows.tolist()
            ]
        for values in self._own.values():
            values[rows] = 0
        try:
            self.simulation.begin(rows, self._start, learned or {})
        except BaseException:
            episode.episode[rows] = -1  # no episode: `step` asks for a reset
            raise
        if self._belief_state.size:
            angle = self._encoded(rows)[0][:, self._assisted]
            self._belief_state[rows] = self._suit.begin(angle)
            self._update_belief(rows)
        if self._frames.size:
            self._frames[rows] = self._observed()[rows, None]
        self._judge.begin(rows)

    def require_reset(self, what: str) -> None:
        """Raises an InputError if a row has had no reset yet; `what` is the name of the call."""
        if (self._counters.episode < 0).any():
            raise InputError(f"{what} before the first reset: call reset() first")

    def step(self, action: ArrayLike, rows: Rows | None = None) -> None:
        """Applies actions for one control period, in all rows or in those that `rows` names.

        `action` is the torque of the motors over their peaks, shape (n, motors).
        """
        self._move(checked(action, (self.n, self.motors), rows), rows)

    def step_one(self, action: ArrayLike) -> None:
        """Applies an action, shape (motors,), in the only row."""
        self._move(checked(action, (self.motors,))[None], None)

    def observe(self) -> NDArray[np.float32]:
        """Returns a new array of the observations of all rows, shape (n, size)."""
        now = self._observed()
        if not self._frames.size:
            return now
        return np.concatenate([now, self._frames.reshape(self.n, -1)], axis=1)

    def info(self, row: int) -> Info:
        """Returns quantities of a row that no sensor measures; a read of the info computes them."""
        here = slice(row, row + 1)
        measured, sums = self._measured[here].copy(), self._score.sums[here].copy()
        drawn = {name: values[here].copy() for name, values in self._drawn.items()}
        return Info(measured.item(TIME), lambda: of_row(self._report(measured, sums, drawn)))

    def report(self) -> dict[str, Any]:
        """Returns quantities that no sensor measures, as new arrays with one row for each arm."""
        drawn = {name: values.copy() for name, values in self._drawn.items()}
        return self._report(self._measured.copy(), self._score.sums.copy(), drawn)

    def _report(self, measured: Array, sums: Array, drawn: dict[str, NDArray]) -> dict[str, Any]:
        columns = self.simulation.columns.items()
        found = {name: measured[:, part] for name, part in columns if name not in SENSED}
        costs, periods, ended = sums[:, COST:PERIODS], sums[:, PERIODS], sums[:, ENDED]
        return {
            **{name: one[:, 0] if one.shape[1] == 1 else one for name, one in found.items()},
            "clipped_actions": sums[:, CLIPPED].astype(np.int64),
            "diverged": sums[:, DIVERGED] > 0,
            "reward_terms": {name: sums[:, TERM + i] for i, name in enumerate(TERMS)},
            "cost_terms": cost_terms(costs, periods),
            "is_success": is_success(costs, periods, self.task, ended=ended),
            **drawn,
        }

    @property
    def terms(self) -> Array:
        """Terms of the reward, shape (n, 3), in the order of `TERMS`."""
        return self._score.sums[:, TERM:COST]

    @property
    def costs(self) -> Array:
        """Costs of the episodes so far, shape (n, 10), in the order of `COSTS`."""
        return self._score.sums[:, COST:PERIODS]

    # --- State --------------------------------------------------------------------------------

    def identity(self) -> dict[str, Any]:
        """Returns the options on which a state depends."""
        simulation, believed = self.simulation, self.setup.belief
        return {
            "task": self.task.name,
            **{name: value for name, value in self.task.identity().items() if name != "name"},
            **simulation.config.to_dict(),
            "control_dt": simulation.control_dt,
            "control": asdict(simulation.control),
            "fatigue": simulation.fatigue,
            "randomize": asdict(self.setup.randomize),
            "sensing": asdict(simulation.sensing),
            "faults": asdict(simulation.faults),
            "belief": believed.to_dict() if believed else None,
            "effort_scale": self._of_rows["effort_scale"],
        }

    def state(self, rows: Rows) -> dict[str, Any]:
        """Returns the whole state of some rows: physics, episode and configuration."""
        return {"config": self.identity(), **self._arrays(rows)}

    def restore(self, rows: Rows, state: Any) -> None:
        """Restores the result of `state`, also in other rows, which then continue bit for bit."""
        bounds = self.simulation.bounds
        check_state(state, self.identity(), self._arrays(rows), bounds, self.simulation.model)
        self._restore(rows, state)
        limit = self._counters.limit
        limit[rows] = np.minimum(limit[rows], self._periods)
        self._judge.restore(rows)

    def __getstate__(self) -> dict[str, Any]:
        made_with = {"task": self.task, "n": self.n, "setup": self.setup, **self._of_rows}
        return {"made_with": made_with, "state": self._arrays(self._all)}

    def __setstate__(self, saved: dict[str, Any]) -> None:
        self.__init__(**saved["made_with"])
        self._restore(self._all, saved["state"])
        self._judge.restore(self._all)

    def _arrays(self, rows: Rows) -> dict[str, NDArray]:
        own = {name: values[rows] for name, values in self._own.items()}
        return {**self.simulation.get_state(rows), **own}

    def _restore(self, rows: Rows, state: dict[str, NDArray]) -> None:
        self.simulation.set_state(rows, state)
        for name, values in self._own.items():
            values[rows] = state[name]

    # --- Parts --------------------------------------------------------------------------------

    def _stream(self, row: int, purpose: str) -> np.random.Generator:
        seed, episode = self._counters.seed[row], self._counters.episode[row]
        return stream(int(seed), int(episode), purpose)

    def _move(self, action: Array, rows: Rows | None) -> None:
        moving = self._all if rows is None else rows
        if self._frames.size:
            last = self._observed()[moving]
            self._frames[moving, 1:] = self._frames[moving, :-1]
            self._frames[moving, 0] = last
        self.simulation.step(action, rows)
        if self._belief_state.size:
            self._update_belief(moving[~self._counters.diverged[moving]])
        self._judge.judge(moving)
        if self.setup.reward is not None:
            self.reward[moving] = self.setup.reward(*self._rewarded(moving))

    def _rewarded(self, rows: Rows) -> tuple[dict[str, Array], dict[str, NDArray]]:
        """Returns the arguments of a reward of the user; see `OwnReward`."""
        terms = {name: self.terms[rows, i] for i, name in enumerate(TERMS)}
        columns = self.simulation.columns.items()
        measured = {name: self._measured[rows, part] for name, part in columns}
        shown = {name: values for name, values in measured.items() if name not in SENSED}
        return terms, {**shown, "lost": self.terminated[rows]}

    def tolerated(self) -> Array:
        """Returns the errors of joints that the task tolerates [rad], shape (n, samples, 4).

        The errors are the limit of the task, which holds in the mean over time. Where the hand is
        watched, every error counts: there the tolerated error is at most half of the error that
        moves the hand to its limit.
        """
        simulation = self.simulation
        found = np.full((self.n, simulation.samples, len(JOINTS)), self.task.tracking)
        if self.task.watches:
            wearers = simulation.state.conditions.wearer
            levers = np.array([simulation.arm_of(int(wearer)).levers for wearer in wearers])
            hand = np.minimum(found, self.task.hand_error / 2 / levers[:, None])
            found = np.where(self._watch.watched[..., None], hand, found)
        return found

    def _observed(self) -> NDArray[np.float32]:
        return self.observer(self._measured, self._belief)

    def _start(self, row: int) -> Start:
        streams, terms = partial(self._stream, row), self.setup.randomize
        wearer = terms.person(streams)
        plan = terms.loaded(self._plan(streams("motion"), wearer), streams)
        plan = self.simulation.checked(plan)
        if self.task.watches:
            places = self.simulation.arm_of(wearer).in_world(plan.motion[0])
            self._watch.watched[row] = False if plan.watched is None else plan.watched
            self._watch.hand_places[row] = places
        suit = terms.suit_of(self._suits, streams)
        for values, drawn in zip(self._drawn.values(), suit[1:], strict=True):
            values[row] = drawn
        return Start(plan=plan, suit=suit.joints, wearer=wearer, **terms.drawn(streams))

    def _plan(self, rng: np.random.Generator, wearer: int = 0) -> Plan:
        simulation = self.simulation
        arm = simulation.arm_of(wearer)
        return self.task.plan(rng, simulation.samples, simulation.control_dt, arm)

    def _encoded(self, rows: Rows) -> tuple[Array, Array]:
        measured = self._measured[rows]
        return measured[:, ENCODER : ENCODER + 4], measured[:, ENCODER_RATE : ENCODER_RATE + 4]

    def _update_belief(self, rows: Rows) -> None:
        """Updates the believed torques of suit and weight of some rows."""
        assisted = self._assisted
        angle, rate = self._encoded(rows)
        state = self._belief_state[rows]
        suit = self._suit.follow(state, angle[:, assisted], rate[:, assisted])
        self._belief_state[rows] = state
        weight = self._weight(angle + LEAD * rate)
        self._belief[rows] = np.concatenate([suit, weight], axis=1)


def checked(action: ArrayLike, shape: tuple[int, ...], rows: Rows | None = None) -> Array:
    """Returns actions as an array of the given shape, finite in the rows that move."""
    try:
        given = np.asarray(action)
    except ValueError:  # lists of several lengths
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "iuf":
        raise InputError(f"action is {shown(action)}: give {shape[-1]} numbers from -1 to 1")
    if given.shape != shape:
        raise InputError(
            f"action has shape {given.shape}: give {shape}, one number for every motor"
        )
    found = given.astype(np.float64, order="C")
    if not isfinite(found.sum()):  # also where finite numbers overflow
        each = found.reshape(-1, shape[-1])
        for row in range(len(each)) if rows is None else rows:
            if not np.isfinite(each[row]).all():
                place = f"action of row {row}" if len(each) > 1 else "action"
                raise InputError(
                    f"{place} is {each[row].tolist()}: give finite numbers from -1 to 1"
                )
    return found


def of_row(report: dict[str, Any]) -> dict[str, Any]:
    """Returns the only row of a report: numbers, and arrays in their shape."""
    found: dict[str, Any] = {}
    for name, values in report.items():
        if isinstance(values, dict):
            found[name] = of_row(values)
        elif values.ndim == 1:
            found[name] = values.item()
        else:
            found[name] = values.reshape(SHAPES.get(name, -1))
    return found
