"""Gravity compensation: the motors carry the weight of arm, suit, exoskeleton and load."""

from .base import Arms
from .model_based import ModelBased, whole_weight


class GravityCompensation(ModelBased):
    """Cancels the static gravity torque at the measured joint angles, computed from known masses.

    With cuffs it uses the exoskeleton's angles for the arm's; they differ because cuffs yield.

    Args:
        env: Environment in which the policy acts, single or vector.
    """

    def __init__(self, env: Arms) -> None:
        super().__init__(env, weight=whole_weight(env))
