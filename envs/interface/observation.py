"""The observation of a controller, and the suites of sensors that make it up."""

# pyright: reportCallIssue=false

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numba import njit
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError, shown, unknown_name
from ..simulation.bound_kernels import bound
from ..simulation.measurements import WIDTH


@dataclass(frozen=True)
class Part:
    """One part of an observation."""

    name: str  # name of the part
    measurement: str  # name of the shown measurement
    limit: float  # size at which the part is clipped
    scale: float  # size that becomes 1 in a normalized observation
    unit: str  # unit of both
    shows: str  # description of the measurement


DEFAULT_SENSORS = ("encoders",)
SUITES: dict[str, tuple[Part, ...]] = {
    "encoders": (
        Part(
            *("angle", "encoder_angle", math.pi, math.pi, "rad"),
            "angles of the exoskeleton's four encoders",
        ),
        Part("rate", "encoder_rate", 20.0, 4.0, "rad/s", "their rates"),
        Part("motor_torque", "motor_torque", 1.0, 1.0, "1", "torque of both motors over the peak"),
        Part("previous_action", "previous_action", 1.0, 1.0, "1", "the last action"),
    ),
    "cuffs": (
        Part(
            *("cuff_force", "cuff_sensor", 1000.0, 100.0, "N"),
            "forces at the cuffs on upper arm, forearm and hand, noise of 1 N",
        ),
    ),
    "interaction": (
        Part(
            *("interaction_torque", "interaction_torque", 200.0, 20.0, "N·m"),
            "torque between person and suit at the four joints, as pads would measure it: "
            "10 % noise, 0.05 s old",
        ),
    ),
    "emg": (
        Part(
            *("emg", "emg", 200.0, 20.0, "N·m"),
            "the wearer's voluntary torque at the four joints, 0.05 s ahead of its effect, "
            "20 % noise, low-pass of 6 Hz",
        ),
    ),
    "preview": (
        Part(
            *("target", "preview", math.pi, math.pi, "rad"),
            "angles that the wearer intends at shoulder and elbow in 0.02, 0.1 and 0.24 s",
        ),
    ),
    "belief": (
        Part(
            *("belief", "belief", 200.0, 20.0, "N·m"),
            "torques of a believed model at shoulder and elbow: the resistance of the suit, then "
            "the torque that supports arm, suit, exoskeleton and load",
        ),
    ),
    "privileged": (
        Part(
            *("suit_torque", "suit_torque", 100.0, 20.0, "N·m"),
            "true torque of the suit on the four joints, which no device can measure",
        ),
    ),
}


BELIEF = slice(WIDTH, WIDTH + len(JOINTS))  # its place is behind the measurements
NOISY = ("cuffs", "interaction", "emg")  # suites whose sensors have random noise


class Picked(NamedTuple):
    """Columns that an observation shows, their factors, and their limits, shape (size,) each."""

    columns: NDArray[np.int64]
    factor: Array
    limit: NDArray[np.float32]


class Observer:
    """Picks observations out of measurements.

    `sensors` are names of suites from `checked_sensors`, in the order of the observation, and
    `columns` the columns of the measurements that exist, by name. With `normalize` each part is
    divided by its scale, and `history` observations make up one.

    Attributes: layout: Slice of the observation that contains each part, by the name of the part;
    with a history the newest observation comes first, and the layout is that of the newest. space:
    Observation space of one row.
    """

    def __init__(
        self, sensors: Sequence[str], columns: dict[str, slice], *, normalize: bool, history: int
    ) -> None:
        if isinstance(history, bool) or not isinstance(history, int) or not 1 <= history <= 1000:
            raise InputError(f"history is {shown(history)}: use a whole number from 1 to 1000")
        if "cuffs" in sensors and "cuff_sensor" not in columns:
            raise InputError(
                "sensors has 'cuffs', and this coupling has none: use coupling='cuffs', or leave "
                "the suite out"
            )
        self.sensors, self.normalized, self.history = tuple(sensors), normalize, history
        columns = {**columns, "belief": BELIEF}
        self.layout: dict[str, slice] = {}
        index, factors, limits = [], [], []
        for part in (part for name in sensors for part in SUITES[name]):
            place = columns.get(part.measurement, slice(0, 0))
            begin, size = len(index), place.stop - place.start
            if size:
                self.layout[part.name] = slice(begin, begin + size)
            index += range(place.start, place.stop)
            factors += [1 / part.scale if normalize else 1.0] * size
            limits += [part.limit * factors[-1]] * size if size else []
        self._index = np.array(index, np.int64)
        self._factor, self._limit = np.array(factors), np.array(limits, np.float32)
        like = np.empty((1, 1)), np.empty((1, 1)), np.empty((1, 1), np.float32)
        self._pick = bound(_pick, like, Picked(self._index, self._factor, self._limit))
        limit = np.tile(self._limit, history)
        self.space = Box(-limit, limit, dtype=np.float32)

    def __call__(self, measured: Array, belief: Array) -> NDArray[np.float32]:
        """Returns new observations without history, clipped to their limits, shape (n, size)."""
        observation = np.empty((len(measured), len(self._index)), np.float32)
        self._pick(measured, belief, observation)
        return observation


@njit(cache=True)
def _pick(measured, belief, observation, picked) -> None:
    index, factor, limit = picked.columns, picked.factor, picked.limit
    for row in range(measured.shape[0]):
        for j in range(index.shape[0]):
            i = index[j]
            given = measured[row, i] if i < WIDTH else belief[row, i - WIDTH]
            value = np.float32(given * factor[j])
            observation[row, j] = max(-limit[j], min(value, limit[j]))


def checked_sensors(given: Sequence[str]) -> tuple[str, ...]:
    """Returns the names of sensor suites."""
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise InputError(f"sensors is {shown(given)}: give a list of suites, such as ['encoders']")
    for name in given:
        if not isinstance(name, str) or name not in SUITES:
            raise unknown_name("sensor suite", name, SUITES)
        if list(given).count(name) > 1:
            raise InputError(f"sensors has {name!r} twice: name each suite once")
    if not given:
        raise InputError(f"sensors is empty: name at least one of {', '.join(SUITES)}")
    return tuple(given)
