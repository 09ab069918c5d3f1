"""Compensation: weight, suit and friction together."""

from ..belief import LEAD, Belief, BelievedArm, BelievedWeight
from ..plant import Plant
from .model_based import SHARE, ModelBased


class Compensation(ModelBased):
    """Carries the weight of all, the arm's too, and cancels suit and friction.

    Law: gravity, feedforward and the motors' friction together. Tuning: as of its parts.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        lead: Time by which the motors answer late [s], 0 to 0.2.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
    """

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        arm = plant.believed(belief)
        weight, suit = self.weight_of(arm), arm.suit()
        super().__init__(plant, weight=weight, suit=suit, friction=friction, lead=lead)

    @staticmethod
    def weight_of(arm: BelievedArm) -> BelievedWeight:
        """Returns the weight that is carried."""
        return arm.whole_weight()


class Complement(Compensation):
    """Does what compensation does, but leaves the wearer the weight of the bare arm.

    Law: compensation less the believed weight of the arm, which its wearer carries as without a
    suit. Tuning: as of compensation.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        lead: Time by which the motors answer late [s], 0 to 0.2.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
    """

    @staticmethod
    def weight_of(arm: BelievedArm) -> BelievedWeight:
        """Returns the weight of all but the bare arm."""
        return arm.carried_weight()
