"""The Jiles-Atherton model: the class, its kernels, and what fits of it need.

`kernels` steps one model, a population of models, and one with its derivatives. `_bulk` has the
exact step behind all of them, `_forms` the other equations of the literature, `margins` the
certificate, and `coordinates` those in which a search stays certified.
"""

from .coordinates import Nearest, nearest_certified
from .model import PARAMETERS, TABLE_2, UNIT_PER_RADIAN, AngleUnit, JilesAtherton

__all__ = [
    "PARAMETERS",
    "TABLE_2",
    "UNIT_PER_RADIAN",
    "AngleUnit",
    "JilesAtherton",
    "Nearest",
    "nearest_certified",
]
