"""The control cycle of one arm or a thousand: wearer, motors, physics and measurements."""

from .simulation import Simulation

__all__ = ["Simulation"]
