"""Models around another model.

`Clipped` keeps the torque constant outside a range, `Asymmetric` adds an elastic polynomial,
`Backlash` adds play, and `Viscoelastic` adds a torque that depends on the rate.
"""

from .asymmetric import Asymmetric, sprung
from .backlash import Backlash
from .clipped import Clipped
from .viscoelastic import Viscoelastic, without_rate
from .wrapper import Wrapper

__all__ = [
    "Asymmetric",
    "Backlash",
    "Clipped",
    "Viscoelastic",
    "Wrapper",
    "sprung",
    "without_rate",
]
