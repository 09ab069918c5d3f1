"""Who wears what, as command line options that several commands share."""

from dataclasses import dataclass
from typing import Any

from ..envs.model import ArmConfig

_USUAL = ArmConfig()


@dataclass(frozen=True, kw_only=True)
class ArmOptions:
    """Wearer, coupling and load.

    Attributes:
        pressure: of the suit [kPa], to which its torque is proportional; by default its file's.
        coupling: of the exoskeleton: rigid, cuffs (elastic), or none (no exoskeleton).
        side: right or left arm.
        stature: of the wearer [m].
        mass: of the wearer's body [kg].
        sex: of the wearer, male or female.
        strength: of the wearer, percentile among people of that sex and mass.
        payload: mass at the hand [kg].
        tilt: of the torso, forward and to the right [rad].
        allow_uncertified: accept a suit whose torque could become infinite in some motion.
    """

    pressure: float | None = _USUAL.pressure
    coupling: str = _USUAL.coupling
    side: str = _USUAL.side
    stature: float = _USUAL.wearer.stature
    mass: float = _USUAL.wearer.mass
    sex: str = _USUAL.wearer.sex
    strength: float = _USUAL.wearer.strength
    payload: float = _USUAL.payload.mass
    tilt: tuple[float, float] = _USUAL.tilt
    allow_uncertified: bool = _USUAL.allow_uncertified

    def config(self, suit: str, gravity: str) -> dict[str, Any]:
        """Returns the fields of `ArmConfig`, as plain values."""
        return {
            "suit": suit,
            "pressure": self.pressure,
            "gravity": gravity,
            "wearer": {
                "stature": self.stature,
                "mass": self.mass,
                "sex": self.sex,
                "strength": self.strength,
            },
            "coupling": self.coupling,
            "payload": {"mass": self.payload},
            "side": self.side,
            "tilt": list(self.tilt),
            "allow_uncertified": self.allow_uncertified,
        }


USUAL = ArmOptions()
