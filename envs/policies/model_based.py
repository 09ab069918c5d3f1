"""Policies that cancel what models say: of weight, of the suit, and of the motors' friction.

Each is a sum of terms, and all terms are at the angle plus the lead times the rate, both measured,
where the joint will be when the motors have answered; friction is at the measured rate. The
references stand here too: no assist, the true suit torque, and a plan that was made beforehand.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief, BelievedArm, BelievedSuit, BelievedWeight
from ..model import Exo
from ..plant import Plant
from ..provenance import numbers_of, values_of
from .base import Seen, TorquePolicy

PROVENANCE = numbers_of("friction")
_VALUE = values_of(PROVENANCE)
SHARE = _VALUE["friction.share"]
TURNING = _VALUE["friction.turning_rate"]  # rad/s
LONGEST_LEAD = 0.2  # s


@dataclass(frozen=True, eq=False)
class Friction:
    """The friction of the motors, as a function from rates [rad/s], (n, 2), to torques [N·m].

    Attributes:
        share: Share of the friction that is meant.
        coulomb: Coulomb friction of each motor [N·m], shape (2,).
        viscous: Viscous friction of each motor [N·m·s/rad], shape (2,).
    """

    share: float
    coulomb: Array
    viscous: Array

    def __call__(self, rate: Array) -> Array:
        """Returns the torque that overcomes it [N·m], shape (n, 2)."""
        return self.share * (self.coulomb * np.tanh(rate / TURNING) + self.viscous * rate)


class ModelBased(TorquePolicy):
    """Gives the sum of believed torques.

    Args:
        plant: What the policy may know of the arms.
        weight: Weight that is carried; None carries nothing.
        suit: Follower of the suit whose torque is cancelled; None cancels none.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
        lead: Time by which the motors answer late [s], 0 to 0.2.

    Attributes:
        config: Arm that the policy believes in, if `make_policy` has made it.
        weight: Weight that is carried, or None.
        suit: Follower of the suit, or None.
        friction: Friction that is cancelled.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        weight: BelievedWeight | None = None,
        suit: BelievedSuit | None = None,
        friction: float = 0.0,
        lead: float = LEAD,
    ) -> None:
        super().__init__(plant)
        within("lead", lead, 0, LONGEST_LEAD, " s")
        self.config = plant.config
        self.weight, self.suit, self.lead = weight, suit, lead
        within("friction", friction, 0, 1)
        self.friction = friction_of(plant.config.exo, friction)

    def begin(self, seen: Seen) -> None:
        """Begins the suit's memory in the state in which the true suit begins."""
        if self.suit is not None:
            self._memory = self.suit.begin(seen["angle"][:, self.assisted])

    def torque(self, seen: Seen) -> Array:
        """Returns the sum of the torques [N·m], shape (n, 2)."""
        angle, rate = seen["angle"], seen["rate"]
        torque = np.zeros((len(angle), len(self.peak)))
        if self.weight is not None:
            torque += self.weight(angle + self.lead * rate)
        if self.suit is not None:
            torque += self.suit_torque(seen)
        return torque + self.friction(rate[:, self.assisted])

    def suit_torque(self, seen: Seen) -> Array:
        """Moves the suit's memory on; returns its believed resistance soon [N·m], (n, 2)."""
        assert self.suit is not None
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        return self.suit.follow(self._memory, angle, rate, self.lead)


def friction_of(exo: Exo, share: float, *, viscous: bool = True) -> Friction:
    """Returns the friction of the motors.

    Args:
        exo: Exoskeleton whose motors they are.
        share: Share of the friction that is meant.
        viscous: Whether the viscous part is meant too, which the measured torque of a motor is
            without.
    """
    coulomb = np.array([motor.coulomb for motor in exo.motors.values()])
    by_rate = np.array([motor.viscous if viscous else 0.0 for motor in exo.motors.values()])
    return Friction(share, coulomb, by_rate)


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


class Transparent(ModelBased):
    """Carries the exoskeleton itself, and cancels the friction of its motors.

    What it leaves is suit, load and the arm, as if the exoskeleton had been left at home, but for
    its inertia. Tuning: none.

    Args:
        plant: What the policy may know of the arms.
    """

    def __init__(self, plant: Plant) -> None:
        super().__init__(plant, weight=plant.believed().exo_weight(), friction=SHARE)


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
    suit. Tuning and arguments: as of compensation.
    """

    @staticmethod
    def weight_of(arm: BelievedArm) -> BelievedWeight:
        """Returns the weight of all but the bare arm."""
        return arm.carried_weight()


class NoAssist(TorquePolicy):
    """Gives no torque: the wearer alone works against suit, weight and motor friction.

    Args:
        plant: What the policy may know of the arms.
    """

    def torque(self, seen: Seen) -> Array:
        """Returns zeros."""
        return np.zeros((len(seen["angle"]), len(self.peak)))


class Oracle(TorquePolicy):
    """Cancels the true suit torque of this moment; only the delay of the motors remains.

    Args:
        plant: What the policy may know of the arms.
    """

    sensors = ("encoders", "privileged")

    def torque(self, seen: Seen) -> Array:
        """Returns minus the suit torque [N·m], shape (n, 2)."""
        return -seen["suit_torque"][:, self.assisted]


class Planned:
    """Gives the commands of a plan, one after the other, whatever it observes.

    Args:
        commands: Torque of the motors over their peaks, shape (rows, periods, 2).
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, commands: Array) -> None:
        self.commands, self._period = commands, 0

    def reset(self) -> None:
        """Goes back to the first command."""
        self._period = 0

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the next command of each row; the last one stays."""
        command = self.commands[:, min(self._period, self.commands.shape[1] - 1)]
        self._period += 1
        return command.reshape(*observation.shape[:-1], -1)
