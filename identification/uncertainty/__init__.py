"""Uncertainty of the parameters and the torque of an identified model."""

from .uncertainty import Uncertainty, uncertainty

__all__ = ["Uncertainty", "uncertainty"]
