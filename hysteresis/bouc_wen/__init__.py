"""The Bouc-Wen model: the class, its kernels, and the curve that they follow (`_flow`)."""

from .model import BoucWen

__all__ = ["BoucWen"]
