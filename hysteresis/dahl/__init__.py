"""Dahl's friction and the semilinear Duhem model: the classes and their kernels."""

from .model import Dahl, Duhem

__all__ = ["Dahl", "Duhem"]
