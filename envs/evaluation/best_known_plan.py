"""The best known plan of motor torques, made with knowledge of suit, wearer and whole motion.

A motion takes the torque that a guided wearer and the motors give together. This torque becomes the
motors' plan: within the peaks, rationed for the least effort of the wearer where heat is the limit,
and with the lag inverted. Then, pass by pass, adapted wearers move under the plan, and the torque
that the wearers still give is added to the plan, until this torque falls by less than 1 %. Where
heat is the limit, torques that policies gave begin such passes, too. For each motion the pass with
the least effort counts. Where an earlier or later plan is better, as before a blow that throws the
arm back, the wearers' torque does not show how to improve the plan: there, plans that are shifted
in time, smoothed, scaled and bent are tried too. The plan is the best known one, without a proof,
and policies that answer to the motion can be better.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED, Motor
from ..policies.model_based import Planned
from .rollout import Trace
from .scores import root_mean_square
from .wearers import ArmLost, Wearers, padded, smoothed

GUIDED = 3  # passes under guided wearers
PASSES = 8  # greatest number of passes under adapted wearers
GAIN = 0.01  # least decrease of the wearers' torque for another pass
SOONER = (-2, 2)  # [control periods], shifts of a plan that show whether a search pays
SHIFTS, SMOOTHINGS, SCALES = (-4, -2, -1, 1, 2), (4,), (0.9, 1.1)
BENDS = (0.05, 0.02, 0.01, 0.005)  # root mean square of bumps over that of the plan
BEND_WIDTHS = (10, 80)  # control periods
ROUNDS, LITTLE = 3, 0.002  # greatest number of rounds of the search, least decrease of effort
HOT = 0.99  # load of a motor over its continuous torque, from which heat is the limit
COOLNESS = 0.999  # share of the heat limit that a plan may use, so that the protection never acts
BOUNDS = ("clairvoyant-suit", "best-known-plan")
"""A plan that cancels the suit's torque alone, and a plan that gives all possible help."""


def clairvoyant(
    wearers: Wearers,
    seeds: Sequence[int],
    *,
    suit_only: bool = False,
    given: Sequence[Trace] = (),
    on_pass: Callable[[Array], None] = lambda _: None,
) -> Planned:
    """Returns the plan for wearers and seeds of motions, by the true model and the whole motions.

    Args:
        wearers: Wearers of the arms.
        seeds: Seeds of the motions.
        suit_only: Whether the plan cancels the suit's torque alone.
        given: Motion of each seed under a policy, whose torques begin further passes where a motor
            is at its heat limit.
        on_pass: Function that is called after each pass and each round of the search with the least
            effort of each motion so far, shape (motions,).
    """
    planner = _Planner(wearers)
    samples, assisted = planner.samples, planner.assisted
    no_torque = np.zeros((len(seeds), samples, len(JOINTS)))
    wanted = no_torque[..., : len(ASSISTED)]
    commands = planner.commands(wanted)
    for _ in range(GUIDED):
        traces = wearers.guided(Planned(commands), seeds, no_torque)
        if suit_only:
            wanted = -smoothed([trace.suit_torque for trace in traces], samples)[..., assisted]
        else:
            planner.observe(traces)
            wanted = planner.needed(traces)
        commands = planner.commands(wanted)
    if suit_only:
        return Planned(commands)
    best = _Best(wearers, seeds, commands)
    _pass(best, planner, wanted, on_pass)
    if given and planner.hot:
        _pass(best, planner, planner.helped(given), on_pass)
    _search(best, on_pass)
    return Planned(best.commands)


def _pass(
    best: "_Best", planner: "_Planner", wanted: Array, on_pass: Callable[[Array], None]
) -> None:
    """Adds what adapted wearers still give to wanted torques, as long as this becomes less."""
    left = np.inf
    for _ in range(PASSES):
        traces = best.tried(planner.commands(wanted))
        if not traces:
            break
        on_pass(best.effort)
        given = planner.borne(traces)
        before, left = left, min(left, root_mean_square(given))
        if left > (1 - GAIN) * before:
            break
        wanted = planner.given(wanted) + given
        planner.observe(traces)


