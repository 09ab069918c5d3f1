"""The measurements of every control period, each a column of numbers; sensors with noise."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from ...arrays import Array
from ..provenance import Quantity, check_settings, quantities_of, setting
from .inverse_dynamics import arm_torque
from .structs import Addresses, Arms, Physics, Whole
from .wearer_control import feed_forward

# Name and size of each measurement, in the order of their columns.
_SIZES = (
    ("time", 1),  # s
    ("angle", 4),  # rad
    ("rate", 4),  # rad/s
    ("target_angle", 4),  # rad
    ("human_torque", 4),  # N·m
    ("suit_torque", 4),  # N·m
    ("assist_torque", 2),  # N·m
    ("human_energy", 1),  # J
    ("assist_energy", 1),  # J
    ("dissipated_energy", 1),  # J
    ("motor_load", 2),  # 1
    ("fatigue", 8),  # 1
    ("cuff_force", 9),  # N
    ("encoder_angle", 4),  # rad
    ("encoder_rate", 4),  # rad/s
    ("motor_torque", 2),  # torque / peak
    ("previous_action", 2),  # 1
    ("preview", 6),  # rad
    ("interaction_torque", 4),  # N·m
    ("emg", 4),  # N·m
    ("cuff_sensor", 9),  # N
    ("effort", 4),  # torque / strength
)


_ENDS = np.cumsum([size for _, size in _SIZES]).tolist()
COLUMNS = {name: slice(end - size, end) for (name, size), end in zip(_SIZES, _ENDS, strict=True)}
WIDTH = _ENDS[-1]
"""The columns of each measurement by its name, and the number of all columns."""

NOISES = 17  # sensors' random numbers in a control period: interaction, EMG, cuffs
EMG_NOISES, CUFF_NOISES = 4, 8  # first random numbers of the latter two

PEAK, CONTINUOUS, TIME_CONSTANT = range(3)  # rows of `ratings` of the motors [N·m, N·m, s]
STILL = 1e-9  # [rad/s], greatest rate of an encoder that counts as zero

SENSED = (
    *("encoder_angle", "encoder_rate", "motor_torque", "previous_action", "preview"),
    *("interaction_torque", "emg", "cuff_sensor"),
)
"""Measurements of sensors; the others are of the simulation itself."""

SHAPES = {"fatigue": (2, 4), "cuff_force": (3, 3)}  # measurements that are no vectors

_STARTS = [columns.start for columns in COLUMNS.values()]
TIME, ANGLE, RATE, TARGET, HUMAN, SUIT, ASSIST = _STARTS[:7]
HUMAN_ENERGY, ASSIST_ENERGY, DISSIPATED, LOAD, FATIGUE, CUFFS = _STARTS[7:13]
ENCODER, ENCODER_RATE, MOTOR, PREVIOUS, PREVIEW, INTERACTION, EMG = _STARTS[13:20]
CUFF_SENSOR, EFFORT = _STARTS[20:]


@njit(inline="always")
def is_finite(row: int, physics: Physics, at: Addresses) -> bool:
    """Returns whether motion, suit torque and dissipated energy of a row are finite."""
    total = 0.0
    for j in range(physics.qpos.shape[1]):
        total += physics.qpos[row, j] + physics.qvel[row, j]
    for j in range(at.suit_torque.shape[0]):
        total += physics.sensordata[row, at.suit_torque[j]]
        total += physics.sensordata[row, at.dissipated[j]]
    return math.isfinite(total)


@njit(inline="always")
def measure(row: int, moved: bool, arms: Arms) -> None:
    """Reads all measurements of a row; after motion, also adds the energies of the period."""
    physics, at, sensors = arms.physics, arms.at, arms.sensors
    target, measured, sensordata = arms.intention.motion.angle, sensors.measured, physics.sensordata
    last = target.shape[1] - 1
    now = min(arms.episode.step[row], last)
    for j in range(4):
        measured[row, ANGLE + j] = physics.qpos[row, at.joints[j]]
        measured[row, RATE + j] = physics.qvel[row, at.joints[j]]
        measured[row, TARGET + j] = target[row, now, j]
        measured[row, HUMAN + j] = physics.actuator_force[row, at.human[j]]
        measured[row, SUIT + j] = 0.0
    for j in range(at.suited.shape[0]):
        measured[row, SUIT + at.suited[j]] += sensordata[row, at.suit_torque[j]]
    work(row, moved, arms)
    for way in range(2):
        for j in range(4):
            measured[row, FATIGUE + 4 * way + j] = arms.muscles.fatigued[row, way, j]
    for j in range(at.cuffs.shape[0]):
        measured[row, CUFFS + j] = sensordata[row, at.cuffs[j]]
    encode(row, moved, arms)
    for i in range(sensors.preview.shape[0]):
        later = min(now + sensors.preview[i], last)
        for j in range(at.assisted.shape[0]):
            column = PREVIEW + at.assisted.shape[0] * i + j
            measured[row, column] = target[row, later, at.assisted[j]]


@njit(inline="always")
def work(row: int, moved: bool, arms: Arms) -> None:
    """Measures the motors, and adds the work of wearer, motors and suit in the period."""
    physics, at, motors, sensors = arms.physics, arms.at, arms.motors, arms.sensors
    dt = arms.episode.dt
    measured, ratings, done = sensors.measured, motors.ratings, 0.0
    for j in range(4):
        done += abs(measured[row, HUMAN + j] * measured[row, RATE + j])
    measured[row, HUMAN_ENERGY] += done * dt if moved else 0.0
    done = 0.0
    for j in range(at.assist.shape[0]):
        torque = physics.actuator_force[row, at.assist[j]]
        measured[row, ASSIST + j] = torque
        measured[row, MOTOR + j] = torque / ratings[PEAK, j]
        measured[row, PREVIOUS + j] = motors.command[row, j]
        measured[row, LOAD + j] = math.sqrt(motors.mean_square[row, j]) / ratings[CONTINUOUS, j]
        done += abs(torque * physics.qvel[row, at.driven[j]])
    measured[row, ASSIST_ENERGY] += done * dt if moved else 0.0
    done = 0.0
    for j in range(at.dissipated.shape[0]):
        done += physics.sensordata[row, at.dissipated[j]]
    if not moved:
        sensors.dissipated_at_reset[row] = done
    measured[row, DISSIPATED] = done - sensors.dissipated_at_reset[row]


@njit(inline="always")
def encode(row: int, moved: bool, arms: Arms) -> None:
    """Reads the encoders: counts, and low-passed differences of counts."""
    sensors, dt = arms.sensors, arms.episode.dt
    measured, counts = sensors.measured, sensors.encoder_counts
    for j in range(4):
        angle = arms.physics.sensordata[row, arms.at.encoders[j]] + sensors.encoder_offset[row, j]
        shown = np.rint(angle / sensors.resolution)
        if moved:
            turned = (shown - counts[row, j]) * sensors.resolution / dt
            slow = measured[row, ENCODER_RATE + j]
            slow += sensors.smoothing * (turned - slow)
            measured[row, ENCODER_RATE + j] = slow if abs(slow) > STILL else 0.0
        counts[row, j] = shown
        measured[row, ENCODER + j] = shown * sensors.resolution


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
def touch(row: int, moved: bool, arms: Arms) -> None:
    """Measures the torque between person and suit, delayed and noisy.

    This torque is the wearer's torque minus the torque of the bare arm in the present motion.
    """
    physics, at, arm, noisy = arms.physics, arms.at, arms.wearer.arm, arms.noisy
    present, delayed, step = noisy.present, noisy.interaction_delay, arms.episode.step[row]
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
        arms.sensors.measured[row, INTERACTION + j] = delayed[row, (place + 1) % count, j]


@njit(inline="always")
def listen(row: int, moved: bool, arms: Arms) -> None:
    """Measures the EMG: the voluntary torque `emg_lead` samples ahead, noisy, low-passed."""
    intention, wearer, noisy = arms.intention, arms.wearer, arms.noisy
    step, measured = arms.episode.step[row], arms.sensors.measured
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
def sense(rows: Whole, moved: bool, arms: Arms) -> None:
    """Reads the noisy sensors of some rows, after the control period's measurements."""
    noisy, measured = arms.noisy, arms.sensors.measured
    for k in range(rows.shape[0]):
        row = rows[k]
        if arms.episode.diverged[row]:
            continue
        step = arms.episode.step[row]
        for j in range(arms.at.cuffs.shape[0]):
            force = measured[row, CUFFS + j]
            if moved:
                draws = noisy.sensor_draws
                noise = draws[row, (step - 1) % draws.shape[1], CUFF_NOISES + j]
                force += noisy.noise_scale[row] * noisy.cuff_noise * noise
            measured[row, CUFF_SENSOR + j] = force
        touch(row, moved, arms)
        listen(row, moved, arms)
