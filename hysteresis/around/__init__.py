"""Models around another model.

`Clipped` keeps the torque constant outside a range, `Asymmetric` adds an elastic polynomial,
`Backlash` adds play, and `Viscoelastic` adds a torque that depends on the rate.
"""

from .models import (
    Asymmetric,
    Backlash,
    Clipped,
    Parts,
    Viscoelastic,
    Wrapper,
    parts,
    sprung,
    without_rate,
)

__all__ = [
    "Asymmetric",
    "Backlash",
    "Clipped",
    "Parts",
    "Viscoelastic",
    "Wrapper",
    "parts",
    "sprung",
    "without_rate",
]
