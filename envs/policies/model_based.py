"""Policies that cancel modelled torques: of weight, of the suit, and of the motors' friction.

Each is a sum of terms at the measured angle plus lead times measured rate, where the joint will be
when the motors have answered; friction is at the measured rate. Three references are here too: no
assist, the true suit torque, and a plan that was made beforehand.
"""

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief, BelievedArm, BelievedSuit, BelievedWeight
from ..model import Exo
from ..plant import Plant
from ..provenance import numbers_of, values_of
from ..simulation.state import PREVIEW
from .base import Seen, TorquePolicy

PROVENANCE = numbers_of("friction")
_VALUE = values_of(PROVENANCE)
SHARE = _VALUE["friction.share"]
TURNING = _VALUE["friction.turning_rate"]  # rad/s
LONGEST_LEAD = 0.2  # s
GAINS = (0.05, 20.0)  # least and greatest factor of a believed torque


class Friction:
    """A share of the motors' friction, as a function from rates [rad/s], (n, 2), to torques [N·m].

    The viscous part is optional, since the measured torque of a motor does not contain that part.
    """

    def __init__(self, exo: Exo, share: float, *, viscous: bool = True) -> None:
        motors = exo.motors.values()
        self.share, self.coulomb = share, np.array([motor.coulomb for motor in motors])
        self.viscous = np.array([motor.viscous if viscous else 0.0 for motor in motors])

    def __call__(self, rate: Array) -> Array:
        """Returns the torque that overcomes the friction [N·m], shape (n, 2)."""
        return self.share * (self.coulomb * np.tanh(rate / TURNING) + self.viscous * rate)


class ModelBased(TorquePolicy):
    """Gives the sum of believed torques.

    Args:
        plant: The knowledge of a policy about the arms; `make_policy` sets its `config` to the arm
            that the policy believes in.
        weight: Weight that the motors carry; None carries nothing.
        suit: Follower of the suit whose torque is cancelled; None cancels nothing.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
        lead: Time by which the motors answer late [s], 0 to 0.2.
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
        self.friction = Friction(plant.config.exo, friction)

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
        """Updates the suit's memory; returns the resistance after the lead [N·m], shape (n, 2)."""
        assert self.suit is not None
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        return self.suit.follow(self._memory, angle, rate, self.lead)


class HysteresisFeedforward(ModelBased):
    """Cancels the suit torque that a believed model with a memory predicts.

    Law: the resistance of the model at the measured angle plus `lead` times the measured rate; see
    `BelievedSuit`. A joint that the believed suit lacks gets no assist.
    Tuning: the lead is the motors' lag and half a control period.
    Source: inverse compensation of hysteresis, Hassani et al. 2014 (survey).
    """

    def __init__(self, plant: Plant, belief: Belief | None = None, *, lead: float = LEAD) -> None:
        super().__init__(plant, suit=plant.believed(belief).suit(), lead=lead)


class GravityCompensation(ModelBased):
    """Carries the weight of arm, suit, exoskeleton and load.

    Law: the static torque of the believed masses at the measured angles. Tuning: none. With cuffs,
    which yield, the exoskeleton's angles replace those of the arm.
    Source: weight support of arm exoskeletons, such as Bardi et al. 2024 (arXiv 2406.18412).
    """

    def __init__(self, plant: Plant, belief: Belief | None = None) -> None:
        super().__init__(plant, weight=plant.believed(belief).whole_weight())


class Transparent(ModelBased):
    """Carries the exoskeleton itself, and cancels the friction of its motors.

    The person carries suit, load and arm, as if the exoskeleton had been left at home, but for the
    inertia of the exoskeleton. Tuning: none.
    """

    def __init__(self, plant: Plant) -> None:
        super().__init__(plant, weight=plant.believed().exo_weight(), friction=SHARE)


