"""The Prandtl-Ishlinskii model: the class and its kernels."""

from .model import PrandtlIshlinskii

__all__ = ["PrandtlIshlinskii"]
