"""The exoskeleton's motors, encoders and masses, and the thermal limit of its motors.

A motor is MuJoCo's `dcmotor` with a torque as control [N·m]. Its torque follows the command with
the first-order lag of its torque loop, up to what its voltage leaves: from the peak torque at
stall, the net torque falls linearly to zero at the no-load speed. Reflected inertia and viscous
friction belong to the actuator, Coulomb friction to the joint that carries it.
"""

import math
from dataclasses import dataclass, fields

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import within
from ...errors import InputError
from ..elementwise import elementwise
from ..provenance import Grade, Quantity
from .motor_kernels import clipped, heated

ASSISTED = ("shoulder_flexion", "elbow_flexion")  # the joints that carry a motor


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

    Raises:
        InputError: a value is outside its range, or the continuous torque exceeds the peak.
    """

    peak_torque: float
    continuous_torque: float
    no_load_speed: float
    armature: float
    coulomb: float
    viscous: float
    bandwidth: float
    thermal_time_constant: float
    mass: float

    def __post_init__(self) -> None:
        ranges = {"peak_torque": (1, 500), "continuous_torque": (0.1, 500)}
        ranges |= {"no_load_speed": (0.5, 100), "armature": (1e-4, 1), "coulomb": (0, 20)}
        ranges |= {"viscous": (0, 20), "bandwidth": (0.1, 80), "mass": (0.05, 10)}
        ranges |= {"thermal_time_constant": (0.1, 1e4)}
        for field in fields(self):
            within(f"a motor's {field.name}", getattr(self, field.name), *ranges[field.name])
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
ELBOW_MOTOR = Motor(
    peak_torque=25.0,
    continuous_torque=10.0,
    no_load_speed=5.0,
    armature=0.02,
    coulomb=2.0,
    viscous=0.1,
    bandwidth=10.0,
    thermal_time_constant=60.0,
    mass=0.6,
)


@dataclass(frozen=True, kw_only=True)
class Exo:
    """An exoskeleton arm: two motors, links as long as the wearer's arm, cuffs, ring, encoders.

    Attributes:
        shoulder: Motor of shoulder flexion.
        elbow: Motor of elbow flexion.
        upper_arm_link: Mass of the link beside the upper arm [kg].
        forearm_link: Mass of the link beside the forearm [kg].
        cuff: Mass of each of the two arched guards [kg].
        ring: Mass of the U-shaped ring at the hand [kg].
        upper_arm_length: Distance from its shoulder axis to its elbow axis [m]; by default the
            wearer's.
        forearm_length: Distance from its elbow axis to its wrist axis [m]; by default the wearer's.
        encoder_bits: Resolution of an encoder, which has 2**bits counts per turn (see `quantize`).
        encoder_delay: Age of the values that the encoders report [s].

    Raises:
        InputError: a value is outside its range.
    """

    shoulder: Motor = SHOULDER_MOTOR
    elbow: Motor = ELBOW_MOTOR
    upper_arm_link: float = 1.5
    forearm_link: float = 1.0
    cuff: float = 0.15
    ring: float = 0.25
    upper_arm_length: float | None = None
    forearm_length: float | None = None
    encoder_bits: int = 14
    encoder_delay: float = 0.0

    def __post_init__(self) -> None:
        for name in ("upper_arm_link", "forearm_link", "cuff", "ring"):
            within(f"exo.{name}", getattr(self, name), 0.01, 20, " kg")
        for name, length in self.lengths.items():
            if length is not None:
                within(f"exo.{name}_length", length, 0.15, 0.5, " m")
        if self.encoder_bits not in range(4, 33):
            raise InputError(
                f"exo.encoder_bits is {self.encoder_bits}: use 4 to 32, a whole number"
            )
        within("exo.encoder_delay", self.encoder_delay, 0, 0.1, " s")

    @property
    def lengths(self) -> dict[str, float | None]:
        """Lengths of the links by segment [m]; None means the length of the segment."""
        return {"upper_arm": self.upper_arm_length, "forearm": self.forearm_length}

    @property
    def motors(self) -> dict[str, Motor]:
        """The motors by the name of their joint, in the order of `ASSISTED`."""
        return dict(zip(ASSISTED, (self.shoulder, self.elbow), strict=True))


_ROUND = "a round number of the size of robot joints (CubeMars AK80, 0.5 to 0.85 kg, 18 to 120 N·m)"
_FRICTION = (
    "8 % of the peak, rounded: Harmonic Drive's CSF-25-50 starts at 0.15 N·m, times 50 that is "
    "7.7 % of its repeated peak torque, 98 N·m; back-driving takes 9 N·m (a copy of the "
    "product page)"
)
_MOTOR_SOURCES: dict[str, tuple[str, str]] = {
    "peak_torque": ("N·m", _ROUND),
    "continuous_torque": ("N·m", "40 % of the peak"),
    "no_load_speed": ("rad/s", "that of a CubeMars AK80-64 at 48 V, 48 turns per minute"),
    "armature": ("kg·m²", "50:1 gear and a rotor of 1e-5 kg·m²: 0.025 kg·m²; rounded by size"),
    "coulomb": ("N·m", _FRICTION),
    "viscous": ("N·m·s/rad", "a round number below the arm's own"),
    "bandwidth": ("Hz", "3.7 Hz in an elbow exoskeleton (PMC6953725), more without its cables"),
    "thermal_time_constant": ("s", "a round number of the size of small windings"),
    "mass": ("kg", _ROUND),
}
_EXO_SOURCES: dict[str, tuple[str, str]] = {
    "upper_arm_link": ("kg", "a round number"),
    "forearm_link": ("kg", "a round number"),
    "cuff": ("kg", "a round number"),
    "ring": ("kg", "three rods of steel, of the size drawn"),
    "encoder_bits": ("1", "usual for magnetic encoders"),
    "encoder_delay": ("s", "none: read in the same control period"),
}
_GRADES: dict[str, Grade] = {"coulomb": "derived"}  # the others are assumed

PROVENANCE: tuple[Quantity, ...] = (
    *(
        Quantity(f"exo.{joint}.{name}", getattr(motor, name), *source, _GRADES.get(name, "assumed"))
        for joint, motor in Exo().motors.items()
        for name, source in _MOTOR_SOURCES.items()
    ),
    *(
        Quantity(f"exo.{name}", getattr(Exo(), name), *source, "assumed")
        for name, source in _EXO_SOURCES.items()
    ),
)


def fit_exoskeleton(spec: mujoco.MjSpec, exo: Exo) -> None:
    """Gives the drawn exoskeleton its motors and masses, in place.

    The wearer's strength must be set before: a joint bears wearer and motor together.
    """
    for joint, motor in exo.motors.items():
        _set_motor(spec.actuator(f"assist_{joint}"), motor)
        carrier = spec.joint(joint)
        carrier.frictionloss = motor.coulomb
        carrier.actfrcrange = carrier.actfrcrange + motor.peak_torque * np.array([-1, 1])
    masses = {"shoulder_motor": exo.shoulder.mass, "elbow_motor": exo.elbow.mass}
    masses |= {"upper_arm_link": exo.upper_arm_link, "forearm_link": exo.forearm_link}
    masses |= {"upper_arm_cuff": exo.cuff, "forearm_cuff": exo.cuff}
    for part, mass in masses.items():
        spec.geom(f"exo_{part}").mass = mass
    hand = spec.body("exo_hand")
    hand.inertia = hand.inertia * (exo.ring / hand.mass)
    hand.mass = exo.ring


def remove_exoskeleton(spec: mujoco.MjSpec) -> None:
    """Removes the drawn exoskeleton, in place; keyframes must be removed before."""
    names = [f"assist_{joint}" for joint in ASSISTED]
    meters = [sensor for sensor in spec.sensors if sensor.objname in names]
    motors = [spec.actuator(name) for name in names]
    parts = [body for body in spec.bodies if body.name.startswith("exo_")]
    for part in [*meters, *motors, *parts]:
        spec.delete(part)
    for joint in ASSISTED:
        spec.joint(joint).frictionloss = 0.0


def delay_encoders(spec: mujoco.MjSpec, delay: float) -> None:
    """Delays the angles and rates that the encoders of `spec` report by `delay` [s].

    A reset sets the encoders' memory to zeros, and `start_encoders` then fills it.
    """
    if delay > 0:
        for sensor in spec.sensors:
            if sensor.name.startswith("encoder_"):
                sensor.delay = delay
                sensor.nsample = math.ceil(delay / spec.option.timestep - 1e-9)


def start_encoders(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Fills the delayed encoders after a reset, as if the state of `data` had always been there."""
    for i in np.flatnonzero(model.sensor_delay):
        if not model.sensor(i).name.startswith("encoder_"):
            continue
        joint = model.sensor_objid[i]
        if model.sensor_type[i] == mujoco.mjtSensor.mjSENS_JOINTPOS:
            now = data.qpos[model.jnt_qposadr[joint]]
        else:
            now = data.qvel[model.jnt_dofadr[joint]]
        values = np.full((model.sensor_history[i, 0], 1), now)
        mujoco.mj_initSensorHistory(model, data, i, None, values, 0.0)


