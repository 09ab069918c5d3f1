"""The clairvoyant: what motors can do for one who knows the suit and the whole motion.

The torque that a led wearer still gives becomes the motors' plan; its lag is inverted inside their
limits; after six passes little is left to take over. It is a bound in practice, no theorem.
"""

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED
from ..policies.planned import Planned
from .settled import Wearers, smoothed

PASSES = 6
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
    bandwidth = np.array(
        [simulation.config.exo.motors[joint].bandwidth for joint in ASSISTED]
    )  # Hz
    gain = 1 - np.exp(-math.tau * bandwidth * simulation.control_dt)
    wanted = np.zeros((len(seeds), simulation.samples, len(ASSISTED)))
    plan = Planned(inverted(wanted, gain, peak) / peak)
    untaught = np.zeros((len(seeds), simulation.samples, len(JOINTS)))
    samples = simulation.samples
    for _ in range(passes):
        traces = wearers.led(plan, seeds, untaught)
        if suit_only:
            resisted = smoothed([trace.suit_torque for trace in traces], samples)
            wanted = -resisted[..., assisted]
        else:
            given = smoothed([trace.human_torque for trace in traces], samples)
            wanted = wanted + given[..., assisted]
        plan = Planned(inverted(wanted, gain, peak) / peak)
    return plan


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
