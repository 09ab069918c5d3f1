"""Hysteresis feed-forward: the motors cancel the suit torque that an identified model predicts."""

from collections.abc import Mapping

from ...assets import SuitJoint
from .base import Arms
from .model_based import ModelBased


class HysteresisFeedforward(ModelBased):
    """Cancels the suit torque that a model predicts, which keeps its own memory of the motion.

    See `BelievedSuit` for the law.

    Args:
        env: Environment in which the policy acts, single or vector.
        suit: Joints of the suit that the controller believes in, which need not be the simulated
            suit; a joint that is missing gets no assist.
    """

    def __init__(self, env: Arms, suit: Mapping[str, SuitJoint]) -> None:
        super().__init__(env, suit=suit)
