"""Compensation: weight, suit and friction together."""

from collections.abc import Mapping

from ...assets import SuitJoint
from .base import Arms
from .model_based import ModelBased, carried_weight, whole_weight


class Compensation(ModelBased):
    """Cancels the weight of all, the arm's own too, the suit's torque and the motors' friction.

    Args:
        env: Environment in which the policy acts, single or vector.
        suit: Joints of the suit that the controller believes in.
    """

    def __init__(self, env: Arms, suit: Mapping[str, SuitJoint]) -> None:
        super().__init__(env, weight=whole_weight(env), suit=suit, friction=True)


class Complement(ModelBased):
    """Cancels the same less the weight of the bare arm, which its wearer carries as without a suit.

    Args:
        env: Environment in which the policy acts, single or vector.
        suit: Joints of the suit that the controller believes in.
    """

    def __init__(self, env: Arms, suit: Mapping[str, SuitJoint]) -> None:
        super().__init__(env, weight=carried_weight(env), suit=suit, friction=True)
