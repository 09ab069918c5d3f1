"""Transparency: the exoskeleton carries itself and no more."""

from .base import Arms, believed_arm
from .model_based import SHARE, ModelBased


class Transparent(ModelBased):
    """Carries the exoskeleton itself, and cancels the friction of its motors.

    What it leaves is suit, load and the arm, as if the exoskeleton had been left at home, but for
    its inertia. Tuning: none.

    Args:
        arms: Environment in which the policy acts, single or vector.
    """

    def __init__(self, arms: Arms) -> None:
        super().__init__(arms, weight=believed_arm(arms).exo_weight(), friction=SHARE)