class _Best:
    """The plans of the least effort so far, motion by motion.

    Attributes:
        commands: Torque of the motors over their peaks, shape (motions, periods, 2).
        effort: Effort of adapted wearers over strength, shape (motions,); infinite before a try.
    """

    def __init__(self, wearers: Wearers, seeds: Sequence[int], commands: Array) -> None:
        self.commands, self.effort = commands.copy(), np.full(len(seeds), np.inf)
        self._wearers, self._seeds = wearers, seeds

    def tried(self, commands: Array) -> list[Trace]:
        """Returns the motions under other plans, or [] if an arm is lost; keeps better plans."""
        try:
            traces = self._wearers.adapted(partial(Planned, commands), self._seeds)
        except ArmLost:
            return []
        effort = np.array(
            [np.inf if one.terminated else root_mean_square(one.effort) for one in traces]
        )
        better = effort < self.effort
        self.commands[better] = commands[better]
        self.effort = np.minimum(self.effort, effort)
        return traces


def _search(best: _Best, on_pass: Callable[[Array], None]) -> None:
    """Tries changes of the best plans in rounds, as long as a round reduces effort enough."""
    rng = np.random.default_rng(0)
    sooner_or_later = [partial(_shifted, by=by) for by in SOONER]
    for round_, least in enumerate((GAIN, *[LITTLE] * ROUNDS)):
        before = best.effort.mean()
        for change in _changes(rng) if round_ else sooner_or_later:
            best.tried(np.clip(change(best.commands), -1, 1))
        on_pass(best.effort)
        if not best.effort.mean() < (1 - least) * before:
            break


def _changes(rng: np.random.Generator) -> Iterator[Callable[[Array], Array]]:
    """Yields changes of plans of shape (motions, periods, 2), from coarse to fine."""
    from scipy.ndimage import gaussian_filter1d  # slow to import

    def bent(commands: Array, size: float) -> Array:
        """Returns plans with smooth random bumps; `size` is their size over the plan's."""
        width = rng.uniform(*BEND_WIDTHS)
        bumps = gaussian_filter1d(rng.normal(size=commands.shape), width, axis=1, mode="nearest")
        return commands + size * root_mean_square(commands) / root_mean_square(bumps) * bumps

    yield from (partial(_shifted, by=by) for by in SHIFTS)
    for width in SMOOTHINGS:
        yield partial(gaussian_filter1d, sigma=width, axis=1, mode="nearest")
    for scale in SCALES:
        for column in range(len(ASSISTED)):
            yield partial(np.multiply, np.where(np.arange(len(ASSISTED)) == column, scale, 1.0))
    yield from (partial(bent, size=size) for size in BENDS)


def _shifted(commands: Array, by: int) -> Array:
    """Returns plans some control periods later, or earlier where `by` is negative."""
    at = np.clip(np.arange(commands.shape[1]) - by, 0, commands.shape[1] - 1)
    return commands[:, at]


