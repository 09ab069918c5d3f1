"""Transparency: the exoskeleton carries itself and no more."""

from ..plant import Plant
from .model_based import SHARE, ModelBased


class Transparent(ModelBased):
    """Carries the exoskeleton itself, and cancels the friction of its motors.

    What it leaves is suit, load and the arm, as if the exoskeleton had been left at home, but for
    its inertia. Tuning: none.

    Args:
        plant: What the policy may know of the arms.
    """

    def __init__(self, plant: Plant) -> None:
        super().__init__(plant, weight=plant.believed().exo_weight(), friction=SHARE)
