"""The best known plan of motor torques, made with knowledge of suit, wearer and whole motion.

A motion takes the torque that a guided wearer and the motors give together. This torque becomes the
motors' plan: within the peaks, rationed where heat is the limit, and with the lag inverted. Then,
pass by pass, adapted wearers move under the plan, and the torque that the wearers still give is
added to the plan, until this torque falls by less than 1 %. For each motion the pass with the least
effort counts. Where an earlier or later plan is better, as before a blow that throws the arm back,
the wearers' torque does not show how to improve the plan: there, plans that are shifted in time,
smoothed, scaled and bent are tried too. The plan is a bound in practice, without a proof.
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
from .wearers import ArmLost, Wearers, smoothed

GUIDED = 3  # passes under guided wearers
PASSES = 8  # greatest number of passes under adapted wearers
GAIN = 0.01  # least decrease of the wearers' torque for another pass
SOONER = (-2, 2)  # [control periods], shifts of a plan that show whether a search pays
SHIFTS, SMOOTHINGS, SCALES = (-4, -2, -1, 1, 2), (4,), (0.9, 1.1)
BENDS = (0.05, 0.02, 0.01, 0.005)  # root mean square of bumps over that of the plan
BEND_WIDTHS = (10, 80)  # control periods
ROUNDS, LITTLE = 3, 0.002  # greatest number of rounds of the search, least decrease of effort
COOLNESS = 0.999  # share of the heat limit that a plan may use, so that the protection never acts
BOUNDS = ("clairvoyant-suit", "best-known-plan")
"""A plan that cancels the suit's torque alone, and a plan that gives all possible help."""


def clairvoyant(
    wearers: Wearers,
    seeds: Sequence[int],
    *,
    suit_only: bool = False,
    on_pass: Callable[[Array], None] = lambda _: None,
) -> Planned:
    """Returns the plan for wearers and seeds of motions, by the true model and the whole motions.

    With `suit_only` the plan cancels the suit's torque alone. `on_pass` is called after each pass
    and each round of the search with the least effort of each motion so far, shape (motions,).
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
            given = smoothed([trace.human_torque for trace in traces], samples)
            helped = smoothed([trace.assist_torque for trace in traces], samples)
            wanted = given[..., assisted] + helped
        commands = planner.commands(wanted)
    if suit_only:
        return Planned(commands)
    best, left = _Best(wearers, seeds, commands), np.inf
    for _ in range(PASSES):
        traces = best.tried(commands)
        if not traces:
            break
        on_pass(best.effort)
        given = smoothed([trace.human_torque for trace in traces], samples)[..., assisted]
        before, left = left, min(left, root_mean_square(given))
        if left > (1 - GAIN) * before:
            break
        wanted = planner.given(wanted) + given
        commands = planner.commands(wanted)
    _search(best, on_pass)
    return Planned(best.commands)


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

    def given(self, wanted: Array) -> Array:
        """Returns the torques nearest to the wanted torques that the motors can give."""
        found = wanted.copy()
        for row in found:
            for column, motor in enumerate(self._motors):
                row[:, column] = rationed(row[:, column], motor, self._dt)
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


def rationed(wanted: Array, motor: Motor, dt: float) -> Array:
    """Returns the possible torque of a motor nearest to the wanted torque [N·m].

    No torque is above the peak, and the heat, a running mean square, is never above the square of
    the continuous torque. The sum of squared differences is least for torques wanted / (1 +
    scarcity). Scarcity is the sum of the prices of heat at later times, with the decay of heat. The
    prices that maximize the dual function (Boyd and Vandenberghe 2004, section 5.2) are 0 where the
    heat is below its limit. Torques have the shape (samples,).
    """
    from scipy.optimize import Bounds, minimize  # slow to import
    from scipy.signal import lfilter

    remains = math.exp(-dt / motor.thermal_time_constant)
    limit = COOLNESS * motor.continuous_torque**2

    def remembered(values: Array) -> Array:
        return np.asarray(lfilter([1 - remains], [1, -remains], values))

    def scarcity(prices: Array) -> Array:
        return remembered(prices[::-1])[::-1]

    def given(scarce: Array) -> Array:
        return np.clip(wanted / (1 + scarce), -motor.peak_torque, motor.peak_torque)

    def dual(prices: Array) -> tuple[float, Array]:
        scarce = scarcity(prices)
        torque = given(scarce)
        value = ((wanted - torque) ** 2).sum() + scarce @ torque**2 - limit * prices.sum()
        return -value, limit - remembered(torque**2)

    if remembered(given(np.zeros_like(wanted)) ** 2).max() <= limit:
        return given(np.zeros_like(wanted))
    how = {"jac": True, "method": "L-BFGS-B", "options": {"ftol": 1e-12, "maxcor": 30}}
    found = minimize(dual, np.zeros_like(wanted), bounds=Bounds(0, np.inf), **how)
    return given(scarcity(found.x))
