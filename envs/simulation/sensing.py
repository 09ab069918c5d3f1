"""Noisy and delayed sensors at the cuffs and on the person."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from ...arrays import AnyArray, Array
from ...checks import within
from ..provenance import Quantity
from .inverse_dynamics import arm_torque
from .measurements import CUFF_NOISES, CUFF_SENSOR, CUFFS, EMG, EMG_NOISES, INTERACTION
from .wearer import foresee

_PADS = "ours: pads between suit and skin yield and slip"
_EMG = "a round number of the size of the electromechanical delay, 30 to 80 ms"
_INTERACTION_NOISE = Quantity("sensing.interaction_noise", 0.10, "1", _PADS, "assumed")
_INTERACTION_DELAY = Quantity("sensing.interaction_delay", 0.05, "s", _PADS, "assumed")
_EMG_NOISE = Quantity(
    "sensing.emg_noise", 0.20, "1", "ours: a smoothed EMG varies by some ten percent", "assumed"
)
_EMG_LEAD = Quantity("sensing.emg_lead", 0.05, "s", _EMG, "assumed")
_EMG_CUTOFF = Quantity(
    "sensing.emg_cutoff", 6.0, "Hz", "a usual low-pass of the rectified EMG", "assumed"
)
_CUFF_NOISE = Quantity(
    "sensing.cuff_noise", 1.0, "N", "ours: 0.2 % of a load cell's usual range of 500 N", "assumed"
)
_RATE_CUTOFF = Quantity(
    "sensing.rate_cutoff", 20.0, "Hz", "a round number above the wearer's motion", "assumed"
)

PROVENANCE: tuple[Quantity, ...] = (
    _INTERACTION_NOISE,
    _INTERACTION_DELAY,
    _EMG_NOISE,
    _EMG_LEAD,
    _EMG_CUTOFF,
    _CUFF_NOISE,
    _RATE_CUTOFF,
)


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

    Raises:
        InputError: A value is outside its range.
    """

    rate_cutoff: float = _RATE_CUTOFF.value
    interaction_noise: float = _INTERACTION_NOISE.value
    interaction_delay: float = _INTERACTION_DELAY.value
    cuff_noise: float = _CUFF_NOISE.value
    emg_noise: float = _EMG_NOISE.value
    emg_lead: float = _EMG_LEAD.value
    emg_cutoff: float = _EMG_CUTOFF.value

    def __post_init__(self) -> None:
        for name, low, high, unit in (
            ("rate_cutoff", 0.1, 1000, " Hz"),
            ("interaction_noise", 0, 1, ""),
            ("interaction_delay", 0, 0.5, " s"),
            ("cuff_noise", 0, 100, " N"),
            ("emg_noise", 0, 1, ""),
            ("emg_lead", 0, 0.2, " s"),
            ("emg_cutoff", 0.1, 1000, " Hz"),
        ):
            within(f"sensing.{name}", getattr(self, name), low, high, unit)


def smoothing(cutoff: float | Array, dt: float) -> Any:
    """Returns the share of a step that a first-order low-pass [Hz] follows in one period."""
    return 1 - np.exp(-math.tau * cutoff * dt)


