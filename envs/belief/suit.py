"""A controller's model of the suit: the torque that it resists with, from a memory of its own."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from ...arrays import Array
from ...assets import SuitJoint
from ...hysteresis import Viscoelastic
from ..model import ASSISTED
from ..provenance import numbers_of, values_of

PROVENANCE = numbers_of("belief")
LEAD = values_of(PROVENANCE)["belief.lead"]  # [s], time by which the motors answer late
DEAD_BAND = 1.5  # [encoder counts], greatest change that counts as no motion


class JointBelief(Protocol):
    """A model of one joint of a suit: a resistance that depends on the past motion."""

    @property
    def memory_size(self) -> int:
        """Number of values in its memory, of which the first is the last angle [rad]."""
        ...

    def begin(self) -> Array:
        """Returns the initial memory of the suit, shape (memory_size,)."""
        ...

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Advances memories, in place; see `HysteresisModel.advance`."""
        ...


def belief_of(joint: "SuitJoint | JointBelief") -> "JointBelief":
    """Returns a belief from a joint of a suit file; a belief is returned unchanged."""
    return _OfSuit(joint) if isinstance(joint, SuitJoint) else joint


class _OfSuit:
    """The joint of a suit file, as a belief."""

    def __init__(self, joint: SuitJoint) -> None:
        self._joint, self.advance = joint, joint.model.advance
        self.memory_size = joint.model.memory_size

    def begin(self) -> Array:
        return self._joint.begun().memory


class BelievedSuit:
    """Predicts the suit's torque at the assisted joints, shoulder and elbow, for rows of arms.

    `plant.believed(belief).suit()` makes one for a policy: of the suit, file or pressure of the
    belief, with the encoders' resolution and the control period. The memory of n arms is an array
    of the caller, which `begin` makes at a reset and `follow` moves on once per control period; so
    it can be saved, copied and branched.

    The memory follows measured angles; a change of one encoder count is no motion. The torque is
    that at the angle where the joint will be when the motors have answered: the measured angle plus
    0.02 s of the measured rate. It does not need the wearer's intention. The dashpot of a
    viscoelastic model resists the measured rate; its Maxwell element follows the measured angle.

    Args:
        joints: Joints of the suit, or other beliefs about them, which need not be of the simulated
            one; a joint that is missing gives no torque.
        count: Angle of one encoder count [rad].
        dt: Time from one angle to the next [s].

    Attributes:
        size: Number of values in the memory of an arm.
        joints: Assisted joints that resist, by name.
        dead_band: Greatest change of an angle that counts as no motion [rad].
        dt: Time from one angle to the next [s].
    """

    def __init__(
        self, joints: Mapping[str, SuitJoint | JointBelief], count: float, dt: float
    ) -> None:
        self.dead_band, self.dt = DEAD_BAND * count, dt
        self.joints = {name: joints[name] for name in ASSISTED if name in joints}
        self._entries: dict[int, JointBelief] = {}
        self._viscoelastic: dict[int, Viscoelastic] = {}
        for i, name in enumerate(ASSISTED):
            if name in joints:
                joint = joints[name]
                self._entries[i] = belief_of(joint)
                if isinstance(joint, SuitJoint) and isinstance(joint.model, Viscoelastic):
                    self._viscoelastic[i] = joint.model
        self._places: dict[int, slice] = {}
        end = len(ASSISTED)
        for i, entry in self._entries.items():
            begin, end = end, end + entry.memory_size
            self._places[i] = slice(begin, end)
        self._elements = {i: end + 2 * n for n, i in enumerate(self._viscoelastic)}
        self.size = end + 2 * len(self._elements)

    def begin(self, angle: Array) -> Array:
        """Returns memories in the suit's initial state, shape (n, size).

        Args:
            angle: Measured angles of the assisted joints [rad], shape (n, 2).
        """
        memory = np.zeros((len(angle), self.size))
        memory[:, : len(ASSISTED)] = angle
        for i, entry in self._entries.items():
            memory[:, self._places[i]] = entry.begin()
        for i, place in self._elements.items():
            memory[:, place] = angle[:, i]
        return memory

    def follow(self, memory: Array, angle: Array, rate: Array, lead: float = LEAD) -> Array:
        """Advances memories, in place; returns the resistance after `lead` [N·m], shape (n, 2).

        Motors that give this torque cancel the suit. It is positive against positive motion; the
        torque of the suit on the joint is minus this.

        Args:
            memory: Memories, shape (n, size).
            angle: Measured angles of the assisted joints [rad], shape (n, 2).
            rate: Measured rates [rad/s], the same shape.
            lead: Time until the motors have answered [s].
        """
        followed, soon = memory[:, : len(ASSISTED)], angle + lead * rate
        moved = np.abs(angle - followed) > self.dead_band
        followed[moved] = angle[moved]
        torque = np.zeros_like(soon)
        for i, entry in self._entries.items():
            kept = memory[:, self._places[i]]
            torque[:, i] = entry.advance(kept, followed[:, i], soon[:, i])
        for i, model in self._viscoelastic.items():
            element = memory[:, self._elements[i] : self._elements[i] + 2]
            torque[:, i] += model.damping * rate[:, i]
            if model.relaxation_stiffness > 0:
                moved = (angle[:, i] - element[:, 0]) / self.dt
                element[:, 0] = angle[:, i]
                element[:, 1] = _relaxed(model, element[:, 1], moved, self.dt)
                torque[:, i] += _relaxed(model, element[:, 1], rate[:, i], lead)
        return torque


def _relaxed(model: Viscoelastic, torque: Array, rate: Array, time: float) -> Array:
    """Returns the torque of the Maxwell element after some time at a constant rate [N·m]."""
    steady = model.relaxation_stiffness * model.relaxation_time * rate
    return steady + (torque - steady) * np.exp(-time / model.relaxation_time)
