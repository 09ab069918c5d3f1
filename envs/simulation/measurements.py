"""The measurements of every control period: one row of numbers, and the column of each."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from typing import Any

import numpy as np
from numba import njit

from ...arrays import AnyArray

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
    ("belief", 4),  # N·m
    ("effort", 4),  # torque / strength
)


def _columns() -> tuple[dict[str, slice], int]:
    columns, end = {}, 0
    for name, size in _SIZES:
        columns[name] = slice(end, end + size)
        end += size
    return columns, end


COLUMNS, WIDTH = _columns()
"""The columns of each measurement by its name, and how many there are in all."""

NOISES = 17  # sensors' random numbers in a control period: interaction, EMG, cuffs
EMG_NOISES, CUFF_NOISES = 4, 8  # first random numbers of the latter two

PEAK, CONTINUOUS, TIME_CONSTANT = range(3)  # rows of `ratings` of the motors [N·m, N·m, s]
STILL = 1e-9  # [rad/s], greatest rate of an encoder that counts as zero

SENSED = (
    *("encoder_angle", "encoder_rate", "motor_torque", "previous_action", "preview"),
    *("interaction_torque", "emg", "cuff_sensor", "belief"),
)
"""Measurements of sensors; the others are of the simulation itself."""

SHAPES = {"fatigue": (2, 4), "cuff_force": (3, 3)}  # measurements that are no vectors

(
    TIME,
    ANGLE,
    RATE,
    TARGET,
    HUMAN,
    SUIT,
    ASSIST,
    HUMAN_ENERGY,
    ASSIST_ENERGY,
    DISSIPATED,
    LOAD,
    FATIGUE,
    CUFFS,
    ENCODER,
    ENCODER_RATE,
    MOTOR,
    PREVIOUS,
    PREVIEW,
    INTERACTION,
    EMG,
    CUFF_SENSOR,
    BELIEF,
    EFFORT,
) = (columns.start for columns in COLUMNS.values())


def snapshot(measured: AnyArray, columns: dict[str, slice]) -> dict[str, Any]:
    """Returns quantities of one row that no sensor measures, by name: numbers, or new arrays."""
    found: dict[str, Any] = {}
    for name, part in columns.items():
        if name in SENSED:
            continue
        if part.stop - part.start == 1:
            found[name] = float(measured[part.start])
        else:
            found[name] = measured[part].reshape(SHAPES.get(name, -1)).copy()
    return found


@njit(cache=True)
def is_finite(
    row: int,
    qpos: AnyArray,
    qvel: AnyArray,
    sensordata: AnyArray,
    suit_torque: AnyArray,
    dissipated: AnyArray,
) -> bool:
    """Returns whether motion, suit torque and dissipated energy of a row are finite."""
    total = 0.0
    for j in range(qpos.shape[1]):
        total += qpos[row, j] + qvel[row, j]
    for j in range(suit_torque.shape[0]):
        total += sensordata[row, suit_torque[j]] + sensordata[row, dissipated[j]]
    return math.isfinite(total)


@njit(cache=True)
def measure(  # noqa: PLR0912 (a loop for each measurement)
    row: int,
    measured: AnyArray,
    qpos: AnyArray,
    qvel: AnyArray,
    sensordata: AnyArray,
    actuator_force: AnyArray,
    angle: AnyArray,
    step: AnyArray,
    command: AnyArray,
    mean_square: AnyArray,
    fatigued: AnyArray,
    counts: AnyArray,
    offset: AnyArray,
    dissipated_before: AnyArray,
    joints: AnyArray,
    driven: AnyArray,
    assisted: AnyArray,
    human: AnyArray,
    assist: AnyArray,
    encoders: AnyArray,
    cuffs: AnyArray,
    suited: AnyArray,
    suit_torque: AnyArray,
    dissipated: AnyArray,
    ratings: AnyArray,
    ahead: AnyArray,
    count: float,
    smoothing: float,
    dt: float,
    moved: bool,
) -> None:
    """Reads all measurements of a row; after motion, also adds the energies of the period."""
    last = angle.shape[1] - 1
    now = min(step[row], last)
    for j in range(4):
        measured[row, ANGLE + j] = qpos[row, joints[j]]
        measured[row, RATE + j] = qvel[row, joints[j]]
        measured[row, TARGET + j] = angle[row, now, j]
        measured[row, HUMAN + j] = actuator_force[row, human[j]]
        measured[row, SUIT + j] = 0.0
    for j in range(suited.shape[0]):
        measured[row, SUIT + suited[j]] += sensordata[row, suit_torque[j]]
    work = 0.0
    for j in range(4):
        work += abs(measured[row, HUMAN + j] * measured[row, RATE + j])
    measured[row, HUMAN_ENERGY] += work * dt if moved else 0.0
    work = 0.0
    for j in range(assist.shape[0]):
        torque = actuator_force[row, assist[j]]
        measured[row, ASSIST + j] = torque
        measured[row, MOTOR + j] = torque / ratings[PEAK, j]
        measured[row, PREVIOUS + j] = command[row, j]
        measured[row, LOAD + j] = math.sqrt(mean_square[row, j]) / ratings[CONTINUOUS, j]
        work += abs(torque * qvel[row, driven[j]])
    measured[row, ASSIST_ENERGY] += work * dt if moved else 0.0
    work = 0.0
    for j in range(dissipated.shape[0]):
        work += sensordata[row, dissipated[j]]
    if not moved:
        dissipated_before[row] = work
    measured[row, DISSIPATED] = work - dissipated_before[row]
    for way in range(2):
        for j in range(4):
            measured[row, FATIGUE + 4 * way + j] = fatigued[row, way, j]
    for j in range(cuffs.shape[0]):
        measured[row, CUFFS + j] = sensordata[row, cuffs[j]]
    for j in range(4):
        shown = np.rint((sensordata[row, encoders[j]] + offset[row, j]) / count)
        if moved:
            turned = (shown - counts[row, j]) * count / dt
            slow = measured[row, ENCODER_RATE + j]
            slow += smoothing * (turned - slow)
            measured[row, ENCODER_RATE + j] = slow if abs(slow) > STILL else 0.0
        counts[row, j] = shown
        measured[row, ENCODER + j] = shown * count
    for i in range(ahead.shape[0]):
        later = min(now + ahead[i], last)
        for j in range(assisted.shape[0]):
            measured[row, PREVIEW + assisted.shape[0] * i + j] = angle[row, later, assisted[j]]