@njit(cache=True)
def touch(
    row: int,
    moved: bool,
    measured: AnyArray,
    felt: AnyArray,
    qpos: AnyArray,
    qvel: AnyArray,
    qacc: AnyArray,
    actuator_force: AnyArray,
    step: AnyArray,
    shaken: AnyArray,
    here_angle: AnyArray,
    here_rate: AnyArray,
    here_acceleration: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    loudness: AnyArray,
    interaction_noise: float,
) -> None:
    """Measures the torque between person and suit, delayed and noisy.

    It is the wearer's torque minus that of the bare arm in the present motion. `felt` is a ring
    buffer indexed by the step; the `here` arrays receive the present motion of the arm.
    """
    for j in range(4):
        here_angle[row, 0, j] = qpos[row, joints[j]]
        here_rate[row, 0, j] = qvel[row, joints[j]]
        here_acceleration[row, 0, j] = qacc[row, joints[j]]
    arm_torque(row, links, gravity, here_angle, here_rate, here_acceleration, 0, scratch, own)
    count = felt.shape[1]
    place = step[row] % count
    for j in range(4):
        torque = actuator_force[row, human[j]] - own[row, j]
        if moved:
            noise = loudness[row] * shaken[row, (step[row] - 1) % shaken.shape[1], j]
            felt[row, place, j] = torque * (1.0 + interaction_noise * noise)
        else:
            for i in range(count):
                felt[row, i, j] = torque
        measured[row, INTERACTION + j] = felt[row, (place + 1) % count, j]


@njit(cache=True)
def listen(
    row: int,
    moved: bool,
    measured: AnyArray,
    step: AnyArray,
    shaken: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    taught: AnyArray,
    gains: AnyArray,
    features: AnyArray,
    fed: AnyArray,
    held: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    loudness: AnyArray,
    emg_lead: int,
    emg_noise: float,
    emg_smoothing: float,
) -> None:
    """Measures the EMG: the voluntary torque `emg_lead` samples ahead, noisy, low-passed."""
    last = angle.shape[1] - 1
    soon = int(min(step[row] + emg_lead, last))
    foresee(
        row,
        soon,
        angle,
        rate,
        acceleration,
        links,
        gravity,
        scratch,
        taught,
        gains,
        features,
        own,
    )
    for j in range(4):
        voluntary = own[row, j] + fed[row, j] + held[row, j]
        if moved:
            noise = shaken[row, (step[row] - 1) % shaken.shape[1], EMG_NOISES + j]
            received = voluntary * (1.0 + loudness[row] * emg_noise * noise)
            measured[row, EMG + j] += emg_smoothing * (received - measured[row, EMG + j])
        else:
            measured[row, EMG + j] = voluntary


@njit(cache=True, nogil=True)
def sense(
    rows: AnyArray,
    moved: bool,
    measured: AnyArray,
    diverged: AnyArray,
    felt: AnyArray,
    qpos: AnyArray,
    qvel: AnyArray,
    qacc: AnyArray,
    actuator_force: AnyArray,
    step: AnyArray,
    shaken: AnyArray,
    here_angle: AnyArray,
    here_rate: AnyArray,
    here_acceleration: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    taught: AnyArray,
    gains: AnyArray,
    features: AnyArray,
    fed: AnyArray,
    held: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    loudness: AnyArray,
    cuffs: AnyArray,
    cuff_noise: float,
    interaction_noise: float,
    emg_lead: int,
    emg_noise: float,
    emg_smoothing: float,
) -> None:
    """Reads the noisy sensors of some rows, after the control period's measurements."""
    for k in range(rows.shape[0]):
        row = rows[k]
        if diverged[row]:
            continue
        for j in range(cuffs.shape[0]):
            force = measured[row, CUFFS + j]
            if moved:
                noise = shaken[row, (step[row] - 1) % shaken.shape[1], CUFF_NOISES + j]
                force += loudness[row] * cuff_noise * noise
            measured[row, CUFF_SENSOR + j] = force
        touch(
            row,
            moved,
            measured,
            felt,
            qpos,
            qvel,
            qacc,
            actuator_force,
            step,
            shaken,
            here_angle,
            here_rate,
            here_acceleration,
            links,
            gravity,
            scratch,
            own,
            joints,
            human,
            loudness,
            interaction_noise,
        )
        listen(
            row,
            moved,
            measured,
            step,
            shaken,
            angle,
            rate,
            acceleration,
            taught,
            gains,
            features,
            fed,
            held,
            links,
            gravity,
            scratch,
            own,
            loudness,
            emg_lead,
            emg_noise,
            emg_smoothing,
        )
