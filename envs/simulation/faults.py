"""Sensors that read wrong, late or not at all, and motors that stop."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtri

from ...arrays import AnyArray, Array
from ...assets import JOINTS
from ...checks import once
from ...errors import InputError, shown, unknown_name
from ..model import ASSISTED
from ..provenance import check_settings, setting
from .measurements import COLUMNS, CUFF_SENSOR, ENCODER, ENCODER_RATE, INTERACTION
from .structs import Addresses, Reception, Whole

RECEIVED = ("encoder_angle", "encoder_rate", "motor_torque", "interaction_torque", "emg")
RECEIVED += ("cuff_sensor",)
"""Measurements that faults can change; a controller knows its last action and preview anyway."""
RECEPTION = np.concatenate([np.r_[COLUMNS[name]] for name in RECEIVED])
"""Columns of these measurements."""

LATE, LOST = range(2)  # random numbers of a control period


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Faults of sensors and motors, the same in every episode; without any by default.

    Attributes:
        torque_bias: Constant error of the interaction torque at every joint [N·m].
        torque_drift: Its change per time [N·m/s].
        force_bias: Constant error of each component of a cuff's force [N].
        force_drift: Its change per time [N/s].
        late: Chance that a control period brings the readings of the period before.
        lost: Chance that a control period brings no readings, so that the last ones stay.
        stuck: Joints whose encoders stay at their angle, with a rate of zero.
        stopped: Joints whose motors lose their power.
        since: Time at which encoders stick and motors stop [s].
    """

    torque_bias: float = setting(0.0, "N·m", -50, 50)
    torque_drift: float = setting(0.0, "N·m/s", -5, 5)
    force_bias: float = setting(0.0, "N", -500, 500)
    force_drift: float = setting(0.0, "N/s", -50, 50)
    late: float = setting(0.0, "1", 0, 1)
    lost: float = setting(0.0, "1", 0, 1)
    stuck: tuple[str, ...] = ()
    stopped: tuple[str, ...] = ()
    since: float = setting(0.0, "s", 0, 3600)

    def __post_init__(self) -> None:
        check_settings(self, "faults.")
        for name, known in (("stuck", JOINTS), ("stopped", ASSISTED)):
            given: Any = getattr(self, name)
            if isinstance(given, str) or not isinstance(given, list | tuple):
                raise InputError(
                    f"faults.{name} is {shown(given)}: give a list of joints, such as {[known[0]]}"
                )
            for joint in given:
                if joint not in known:
                    raise unknown_name(f"joint of faults.{name}", joint, known)
            once(f"faults.{name}", given)
            object.__setattr__(self, name, tuple(given))


class FaultInjector:
    """Puts faults into the readings that reach the controller; `cycle.drive` stops motors.

    Between two control periods the measurements, shape (n, columns), are the readings that the
    controller receives, and `sent` has the readings of the sensors. Within a control period both
    are exchanged, since sensors filter their own readings.
    """

    def __init__(
        self, faults: Faults, measured: Array, reception: Reception, addresses: Addresses
    ) -> None:
        self._faults, self._measured, self._memory = faults, measured, reception
        self._limits: Array = np.array([ndtri(faults.late), ndtri(faults.lost)])
        stuck = np.array([JOINTS.index(joint) for joint in faults.stuck], np.int64)
        self._stuck = np.isin(RECEPTION, np.r_[ENCODER + stuck, ENCODER_RATE + stuck])
        self._rates = np.flatnonzero(np.isin(RECEPTION, ENCODER_RATE + stuck))
        torque = np.isin(RECEPTION, INTERACTION + np.arange(4))
        force = np.isin(RECEPTION, CUFF_SENSOR + np.arange(addresses.cuffs.size))
        self._bias = faults.torque_bias * torque + faults.force_bias * force
        self._drift = faults.torque_drift * torque + faults.force_drift * force

    def begin(self, rows: Whole) -> None:
        """Delivers the first readings of an episode."""
        self._memory.sent[rows] = self._of(rows)
        self._put(rows, self._memory.sent[rows] + self._bias)

    def recall(self, rows: Whole) -> Array:
        """Restores the readings of the sensors; returns the readings that the controller has."""
        received = self._of(rows)
        self._put(rows, self._memory.sent[rows])
        return received

    def deliver(self, rows: Whole, received: Array, time: AnyArray, draws: Array) -> None:
        """Delivers new readings after a time since the reset [s]; `received` is that of `recall`.

        `draws` are random numbers with a normal distribution, shape (k, 2).
        """
        sent, before = self._of(rows), self._memory.sent[rows]
        late, lost = (draws < self._limits).T[..., None]
        new = np.where(late, before, sent) + self._bias + self._drift * time[:, None]
        self._memory.sent[rows] = sent
        failed = time[:, None] >= self._faults.since
        kept = np.where(lost | (failed & self._stuck), received, new)
        kept[:, self._rates] = np.where(failed, 0.0, kept[:, self._rates])
        self._put(rows, kept)

    def _of(self, rows: Whole) -> Array:
        return self._measured[rows[:, None], RECEPTION]

    def _put(self, rows: Whole, values: Array) -> None:
        self._measured[rows[:, None], RECEPTION] = values
