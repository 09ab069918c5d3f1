"""From the plain MJCF files and a suit file to a MuJoCo model with the suit inside the physics."""

from dataclasses import dataclass

import mujoco

from ..assets import SCENE, load_suit
from ..errors import InputError, unknown_name
from ..hysteresis.engine import attach

GRAVITY = {"earth": 9.81, "mars": 3.71, "moon": 1.62, "microgravity": 0.0}  # m/s^2
ASSISTED = ("shoulder_flexion", "elbow_flexion")  # the joints that carry a motor
SIM_DT_RANGE = (1e-5, 0.01)  # s


@dataclass(frozen=True, kw_only=True)
class ArmConfig:
    """What to compose. All fields are plain values, so a config converts to JSON.

    Attributes:
        suit: name of a shipped suit, or path of a suit file.
        gravity: "earth", "mars", "moon" or "microgravity".
        sim_dt: physics step [s].
        allow_uncertified: accept suits whose torque could become infinite in some motion.
    """

    suit: str = "mock-suit"
    gravity: str = "earth"
    sim_dt: float = 0.002
    allow_uncertified: bool = False


def compose(config: ArmConfig) -> mujoco.MjModel:
    """Builds the arm, suit and exoskeleton of `config`.

    Raises:
        InputError: an unknown gravity or suit, or a step outside 1e-5 to 0.01 s.
        UncertifiedModelError: the suit is not certified and `allow_uncertified` is not set.
    """
    if config.gravity not in GRAVITY:
        raise unknown_name("gravity", config.gravity, GRAVITY)
    low, high = SIM_DT_RANGE
    if not low <= config.sim_dt <= high:
        raise InputError(f"sim_dt is {config.sim_dt}: use a step from {low:g} to {high:g} s")
    suit = load_suit(config.suit)
    spec = mujoco.MjSpec.from_file(str(SCENE))
    spec.option.timestep = config.sim_dt
    spec.option.gravity = [0, 0, -GRAVITY[config.gravity]]
    for joint, entry in suit.joints.items():
        attach(
            spec,
            joint,
            entry.model,
            start_angle=entry.start_angle,
            start_torque=entry.start_torque,
            allow_uncertified=config.allow_uncertified,
        )
    return spec.compile()


def bare_arm(gravity: str) -> mujoco.MjModel:
    """Returns the wearer's arm alone: no suit, no exoskeleton, no motor friction or inertia."""
    spec = mujoco.MjSpec.from_file(str(SCENE))
    spec.option.gravity = [0, 0, -GRAVITY[gravity]]
    worn = [body for body in spec.bodies if body.name.startswith(("suit_", "exo_"))]
    # Inertias are explicit, so shapes can go too: inverse dynamics is then three times faster.
    for part in [*spec.keys, *spec.sensors, *spec.actuators, *worn]:
        spec.delete(part)
    for part in [*spec.geoms, *spec.sites]:
        spec.delete(part)
    for joint in spec.joints:
        joint.armature = joint.frictionloss = 0.0
    # The body between the two shoulder axes only carries the motor: next to nothing remains.
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6
    return spec.compile()
