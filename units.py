"""Units in which rigs write angles, torques and times, and their factors to rad, N·m and s."""

import math
import re
from typing import NamedTuple

from .errors import InputError, shown

POUND, KILOGRAM = 4.4482216152605, 9.80665  # forces [N], exact
INCH, FOOT = 0.0254, 0.3048  # [m], exact

# By quantity and unit: the factor to the first unit of the quantity, and other spellings. Case,
# blanks, brackets and signs of products do not matter.
UNITS: dict[str, dict[str, tuple[float, str]]] = {
    "angle": {
        "rad": (1.0, "radian radians"),
        "mrad": (1e-3, ""),
        "deg": (math.pi / 180, "degree degrees ° grad"),  # Grad is German; the gradian is gon
        "gon": (math.pi / 200, ""),
        "rev": (2 * math.pi, "turn turns"),
    },
    "torque": {
        "N·m": (1.0, ""),
        "N·mm": (1e-3, "mNm"),
        "N·cm": (1e-2, ""),
        "kN·m": (1e3, ""),
        "lbf·in": (POUND * INCH, "lbin inlbf inlb inlbs"),
        "lbf·ft": (POUND * FOOT, "lbft ftlbf ftlb ftlbs"),
        "ozf·in": (POUND / 16 * INCH, "ozin inoz inozf"),
        "kgf·cm": (KILOGRAM / 100, "kgcm"),
        "kgf·m": (KILOGRAM, "kgm"),
    },
    "time": {
        "s": (1.0, "sec second seconds sek"),
        "ms": (1e-3, "msec millisecond milliseconds millis"),
        "us": (1e-6, "µs microseconds micros"),
        "ns": (1e-9, ""),
        "min": (60.0, ""),
    },
}
SCALED = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)?\s*([^\d/]+?)\s*(?:/\s*[^/]+)?")


class Unit(NamedTuple):
    """A unit, with the factor that converts numbers to rad, N·m or s."""

    name: str
    factor: float


def _plain(text: str) -> str:
    return re.sub(r"[\s·⋅*.×_\-\[\]()<>]", "", text.casefold().replace("μ", "µ"))


_KNOWN = {
    quantity: {
        _plain(spelling): Unit(name, factor)
        for name, (factor, others) in units.items()
        for spelling in (name, *others.split())
    }
    for quantity, units in UNITS.items()
}


def is_unit(text: str, quantity: str | None = None) -> bool:
    """Returns whether a text is a unit of a quantity; None stands for any quantity."""
    known = _KNOWN.values() if quantity is None else [_KNOWN[quantity]]
    return any(_plain(text) in units for units in known)


def unit_of(text: str, quantity: str) -> Unit:
    """Returns a unit of a quantity, which may be scaled, as "0.5 Nm/V" for a sensor in volts.

    Args:
        text: The unit. A factor may stand before the unit, and behind a slash the unit of the
            column.
        quantity: "angle", "torque" or "time".
    """
    match = SCALED.fullmatch(text.strip())
    number, name = match.groups() if match else (None, text)
    unit = _KNOWN[quantity].get(_plain(name))
    if unit is None or (number and float(number) == 0):
        other = [one for one in UNITS if one != quantity and is_unit(name, one)]
        what = f"a unit of {other[0]}, not of {quantity}" if other else f"no unit of {quantity}"
        units = [*UNITS[quantity]]
        raise InputError(
            f"{shown(text)} is {what}: use {', '.join(units)}, or a scale such as "
            f"'0.5 {units[0]}/V'"
        )
    return Unit(text.strip(), unit.factor * float(number)) if number else unit
