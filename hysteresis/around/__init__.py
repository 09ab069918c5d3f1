"""Models around another model: its torque held outside a range of angles, or made asymmetric."""

from .asymmetric import LARGEST_DEGREE, Asymmetric
from .held import Held
from .wrapper import Wrapper

__all__ = ["LARGEST_DEGREE", "Asymmetric", "Held", "Wrapper"]
