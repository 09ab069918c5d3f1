"""Models around another model: `Held` holds its torque outside a range, `Asymmetric` bends it."""

from .asymmetric import LARGEST_DEGREE, Asymmetric, sprung
from .held import Held
from .wrapper import Wrapper

__all__ = ["LARGEST_DEGREE", "Asymmetric", "Held", "Wrapper", "sprung"]
