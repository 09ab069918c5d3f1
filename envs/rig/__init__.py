"""The measuring rig: first-order curves, or any other motions, of one simulated suit joint."""

from .rig import Record, RigConfig, run_rig

__all__ = ["Record", "RigConfig", "run_rig"]
