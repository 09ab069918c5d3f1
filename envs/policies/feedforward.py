"""Hysteresis feed-forward: the motors cancel the suit torque that an identified model predicts."""

from ..belief import LEAD, Belief
from ..plant import Plant
from .model_based import ModelBased


class HysteresisFeedforward(ModelBased):
    """Cancels the suit torque that a believed model predicts, with a memory of its own.

    Law: the resistance of the model at the measured angle plus `lead` times the measured rate; see
    `BelievedSuit`. Tuning: the lead is the motors' lag and half a control period.
    Source: inverse compensation of hysteresis, Hassani et al. 2014 (survey).

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of the suit; a joint that it lacks gets no assist.
        lead: Time by which the motors answer late [s], 0 to 0.2.
    """

    def __init__(self, plant: Plant, belief: Belief | None = None, *, lead: float = LEAD) -> None:
        super().__init__(plant, suit=plant.believed(belief).suit(), lead=lead)
