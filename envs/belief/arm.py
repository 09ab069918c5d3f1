"""Beliefs of a controller about person, suit and load, which may differ from the simulation."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco

from ...assets import AnySuit, SuitJoint
from ...errors import InputError
from ..model import ASSISTED, ArmConfig, Exo, Payload, bare_arm, compose, resisting_joints
from ..model.config import HEAVIEST_PAYLOAD, NO_SUIT, nested
from ..model.encoders import count_of
from ..model.workplace import Edits
from ..person import Person
from ..provenance import check_settings, setting
from .rigid import BelievedInertia, BelievedWeight
from .suit import BelievedSuit


@dataclass(frozen=True, kw_only=True)
class Belief:
    """Differences of the believed arm from the options of the environment, as plain values.

    A belief never contains the random draws of an episode, nor the loads of a task.

    Attributes:
        suit: Suit, or its name or file; None is that of the options.
        pressure: Operating pressure of the suit [kPa]; None is that of the options, and of the suit
            file where `suit` is given.
        load: Mass of the load at the hand [kg]; None is that of the options.
        wearer: Person, or a dict of the fields that differ from the default person; None is that of
            the options.
    """

    suit: AnySuit | None = None
    pressure: float | None = None
    load: float | None = setting(None, "kg", 0, HEAVIEST_PAYLOAD)
    wearer: Person | Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        check_settings(self, "the believed ")

    def of(self, config: ArmConfig) -> ArmConfig:
        """Returns the configuration of the believed arm, from that of the simulated arms."""
        changes: dict[str, Any] = {}
        if self.suit is not None:
            changes |= {"suit": self.suit, "pressure": None}
        if self.pressure is not None:
            changes["pressure"] = self.pressure
        if self.load is not None:
            changes["payload"] = Payload(mass=self.load)
        if self.wearer is not None:
            changes["wearer"] = nested("wearer", self.wearer, Person())
        return replace(config, **changes)


class BelievedArm:
    """Models of a believed arm: the torque of its suit, its weight and its inertia.

    Args:
        config: Configuration of the simulated arm, whose exoskeleton is known.
        edits: What the task adds to the model.
        dt: Control period [s].
        belief: What differs from the configuration.

    Attributes:
        config: Configuration of the believed arm.
    """

    def __init__(
        self, config: ArmConfig, edits: Edits | None, dt: float, belief: Belief | None = None
    ) -> None:
        self.config = (belief or Belief()).of(config)
        self._given = belief is not None and belief.suit not in (None, NO_SUIT)
        self._edits, self._dt = edits, dt

    @property
    def joints(self) -> dict[str, SuitJoint]:
        """Joints that the believed suit resists."""
        return resisting_joints(self.config)

    def suit(self, gain: float = 1.0) -> BelievedSuit:
        """Returns a follower of `gain` times the suit's torque, with the encoders' resolution."""
        joints = self.joints
        if self._given and not any(joint in joints for joint in ASSISTED):
            raise InputError(
                f"the believed suit has the joints {', '.join(joints) or '(none)'}, and neither "
                f"{' nor '.join(ASSISTED)}, which have motors: believe in a suit that has one"
            )
        if gain != 1:
            joints = {name: entry.scaled(torque=gain) for name, entry in joints.items()}
        return BelievedSuit(joints, count_of(self.config.exo.encoder_bits), self._dt)

    def model(self) -> mujoco.MjModel:
        """Returns the model of the believed arm with suit, exoskeleton, load and tools."""
        return compose(self.config, drawn=False, edits=self._edits)

    def whole_weight(self) -> BelievedWeight:
        """Returns the weight of arm, suit, exoskeleton, load and tools."""
        return BelievedWeight(self.model())

    def exo_weight(self) -> BelievedWeight:
        """Returns the weight of the exoskeleton alone."""
        without = compose(without_exo(self.config), drawn=False, edits=self._edits)
        return self.whole_weight() - BelievedWeight(without)

    def carried_weight(self) -> BelievedWeight:
        """Returns the weight of all that the bare arm carries: suit, exoskeleton and load."""
        return self.whole_weight() - BelievedWeight(bare_arm(self.config))

    def inertia(self) -> BelievedInertia:
        """Returns the inertia of arm, suit, exoskeleton, load and tools."""
        return BelievedInertia(self.model())

    def exo_inertia(self) -> BelievedInertia:
        """Returns the inertia of the exoskeleton alone, with its motors."""
        without = compose(without_exo(self.config), drawn=False, edits=self._edits)
        return self.inertia() - BelievedInertia(without)

    def carried_inertia(self) -> BelievedInertia:
        """Returns the inertia of all that the bare arm carries: suit, exoskeleton and load."""
        return self.inertia() - BelievedInertia(bare_arm(self.config))


def without_exo(config: ArmConfig) -> ArmConfig:
    """Returns the configuration of the same wearer, suit and load without an exoskeleton."""
    return replace(config, coupling="none", exo=Exo(), misalignment=(0.0, 0.0, 0.0))
