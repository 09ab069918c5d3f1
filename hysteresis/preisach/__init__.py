"""The Preisach model: the class and its kernels."""

from .model import Preisach

__all__ = ["Preisach"]
