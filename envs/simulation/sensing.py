"""Noisy and delayed sensors at the cuffs and on the person."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from ...arrays import Array
from ..provenance import Quantity, check_settings, quantities_of, setting
from .addresses import Addresses
from .bound import Frozen, thawed
from .inverse_dynamics import arm_torque
from .measurements import CUFF_NOISES, CUFF_SENSOR, CUFFS, EMG, EMG_NOISES, INTERACTION
from .structs import BareArm, Episode, Intention, NoisySensors, Physics, Wearer, Whole
from .wearer_control import feed_forward

_PADS = "ours: pads between suit and skin yield and slip"
_EMG = "a round number of the size of the electromechanical delay, 30 to 80 ms"


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """Noise, delay and bandwidth of sensors. All fields are plain numbers.

    Attributes:
        rate_cutoff: Low-pass of the rates, which are differences of the encoders' counts [Hz].
        interaction_noise: Standard deviation of the interaction torque's noise, over the torque.
        interaction_delay: Age of the interaction torque [s].
        cuff_noise: Standard deviation of each component of a cuff's force [N].
        emg_noise: Standard deviation of the EMG's noise, over its size, before the low-pass.
        emg_lead: Time by which the EMG is ahead of the torque that it indicates [s].
        emg_cutoff: Low-pass of the EMG [Hz].
    """

    rate_cutoff: float = setting(
        20.0, "Hz", 0.1, 1000, source="a round number above the wearer's motion"
    )
    interaction_noise: float = setting(0.10, "1", 0, 1, source=_PADS)
    interaction_delay: float = setting(0.05, "s", 0, 0.5, source=_PADS)
    cuff_noise: float = setting(
        1.0, "N", 0, 100, source="ours: 0.2 % of a load cell's usual range of 500 N"
    )
    emg_noise: float = setting(
        0.20, "1", 0, 1, source="ours: a smoothed EMG varies by some ten percent"
    )
    emg_lead: float = setting(0.05, "s", 0, 0.2, source=_EMG)
    emg_cutoff: float = setting(
        6.0, "Hz", 0.1, 1000, source="a usual low-pass of the rectified EMG"
    )

    def __post_init__(self) -> None:
        check_settings(self, "sensing.")


PROVENANCE: tuple[Quantity, ...] = quantities_of(Sensing(), "sensing")


def smoothing(cutoff: float | Array, dt: float) -> Any:
    """Returns the share of a step that a first-order low-pass [Hz] follows in one period."""
    return 1 - np.exp(-math.tau * cutoff * dt)


@njit(inline="always")
def touch(
    row: int,
    moved: bool,
    physics: Physics,
    at: Addresses,
    episode: Episode,
    arm: BareArm,
    noisy: NoisySensors,
    measured: Array,
) -> None:
    """Measures the torque between person and suit, delayed and noisy.

    It is the wearer's torque minus that of the bare arm in the present motion.
    """
    present, delayed, step = noisy.present, noisy.interaction_delay, episode.step[row]
    for j in range(4):
        present.angle[row, 0, j] = physics.qpos[row, at.joints[j]]
        present.rate[row, 0, j] = physics.qvel[row, at.joints[j]]
        present.acceleration[row, 0, j] = physics.qacc[row, at.joints[j]]
    arm_torque(row, np.int64(0), arm, present)
    count = delayed.shape[1]
    place = step % count
    for j in range(4):
        torque = physics.actuator_force[row, at.human[j]] - arm.torque[row, j]
        if moved:
            draws = noisy.sensor_draws
            noise = noisy.noise_scale[row] * draws[row, (step - 1) % draws.shape[1], j]
            delayed[row, place, j] = torque * (1.0 + noisy.interaction_noise * noise)
        else:
            for i in range(count):
                delayed[row, i, j] = torque
        measured[row, INTERACTION + j] = delayed[row, (place + 1) % count, j]


@njit(inline="always")
def listen(
    row: int,
    moved: bool,
    episode: Episode,
    intention: Intention,
    wearer: Wearer,
    noisy: NoisySensors,
    measured: Array,
) -> None:
    """Measures the EMG: the voluntary torque `emg_lead` samples ahead, noisy, low-passed."""
    step = episode.step[row]
    soon = int(min(step + noisy.emg_lead, intention.motion.angle.shape[1] - 1))
    feed_forward(row, soon, intention, wearer)
    for j in range(4):
        voluntary = wearer.arm.torque[row, j] + wearer.feedback.reflex[row, j]
        voluntary += wearer.feedback.correction[row, j]
        if moved:
            draws = noisy.sensor_draws
            noise = draws[row, (step - 1) % draws.shape[1], EMG_NOISES + j]
            received = voluntary * (1.0 + noisy.noise_scale[row] * noisy.emg_noise * noise)
            measured[row, EMG + j] += noisy.emg_smoothing * (received - measured[row, EMG + j])
        else:
            measured[row, EMG + j] = voluntary


@njit(cache=True, nogil=True)
def sense(
    rows: Whole,
    moved: bool,
    arms: Frozen[tuple[Physics, Addresses, Episode, Intention, Wearer, NoisySensors, Array]],
) -> None:
    """Reads the noisy sensors of some rows, after the control period's measurements."""
    physics, at, episode, intention, wearer, noisy, measured = thawed(arms)
    for k in range(rows.shape[0]):
        row = rows[k]
        if episode.diverged[row]:
            continue
        step = episode.step[row]
        for j in range(at.cuffs.shape[0]):
            force = measured[row, CUFFS + j]
            if moved:
                draws = noisy.sensor_draws
                noise = draws[row, (step - 1) % draws.shape[1], CUFF_NOISES + j]
                force += noisy.noise_scale[row] * noisy.cuff_noise * noise
            measured[row, CUFF_SENSOR + j] = force
        touch(row, moved, physics, at, episode, wearer.arm, noisy, measured)
        listen(row, moved, episode, intention, wearer, noisy, measured)
