"""Policies that cancel what models say: of weight, of the suit, and of the motors' friction.

Each is a sum of terms, and all terms are at the angle plus 0.02 s of the rate, both measured, where
the joint will be when the motors have answered; friction is at the measured rate.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import SuitJoint
from ...errors import InputError
from ..belief import LEAD, BelievedSuit, BelievedWeight, count_of
from ..model import ASSISTED, ArmConfig, Exo, bare_arm, compose
from ..provenance import Quantity
from .base import Arms

_TURNING = Quantity(
    "friction.turning_rate",
    0.1,
    "rad/s",
    "ours: a few counts of an encoder in a control period, so that noise does not chatter",
    "assumed",
)
_SHARE = Quantity(
    "friction.share",
    0.8,
    "1",
    "ours: all of it makes the arm drift, and relieves no more than 0.8 of it",
    "assumed",
)
PROVENANCE: tuple[Quantity, ...] = (_TURNING, _SHARE)

Weight = Callable[[Array], Array]


class ModelBased:
    """Commands the sum of believed torques, divided by the motors' peaks.

    Args:
        env: Environment in which the policy acts, single or vector.
        weight: Function from angles [rad], shape (n, 4), to the torque that carries what shall be
            carried [N·m], shape (n, 2); None carries nothing.
        suit: Joints of the suit whose torque is cancelled; one that is missing is not.
        friction: Whether most of the motors' friction is cancelled, 0.8 of it.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(
        self,
        env: Arms,
        *,
        weight: Weight | None = None,
        suit: Mapping[str, SuitJoint] | None = None,
        friction: bool = False,
    ) -> None:
        episodes = env.episodes
        exo, layout = episodes.simulation.config.exo, episodes.observer.layout
        self._weight = weight
        self._suit = BelievedSuit(suit, count_of(exo.encoder_bits)) if suit else None
        self._angle, self._rate = layout["angle"], layout["rate"]
        addresses = episodes.simulation.addresses
        self._assisted, self._peak = addresses.assisted, addresses.peak_torque
        motors = list(exo.motors.values()) if friction else []
        self._coulomb = np.array([motor.coulomb for motor in motors])
        self._viscous = np.array([motor.viscous for motor in motors])
        self.reset()

    def reset(self) -> None:
        """Resets the memory to the state in which the suit's memory begins."""
        self._memory: NDArray[np.float64] | None = None

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the sum of the torques over the peaks, clipped to [-1, 1]."""
        angle = observation[..., self._angle].reshape(-1, 4).astype(np.float64)
        rate = observation[..., self._rate].reshape(-1, 4).astype(np.float64)
        torque = np.zeros((len(angle), len(ASSISTED)))
        if self._weight is not None:
            torque += self._weight(angle + LEAD * rate)
        if self._suit is not None:
            torque += self._suit_torque(angle[:, self._assisted], rate[:, self._assisted])
        if self._coulomb.size:
            turning = rate[:, self._assisted]
            against = self._coulomb * np.tanh(turning / _TURNING.value) + self._viscous * turning
            torque += _SHARE.value * against
        share = np.clip(torque / self._peak, -1, 1)
        return share.reshape(*observation.shape[:-1], len(ASSISTED))

    def _suit_torque(self, angle: Array, rate: Array) -> Array:
        assert self._suit is not None
        if self._memory is None:
            self._memory = self._suit.begin(angle)
        elif len(self._memory) != len(angle):
            raise InputError(
                f"the policy sees {len(angle)} arms, and {len(self._memory)} since its reset: "
                "reset it, or make one for each environment"
            )
        return self._suit.follow(self._memory, angle, rate)


def whole_weight(env: Arms) -> Weight:
    """Returns the weight of arm, suit, exoskeleton and load, as the options of `env` have them."""
    return BelievedWeight(env.episodes.simulation.model)


def exo_weight(env: Arms) -> Weight:
    """Returns the weight of the exoskeleton alone."""
    config = env.episodes.simulation.config
    without = BelievedWeight(compose(without_exo(config), drawn=False))
    whole = whole_weight(env)
    return lambda angle: whole(angle) - without(angle)


def carried_weight(env: Arms) -> Weight:
    """Returns the weight of all that the bare arm carries: suit, exoskeleton and load."""
    whole, bare = whole_weight(env), BelievedWeight(bare_arm(env.episodes.simulation.config))
    return lambda angle: whole(angle) - bare(angle)


def without_exo(config: ArmConfig) -> ArmConfig:
    """Returns the configuration of the same wearer, suit and load without an exoskeleton."""
    return replace(config, coupling="none", exo=Exo(), misalignment=(0.0, 0.0, 0.0))
