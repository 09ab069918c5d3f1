"""The clairvoyant: what motors can do for one who knows the suit and the whole motion.

What a guided wearer and the motors give together is what the motion takes, and becomes the motors'
plan: within their peaks, rationed where their heat would bind, their lag inverted. After three
passes little is left to take over. It is a bound for motions that follow the intention, in
practice; no theorem.
"""

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED, Motor
from ..policies.planned import Planned
from .wearers import Wearers, smoothed

PASSES = 3
COOLNESS = 0.999  # share of the heat limit that a plan may use: the protection does not act
BOUNDS = ("clairvoyant-suit", "clairvoyant")
"""One that cancels the suit's torque alone, and one that takes over all it can."""


def clairvoyant(
    wearers: Wearers, seeds: Sequence[int], *, suit_only: bool = False, passes: int = PASSES
) -> Planned:
    """Returns the plan of one who knows the true model and each motion as a whole.

    Args:
        wearers: Wearers under whom the motions are planned.
        seeds: Seeds of the motions.
        suit_only: Whether to cancel the suit's torque alone.
        passes: Number of passes.
    """
    simulation = wearers.arms.episodes.simulation
    assisted, peak = simulation.addresses.assisted, simulation.addresses.peak_torque
    motors = [simulation.config.exo.motors[joint] for joint in ASSISTED]
    dt, samples = simulation.control_dt, simulation.samples
    gain = 1 - np.exp(-math.tau * np.array([motor.bandwidth for motor in motors]) * dt)
    plan = Planned(np.zeros((len(seeds), samples - 1, len(ASSISTED))))
    no_torque = np.zeros((len(seeds), samples, len(JOINTS)))
    for _ in range(passes):
        traces = wearers.guided(plan, seeds, no_torque)
        if suit_only:
            wanted = -smoothed([trace.suit_torque for trace in traces], samples)[..., assisted]
        else:
            given = smoothed([trace.human_torque for trace in traces], samples)
            helped = smoothed([trace.assist_torque for trace in traces], samples)
            wanted = given[..., assisted] + helped
        for row in wanted:
            for column, motor in enumerate(motors):
                row[:, column] = rationed(row[:, column], motor, dt)
        plan = Planned(inverted(wanted, gain, peak) / peak)
    return plan


def rationed(wanted: Array, motor: Motor, dt: float) -> Array:
    """Returns the torque nearest to what is wanted among those that a motor can give.

    None is above its peak, and its heat, the running mean square, never above the continuous torque
    squared. Least squares are missing where the torque is wanted / (1 + scarcity), and scarcity is
    a sum of the prices of heat at later times, each remembered as heat is. Prices that maximize the
    dual function (Boyd and Vandenberghe 2004, section 5.2) are 0 where the heat is below its limit.

    Args:
        wanted: Torque at every sample [N·m], shape (samples,).
        motor: The motor.
        dt: Control period [s].
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
    found = minimize(
        dual,
        np.zeros_like(wanted),
        jac=True,
        bounds=Bounds(0, np.inf),
        method="L-BFGS-B",
        options={"ftol": 1e-12, "maxcor": 30},
    )
    return given(scarcity(found.x))


def inverted(wanted: Array, gain: Array, peak: Array) -> Array:
    """Returns commands after which lagging motors give what is wanted, as far as their peak allows.

    Args:
        wanted: Torque at every sample [N·m], shape (rows, samples, 2).
        gain: Share of a change that a motor follows in one control period, shape (2,).
        peak: Peak torque of each motor [N·m], shape (2,).

    Returns:
        The commands [N·m], shape (rows, samples - 1, 2); the motors begin at the first one.
    """
    given = np.clip(wanted[:, 0], -peak, peak)
    commands = np.empty_like(wanted[:, 1:])
    for i in range(commands.shape[1]):
        command = (wanted[:, i + 1] - (1 - gain) * given) / gain if i else wanted[:, 0]
        commands[:, i] = np.clip(command, -peak, peak)
        given = given + gain * (commands[:, i] - given)
    return commands
