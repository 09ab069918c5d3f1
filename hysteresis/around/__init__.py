"""Models around another model.

`Held` holds its torque outside a range, `Asymmetric` bends it, `Backlash` puts it behind a gap, and
`Viscoelastic` lets it depend on the rate.
"""

from .asymmetric import LARGEST_DEGREE, Asymmetric, sprung
from .backlash import Backlash
from .held import Held
from .viscoelastic import Viscoelastic, without_rate
from .wrapper import Wrapper

__all__ = [
    "LARGEST_DEGREE",
    "Asymmetric",
    "Backlash",
    "Held",
    "Viscoelastic",
    "Wrapper",
    "sprung",
    "without_rate",
]
