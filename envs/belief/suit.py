"""A controller's model of the suit: its resistance, from a memory of the controller."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Protocol

import numpy as np

from ...arrays import Array
from ...assets import SuitJoint
from ...hysteresis import Viscoelastic
from ..model import ASSISTED
from ..provenance import numbers_of, values_of

PROVENANCE = numbers_of("belief")
LEAD = values_of(PROVENANCE)["belief.lead"]  # [s], delay of the motors
DEAD_BAND = 1.5  # [encoder counts], greatest change that counts as no motion


class JointBelief(Protocol):
    """A model of one joint of a suit: a resistance that depends on the past motion."""

    @property
    def memory_size(self) -> int:
        """Number of values in the memory; the first value is the last angle [rad]."""
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

    `plant.believed(belief).suit()` makes the model for a policy, from the suit, file or pressure of
    the belief, the encoders' resolution and the control period. The memory of n arms is an array of
    the caller, which `begin` makes at a reset and `follow` advances once per control period, so
    that the memory can be saved, copied and branched.

    The memory follows measured angles; a change of one encoder count is no motion. The torque is
    that at the angle of the joint when the motors have answered: the measured angle plus 0.02 s of
    the measured rate. The wearer's intention is not needed. The dashpot of a viscoelastic model
    resists the measured rate; its Maxwell element follows the measured angle.

    Args:
        joints: Joints of a suit, which need not be the simulated suit, or other beliefs about
            joints; a missing joint gives no torque.
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
        self._entries = [
            (i, belief_of(joints[name])) for i, name in enumerate(ASSISTED) if name in joints
        ]
        found = [
            (i, joint.model)
            for i, joint in enumerate(map(joints.get, ASSISTED))
            if isinstance(joint, SuitJoint) and isinstance(joint.model, Viscoelastic)
        ]
        sizes = [len(ASSISTED), *(entry.memory_size for _, entry in self._entries)]
        ends = np.cumsum(sizes).tolist()
        self._places = [slice(*pair) for pair in pairwise(ends)]
        # Each Maxwell element has two values behind the memories of the models.
        self._elements = [(i, model, ends[-1] + 2 * n) for n, (i, model) in enumerate(found)]
        self.size = ends[-1] + 2 * len(found)

    def begin(self, angle: Array) -> Array:
        """Returns memories in the initial state of the suit, shape (n, size).

        `angle` are the measured angles of the assisted joints [rad], shape (n, 2).
        """
        memory = np.zeros((len(angle), self.size))
        memory[:, : len(ASSISTED)] = angle
        for (_, entry), place in zip(self._entries, self._places, strict=True):
            memory[:, place] = entry.begin()
        for i, _, place in self._elements:
            memory[:, place] = angle[:, i]
        return memory

    def follow(self, memory: Array, angle: Array, rate: Array, lead: float = LEAD) -> Array:
        """Advances memories, in place; returns the resistance after `lead` [N·m], shape (n, 2).

        Motors that give this torque cancel the suit. The resistance is positive against positive
        motion; the torque of the suit on the joint is minus the resistance. Memories have the shape
        (n, size), measured angles [rad] and rates [rad/s] of the assisted joints the shape (n, 2),
        and `lead` is the time until the motors have answered [s].
        """
        followed, soon = memory[:, : len(ASSISTED)], angle + lead * rate
        moved = np.abs(angle - followed) > self.dead_band
        followed[moved] = angle[moved]
        torque = np.zeros_like(soon)
        for (i, entry), place in zip(self._entries, self._places, strict=True):
            torque[:, i] = entry.advance(memory[:, place], followed[:, i], soon[:, i])
        for i, model, place in self._elements:
            element = memory[:, place : place + 2]
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
