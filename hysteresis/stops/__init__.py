"""Springs with sliders in parallel: the Prandtl-Ishlinskii model, and hinged stops."""

from .model import HingedStops, PrandtlIshlinskii

__all__ = ["HingedStops", "PrandtlIshlinskii"]
