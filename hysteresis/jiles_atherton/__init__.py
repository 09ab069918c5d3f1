"""The Jiles-Atherton model: the class, its kernels, and functions for fits.

`kernels` steps one model, a population of models, and a model with derivatives. `_bulk` has the
exact step behind these kernels, `_forms` the other equations of the literature, `margins` the
certificate, and `coordinates` the coordinates in which a search stays certified.
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
