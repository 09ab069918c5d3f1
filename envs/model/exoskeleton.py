"""The exoskeleton: masses and links, and their fit to the drawn arm."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ...checks import at_least
from ..provenance import Quantity, check_settings, quantities_of, setting
from .motors import ELBOW_MOTOR, SHOULDER_MOTOR, Motor, set_motor

ASSISTED = ("shoulder_flexion", "elbow_flexion")  # the joints that carry a motor


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
        upper_arm_length: Distance from shoulder axis to elbow axis [m]; by default the wearer's.
        forearm_length: Distance from elbow axis to wrist axis [m]; by default the wearer's.
        encoder_bits: Resolution of an encoder, which has 2**bits counts per turn.
        encoder_delay: Age of the values that the encoders report [s].
    """

    shoulder: Motor = SHOULDER_MOTOR
    elbow: Motor = ELBOW_MOTOR
    upper_arm_link: float = setting(1.5, "kg", 0.01, 20, source="a round number")
    forearm_link: float = setting(1.0, "kg", 0.01, 20, source="a round number")
    cuff: float = setting(0.15, "kg", 0.01, 20, source="a round number")
    ring: float = setting(0.25, "kg", 0.01, 20, source="three rods of steel, of the size drawn")
    upper_arm_length: float | None = setting(None, "m", 0.15, 0.5)
    forearm_length: float | None = setting(None, "m", 0.15, 0.5)
    encoder_bits: int = setting(14, "1", 4, 32, source="usual for magnetic encoders")
    encoder_delay: float = setting(0.0, "s", 0, 0.1, source="none: read in the same control period")

    def __post_init__(self) -> None:
        at_least("exo.encoder_bits", self.encoder_bits, 4, 32)
        check_settings(self, "exo.")

    @property
    def lengths(self) -> dict[str, float | None]:
        """Lengths of the links by segment [m]; None means the length of the segment."""
        return {"upper_arm": self.upper_arm_length, "forearm": self.forearm_length}

    @property
    def motors(self) -> dict[str, Motor]:
        """The motors by the name of their joint, in the order of `ASSISTED`."""
        return dict(zip(ASSISTED, (self.shoulder, self.elbow), strict=True))


PROVENANCE: tuple[Quantity, ...] = (
    *(one for name, motor in Exo().motors.items() for one in quantities_of(motor, f"exo.{name}")),
    *quantities_of(Exo(), "exo"),
)


def fit_exoskeleton(spec: mujoco.MjSpec, exo: Exo) -> None:
    """Gives the drawn exoskeleton its motors and masses, in place.

    The wearer's strength must be set before: a joint bears wearer and motor together.
    """
    for joint, motor in exo.motors.items():
        set_motor(spec.actuator(f"assist_{joint}"), motor)
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
    """Removes the drawn exoskeleton, in place, after the keyframes have been removed."""
    names = [f"assist_{joint}" for joint in ASSISTED]
    meters = [sensor for sensor in spec.sensors if sensor.objname in names]
    motors = [spec.actuator(name) for name in names]
    parts = [body for body in spec.bodies if body.name.startswith("exo_")]
    for part in [*meters, *motors, *parts]:
        spec.delete(part)
    for joint in ASSISTED:
        spec.joint(joint).frictionloss = 0.0
