"""Transparency: the exoskeleton carries itself and no more."""

from .base import Arms
from .model_based import ModelBased, exo_weight


class Transparent(ModelBased):
    """Cancels the exoskeleton's own weight and the friction of its motors.

    What it leaves is suit, load and the arm, as if the exoskeleton had been left at home, but for
    its inertia.

    Args:
        env: Environment in which the policy acts, single or vector.
    """

    def __init__(self, env: Arms) -> None:
        super().__init__(env, weight=exo_weight(env), friction=True)
