"""The Preisach model: the class, its kernels, and the sums that they read (`_tables`)."""

from .model import Preisach

__all__ = ["Preisach"]