class Compensation(ModelBased):
    """Carries the weight of arm, suit, exoskeleton and load, and cancels suit and friction.

    Law: gravity, feedforward and the motors' friction together. Tuning: as of its parts, and the
    gain by the least effort of wearers in suits that differ from the believed one.

    Args:
        gain: Factor of the believed suit's torque, 0.05 to 20.
    """

    weight_of = staticmethod(BelievedArm.whole_weight)

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        gain: float = 1.0,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        within("gain", gain, *GAINS)
        arm = plant.believed(belief)
        weight, suit = self.weight_of(arm), arm.suit(gain)
        super().__init__(plant, weight=weight, suit=suit, friction=friction, lead=lead)


class Complement(Compensation):
    """Compensates all but the weight of the bare arm, which the wearer carries as without a suit.

    Law: compensation less the believed weight of the arm. Tuning and arguments: as of compensation.
    """

    weight_of = staticmethod(BelievedArm.carried_weight)


class Impedance(Compensation):
    """Pulls the arm along the intention by springs and dampers, beside compensation.

    Law: compensation + K (q_d - q) + B (q_d' - q'), all at the angles after the lead.
    Tuning rule: K = M w² and B = 2 z M w with the believed inertia M of each joint, the bandwidth
    w and the damping ratio z; w is a fifth of the inverse of the loop's lag, 0.03 s.
    Signals needed: encoders and a preview of the intention. With a wrong preview the policy works
    against the wearer.
    Source: Hogan 1985, Impedance control, J. Dyn. Syst. Meas. Control 107, 1-24.

    Args:
        bandwidth: Natural frequency of the believed arm on the springs [Hz], 0 to 3.
        damping_ratio: Damping ratio, 0 to 3.
    """

    sensors = ("encoders", "preview")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        bandwidth: float = 1.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(plant, belief)
        within("bandwidth", bandwidth, 0, 3, " Hz")
        within("damping_ratio", damping_ratio, 0, 3)
        inertia, pole = plant.believed(belief).inertia().nominal(), math.tau * bandwidth
        self.stiffness, self.damping = inertia * pole**2, 2 * damping_ratio * inertia * pole

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the pull of springs and dampers [N·m], shape (n, 2)."""
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        target, target_rate = intended(seen["target"])
        pull = self.stiffness * (target - angle - self.lead * rate)
        return super().torque(seen) + pull + self.damping * (target_rate - rate)


def intended(target: Array) -> tuple[Array, Array]:
    """Returns angle [rad] and rate [rad/s] at the nearest previewed time, shape (n, 2) each.

    The rate is that of the parabola through the three previewed angles [rad], shape (n, 6), the
    nearest first.
    """
    now, next_, last = target[:, 0:2], target[:, 2:4], target[:, 4:6]
    near, far = PREVIEW[1] - PREVIEW[0], PREVIEW[2] - PREVIEW[0]
    first, second = (next_ - now) / near, (last - now) / far
    return now, (far * first - near * second) / (far - near)


class NoAssist(TorquePolicy):
    """Gives no torque: the wearer alone works against suit, weight and motor friction."""

    def torque(self, seen: Seen) -> Array:
        """Returns zeros."""
        return np.zeros((len(seen["angle"]), len(self.peak)))


class Oracle(TorquePolicy):
    """Cancels the true suit torque; only the error by the motors' lag remains."""

    sensors = ("encoders", "privileged")

    def torque(self, seen: Seen) -> Array:
        """Returns minus the suit torque [N·m], shape (n, 2)."""
        return -seen["suit_torque"][:, self.assisted]


class Planned:
    """Gives the commands of a plan one after another, and ignores observations.

    Commands are torques of the motors over their peaks, shape (rows, periods, 2).
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, commands: Array) -> None:
        self.commands, self._period = commands, 0

    def reset(self) -> None:
        """Returns to the first command."""
        self._period = 0

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the next command of each row; the last one stays."""
        command = self.commands[:, min(self._period, self.commands.shape[1] - 1)]
        self._period += 1
        return command.reshape(*observation.shape[:-1], -1)
