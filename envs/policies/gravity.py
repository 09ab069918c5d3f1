"""Gravity compensation: the motors carry the weight of arm, suit, exoskeleton and load."""

from ..belief import Belief
from ..plant import Plant
from .model_based import ModelBased


class GravityCompensation(ModelBased):
    """Carries the weight of arm, suit, exoskeleton and load.

    Law: the static torque of the believed masses at the measured angles. Tuning: none. With cuffs
    it uses the exoskeleton's angles for the arm's; they differ because cuffs yield.
    Source: weight support of arm exoskeletons, such as Bardi et al. 2024 (arXiv 2406.18412).

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
    """

    def __init__(self, plant: Plant, belief: Belief | None = None) -> None:
        super().__init__(plant, weight=plant.believed(belief).whole_weight())
