"""The exoskeleton's motors: the torque that they are commanded, and their thermal limit."""

import math

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..errors import InputError, shown
from .model import Exo, thermal_clip, thermal_step
from .wiring import Wiring


def checked(action: ArrayLike, shape: tuple[int, ...]) -> tuple[Array, bool]:
    """Returns the action clipped to [-1, 1], and whether that changed it.

    Raises:
        InputError: The action has another shape, or is not of finite numbers.
    """
    try:
        given = np.asarray(action)
    except ValueError:  # lists of several lengths
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "iuf":
        raise InputError(f"action is {shown(action)}: give {shape[0]} numbers from -1 to 1")
    command = given.astype(np.float64)  # a copy: the caller may reuse the array
    if command.shape != shape:
        raise InputError(
            f"action has shape {command.shape}: give {shape}, one number for every motor"
        )
    values = command.tolist()
    if not all(map(math.isfinite, values)):
        raise InputError(f"action is {values}: give finite numbers from -1 to 1")
    if max(map(abs, values), default=0.0) > 1.0:
        return np.clip(command, -1.0, 1.0), True
    return command, False


class Motors:
    """Turns commands into motor torques that do not overheat the windings.

    Args:
        exo: The exoskeleton.
        wiring: Addresses of the model, which may have no motors.
        dt: Control period [s].

    Attributes:
        mean_square: Running mean square of the torques [N²·m²], shape (motors,).
    """

    def __init__(self, exo: Exo, wiring: Wiring, dt: float) -> None:
        self._wiring, self._dt = wiring, dt
        motors = list(exo.motors.values())[: wiring.motors.size]
        self._continuous = np.array([motor.continuous_torque for motor in motors])
        self._time_constant = np.array([motor.thermal_time_constant for motor in motors])
        self.mean_square = np.zeros(len(motors))

    @property
    def load(self) -> Array:
        """Root mean square of the torques, divided by the continuous torques, shape (motors,)."""
        return np.sqrt(self.mean_square) / self._continuous

    def drive(self, data: mujoco.MjData, command: Array) -> None:
        """Sets motor torques from normalized commands, clipped by the thermal limit."""
        data.ctrl[self._wiring.motors] = thermal_clip(
            command * self._wiring.peak_torque,
            self.mean_square,
            continuous=self._continuous,
            time_constant=self._time_constant,
            dt=self._dt,
        )

    def heat(self, data: mujoco.MjData) -> None:
        """Updates the mean square by the torque of the control period that has passed."""
        self.mean_square = thermal_step(
            self.mean_square,
            data.actuator_force[self._wiring.assist],
            time_constant=self._time_constant,
            dt=self._dt,
        )
