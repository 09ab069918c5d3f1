"""The Bouc-Wen model: the class, its kernels, and the solution of its equation (`_flow`)."""

from .model import BoucWen

__all__ = ["BoucWen"]