def quantize(angle: ArrayLike, bits: int) -> Array:
    """Returns angles [rad] rounded to the counts of an encoder with 2**bits per turn, any shape."""
    count = math.tau / 2**bits
    return np.rint(np.divide(angle, count)) * count


def thermal_step(
    mean_square: ArrayLike, torque: ArrayLike, *, time_constant: ArrayLike, dt: float
) -> Array:
    """Advances the running mean square of motors' torques, which heats their windings.

    A motor is overloaded while the root of the result exceeds its continuous torque. The result is
    exact for a torque that is constant during `dt`.

    Args:
        mean_square: Mean square at the beginning [N²·m²], any shape.
        torque: Torque during `dt` [N·m], same shape.
        time_constant: Thermal time constant of the windings [s].
        dt: Duration [s].

    Returns:
        The mean square at the end [N²·m²].
    """
    return elementwise(heated)(mean_square, torque, time_constant, dt)


def thermal_clip(
    torque: ArrayLike,
    mean_square: ArrayLike,
    *,
    continuous: ArrayLike,
    time_constant: ArrayLike,
    dt: float,
) -> Array:
    """Returns torques, limited so that no motor is overloaded within the next `dt` [N·m].

    A motor that is driven hard ends at its continuous torque; an overloaded one cools down.

    Args:
        torque: Torque that is wanted [N·m], any shape.
        mean_square: Mean square from `thermal_step` [N²·m²], same shape.
        continuous: Continuous torques of the motors [N·m].
        time_constant: Thermal time constant of the windings [s].
        dt: Duration [s].
    """
    return elementwise(clipped)(torque, mean_square, continuous, time_constant, dt)


def _set_motor(actuator: mujoco.MjsActuator, motor: Motor) -> None:
    # The unit of current is the one that gives 1 N·m, so that the activation is the torque. The
    # voltage is the one that turns the unloaded motor, with its viscous friction, at no-load speed.
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
