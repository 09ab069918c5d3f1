"""The measuring rig: first-order curves, or any other motions, of one simulated suit joint."""

from .config import RigConfig
from .run import Record, run_rig

__all__ = ["Record", "RigConfig", "run_rig"]
