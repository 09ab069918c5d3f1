"""The wearer, the coupling and the load, as command line options that several commands share."""

from dataclasses import dataclass
from typing import Annotated, Any

from ..envs.model import ArmConfig
from ..envs.model.config import COUPLINGS, SIDES
from ..envs.person.anthropometry import SEXES
from .options import choice

_USUAL = ArmConfig()


@dataclass(frozen=True, kw_only=True)
class ArmOptions:
    """Wearer, coupling and load.

    Attributes:
        pressure: Operating pressure of the suit [kPa], to which its torque is proportional; by
            default that of its file.
        coupling: Connection of the exoskeleton to the arm: rigid, elastic cuffs, or none, which
            means that there is no exoskeleton.
        side: Arm that wears the exoskeleton.
        stature: Height of the wearer [m].
        mass: Mass of the wearer's body [kg].
        sex: Sex of the wearer, which decides the proportions and the strength.
        strength: Percentile of the wearer's strength among people of that sex and mass.
        payload: Mass of the load at the hand [kg].
        tilt: Angles of the torso, forward and to the right [rad].
        allow_uncertified: Accept a suit whose torque could become infinite in some motion.
    """

    pressure: float | None = _USUAL.pressure
    coupling: Annotated[str, choice(lambda: COUPLINGS)] = _USUAL.coupling
    side: Annotated[str, choice(lambda: SIDES)] = _USUAL.side
    stature: float = _USUAL.wearer.stature
    mass: float = _USUAL.wearer.mass
    sex: Annotated[str, choice(lambda: SEXES)] = _USUAL.wearer.sex
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