class _Planner:
    """Turns wanted torques into commands that the motors can follow."""

    def __init__(self, wearers: Wearers) -> None:
        simulation = wearers.arms.episodes.simulation
        self.assisted, self.samples = simulation.addresses.assisted, simulation.samples
        self._peak, self._dt = simulation.addresses.peak_torque, simulation.control_dt
        self._motors = [simulation.config.exo.motors[joint] for joint in ASSISTED]
        bandwidth = np.array([motor.bandwidth for motor in self._motors])
        self._gain = 1 - np.exp(-math.tau * bandwidth * self._dt)
        rows = simulation.state.muscles.strength.shape[0]
        self._strength = np.ones((rows, self.samples, 2, len(ASSISTED)))  # extensors, flexors
        self.hot = False
        self._opposed = np.zeros((rows, self.samples, len(ASSISTED)))

    def helped(self, traces: Sequence[Trace]) -> Array:
        """Returns the motors' torque [N·m], shape (rows, samples, 2)."""
        return smoothed([trace.assist_torque for trace in traces], self.samples)

    def borne(self, traces: Sequence[Trace]) -> Array:
        """Returns the wearers' torque of the joints with motors, as `helped`."""
        given = smoothed([trace.human_torque for trace in traces], self.samples)
        return given[..., self.assisted]

    def needed(self, traces: Sequence[Trace]) -> Array:
        """Returns the torque of wearers and motors together, as `helped`."""
        return self.borne(traces) + self.helped(traces)

    def observe(self, traces: Sequence[Trace]) -> None:
        """Takes the wearers' strength and co-contraction from motions, for rationed heat."""
        heat = [one.motor_load for one in traces if one.motor_load is not None]
        self.hot = any(one.max() >= HOT for one in heat)
        strength = np.array([padded(one.strength, self.samples) for one in traces])
        effort = np.array([padded(one.effort, self.samples) for one in traces])
        torque = np.array([padded(one.human_torque, self.samples) for one in traces])
        loads = effort[:, :, None] * strength  # of the more loaded group, if it were that group
        loaded, other = loads[:, :, 1], loads[:, :, 0]
        loaded, other = np.where(torque < 0, (other, loaded), (loaded, other))
        opposed = np.maximum(np.minimum(loaded - np.abs(torque), other), 0.0)
        self._strength = strength[..., self.assisted]
        self._opposed = opposed[..., self.assisted]

    def given(self, wanted: Array) -> Array:
        """Returns the torques that the motors can give, with the least effort of the wearers."""
        found = wanted.copy()
        extending, flexing = self._strength[:, :, 0], self._strength[:, :, 1]
        strength = np.where(wanted < 0, extending, flexing)
        for i, row in enumerate(found):
            for column, motor in enumerate(self._motors):
                beside = strength[i, :, column], self._opposed[i, :, column]
                row[:, column] = rationed(row[:, column], motor, self._dt, *beside)
        return found

    def commands(self, wanted: Array) -> Array:
        """Returns commands over the motors' peaks for torques [N·m], shape (rows, samples, 2).

        Under the commands, lagging motors give the wanted torques, as far as the peaks allow, from
        the first command on.
        """
        wanted, gain, peak = self.given(wanted), self._gain, self._peak
        given = np.clip(wanted[:, 0], -peak, peak)
        commands = np.empty_like(wanted[:, 1:])
        for i in range(commands.shape[1]):
            command = (wanted[:, i + 1] - (1 - gain) * given) / gain if i else wanted[:, 0]
            commands[:, i] = np.clip(command, -peak, peak)
            given = given + gain * (commands[:, i] - given)
        return commands / peak


def rationed(
    wanted: Array,
    motor: Motor,
    dt: float,
    strength: Array | float = 1.0,
    opposed: Array | float = 0.0,
) -> Array:
    """Returns the possible torque of a motor that leaves the wearer the least effort [N·m].

    No torque is above the peak, and the heat, a running mean square, is never above the square of
    the continuous torque. The wearer gives what is missing, against a co-contraction `opposed`. The
    sum of squares of this load over `strength` is least for torques (|wanted| + opposed) / (1 +
    scarcity · strength²), and at most |wanted|. Scarcity is the sum of the prices of heat at later
    times, with the decay of heat. The prices that maximize the dual function (Boyd and Vandenberghe
    2004, section 5.2) are 0 where the heat is below its limit.

    Args:
        wanted: Wanted torques [N·m], shape (samples,).
        motor: The motor.
        dt: Time between two samples [s].
        strength: Strength of the loaded muscles [N·m], shape (samples,) or a number.
        opposed: Co-contraction [N·m], shape (samples,) or a number.
    """
    from scipy.optimize import Bounds, minimize  # slow to import
    from scipy.signal import lfilter

    remains = math.exp(-dt / motor.thermal_time_constant)
    limit = COOLNESS * motor.continuous_torque**2

    def remembered(values: Array) -> Array:
        return np.asarray(lfilter([1 - remains], [1, -remains], values))

    def scarcity(prices: Array) -> Array:
        return remembered(prices[::-1])[::-1]

    weight = np.square(np.mean(strength) / strength)
    size, load = np.abs(wanted), np.abs(wanted) + opposed

    def given(scarce: Array) -> Array:
        return np.minimum(np.minimum(size, load / (1 + scarce / weight)), motor.peak_torque)

    def dual(prices: Array) -> tuple[float, Array]:
        scarce = scarcity(prices)
        torque = given(scarce)
        value = (weight * (load - torque) ** 2).sum() + scarce @ torque**2 - limit * prices.sum()
        return -value, limit - remembered(torque**2)

    free = given(np.zeros_like(wanted))
    if remembered(free**2).max() <= limit:
        return np.sign(wanted) * free
    how = {"jac": True, "method": "L-BFGS-B", "options": {"ftol": 1e-12, "maxcor": 30}}
    found = minimize(dual, np.zeros_like(wanted), bounds=Bounds(0, np.inf), **how)
    return np.sign(wanted) * given(scarcity(found.x))
