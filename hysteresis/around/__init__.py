"""Models around another model.

`Held` holds its torque outside a range, `Asymmetric` bends it, `Viscoelastic` lets it depend on the
rate.
"""

from .asymmetric import LARGEST_DEGREE, Asymmetric, sprung
from .held import Held
from .viscoelastic import Viscoelastic
from .wrapper import Wrapper

__all__ = ["LARGEST_DEGREE", "Asymmetric", "Held", "Viscoelastic", "Wrapper", "sprung"]
