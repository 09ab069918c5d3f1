"""How sure the parameters of an identified Jiles-Atherton model are."""

from .uncertainty import Uncertainty, uncertainty

__all__ = ["Uncertainty", "uncertainty"]
