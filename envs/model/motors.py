"""The exoskeleton's motors: torque loop, friction, and the heat that limits their torque.

A motor is MuJoCo's `dcmotor` with a torque as control [N·m]. Its torque follows the command with
the first-order lag of its torque loop, up to what its voltage leaves: from the peak torque at
stall, the net torque falls linearly to zero at the no-load speed. Reflected inertia and viscous
friction belong to the actuator, Coulomb friction to the joint that carries it.
"""

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numba import njit

from ...errors import InputError
from ..provenance import REQUIRED, check_settings, setting

ROUND = "a round number of the size of robot joints (CubeMars AK80, 0.5 to 0.85 kg, 18 to 120 N·m)"
_FRICTION = (
    "8 % of the peak, rounded: Harmonic Drive's CSF-25-50 starts at 0.15 N·m, times 50 that is "
    "7.7 % of its repeated peak torque, 98 N·m; back-driving takes 9 N·m (a copy of the "
    "product page)"
)
_SPEED = "that of a CubeMars AK80-64 at 48 V, 48 turns per minute"
_INERTIA = "50:1 gear and a rotor of 1e-5 kg·m²: 0.025 kg·m²; rounded by size"
_BANDWIDTH = "3.7 Hz in an elbow exoskeleton (PMC6953725), more without its cables"


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A geared motor with its torque loop; all values refer to the joint.

    Attributes:
        peak_torque: Greatest torque, at stall and when braking [N·m].
        continuous_torque: Greatest root mean square of the torque that it sustains forever [N·m].
        no_load_speed: Speed at which full voltage leaves no torque for the joint [rad/s].
        armature: Reflected inertia of rotor and gear [kg·m²].
        coulomb: Friction torque at any speed [N·m].
        viscous: Friction torque per speed [N·m·s/rad].
        bandwidth: Bandwidth of the torque loop, which is of first order [Hz].
        thermal_time_constant: Thermal time constant of the winding [s].
        mass: Mass of motor and gear [kg]; the elbow's sits on the link of the upper arm.
    """

    peak_torque: float = setting(REQUIRED, "N·m", 1, 500, source=ROUND)
    continuous_torque: float = setting(REQUIRED, "N·m", 0.1, 500, source="40 % of the peak")
    no_load_speed: float = setting(REQUIRED, "rad/s", 0.5, 100, source=_SPEED)
    armature: float = setting(REQUIRED, "kg·m²", 1e-4, 1, source=_INERTIA)
    coulomb: float = setting(REQUIRED, "N·m", 0, 20, source=_FRICTION, grade="derived")
    viscous: float = setting(
        REQUIRED, "N·m·s/rad", 0, 20, source="a round number below the arm's own"
    )
    bandwidth: float = setting(REQUIRED, "Hz", 0.1, 80, source=_BANDWIDTH)
    thermal_time_constant: float = setting(
        REQUIRED, "s", 0.1, 1e4, source="a round number of the size of small windings"
    )
    mass: float = setting(REQUIRED, "kg", 0.05, 10, source=ROUND)

    def __post_init__(self) -> None:
        check_settings(self, "a motor's ")
        if self.continuous_torque > self.peak_torque:
            raise InputError(
                f"a motor's continuous_torque is {self.continuous_torque}: use at most its "
                f"peak_torque, {self.peak_torque}"
            )
        if self.viscous * self.no_load_speed >= self.peak_torque:
            raise InputError(
                f"a motor's viscous friction is {self.viscous}: at its no_load_speed that takes "
                f"all of the peak_torque; use less than {self.peak_torque / self.no_load_speed:g}"
            )


SHOULDER_MOTOR = Motor(
    peak_torque=40.0,
    continuous_torque=16.0,
    no_load_speed=5.0,
    armature=0.03,
    coulomb=3.0,
    viscous=0.2,
    bandwidth=10.0,
    thermal_time_constant=60.0,
    mass=0.9,
)
ELBOW_MOTOR = replace(
    SHOULDER_MOTOR,
    **{"peak_torque": 25.0, "continuous_torque": 10.0, "armature": 0.02},
    **{"coulomb": 2.0, "viscous": 0.1, "mass": 0.6},
)


def set_motor(actuator: mujoco.MjsActuator, motor: Motor) -> None:
    """Makes an actuator of a specification this motor."""
    # The unit of current gives 1 N·m, so that the activation is the torque. The
    # voltage turns the unloaded motor, with its viscous friction, at no-load speed.
    drag = motor.viscous * motor.no_load_speed
    resistance = motor.no_load_speed / (motor.peak_torque - drag)
    actuator.actlimited = actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_AUTO
    actuator.actrange = np.zeros(2)
    actuator.armature = motor.armature
    actuator.damping = np.array([motor.viscous, 0, 0])
    actuator.ctrlrange = motor.peak_torque * np.array([-1, 1])
    actuator.set_to_dcmotor(
        motorconst=[1, 1],
        resistance=resistance,
        saturation=[motor.peak_torque, 0, 0],
        inductance=[0, 1 / (2 * np.pi * motor.bandwidth)],
        controller=[0, 0, 0, 0, 0, resistance * motor.peak_torque],
        ctrlspec=mujoco.mjtCtrlInput.mjINPUT_FF.value,
    )


@njit(cache=True)
def heated(mean_square: float, torque: float, time_constant: float, dt: float) -> float:
    """Returns the running mean square of a motor's torque [N²·m²], which heats the windings.

    A motor is overloaded while the root of the result exceeds the continuous torque. The result is
    exact for a `torque` [N·m] that is constant during `dt` [s]; `time_constant` is that of the
    windings [s].
    """
    remains = math.exp(-dt / time_constant)
    return torque * torque + remains * (mean_square - torque * torque)


@njit(cache=True)
def clipped(
    torque: float, mean_square: float, continuous: float, time_constant: float, dt: float
) -> float:
    """Returns the torque, limited so that the mean square stays below the continuous one."""
    remains = math.exp(-dt / time_constant)
    allowed = (continuous * continuous - remains * mean_square) / (1.0 - remains)
    limit = math.sqrt(max(allowed, 0.0))
    return max(-limit, min(torque, limit))
