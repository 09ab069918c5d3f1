"""The Jiles-Atherton model: the class, its kernels, and what fits of it need.

`kernels` steps one model, a population of models, or one model with its derivatives; `_bulk` has
the exact step behind them, `_forms` the other equations of the literature, `_envelope` the
certificate for a range of angles.
"""

from .model import PARAMETERS, UNIT_PER_RADIAN, AngleUnit, JilesAtherton
from .nearest import Nearest, nearest_certified
from .table_2 import TABLE_2

__all__ = [
    "PARAMETERS",
    "TABLE_2",
    "UNIT_PER_RADIAN",
    "AngleUnit",
    "JilesAtherton",
    "Nearest",
    "nearest_certified",
]
