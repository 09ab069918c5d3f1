"""The protocol of a policy, and the base class of policies that compute torques."""

from collections.abc import Mapping
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError
from ..plant import Plant

Seen = Mapping[str, Array]
"""Parts of the observations of n arms by name, shape (n, size) each."""


class Policy(Protocol):
    """A controller of the motors, for one arm or for rows of arms at once.

    `reset()` is called after the environment's reset, then `act(observation)` once per control
    period. A policy knows nothing else of the simulation. Its memory, if any, lasts from `reset` to
    `reset`, and belongs to as many arms as the first observation had.

    A policy that is made by name is called with the plant and its options as keywords:
    `Class(plant, gain=0.5)`; the policy knows the plant and its observations, and nothing else. A
    class with the parameter `belief` gets a `Belief` of the options `suit`, `pressure`, `load` and
    `wearer`. A class attribute `sensors` names the sensor suites that the policy needs. A policy
    that learns over episodes has `practice`, the number of rollouts on other motions before the
    policy is scored. Else a rollout carries nothing into another one: see docs/controllers.md.
    """

    def reset(self) -> None:
        """Clears the memory of the last episode."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the next action, in [-1, 1] for each assisted joint.

        Args:
            observation: Observation of one arm, shape (size,), or of rows, shape (..., size).

        Returns:
            The action, shape (..., motors).
        """
        ...


class TorquePolicy:
    """Base class of policies that compute the torque of the motors [N·m].

    A subclass has `torque`, which gets the parts of the observations by name, as float64 and always
    in rows: one arm is n = 1. The base class cuts observations into these parts, divides the torque
    by the peaks, and clips the quotient to [-1, 1]. A subclass with a memory makes the memory in
    `begin`, which is called with the first observations after each reset, so that the memory has as
    many rows as there are arms.

    The parts of each sensor suite, with units, are listed in docs/environments.md: `angle` [rad]
    and `rate` [rad/s] of the four joints, shape (n, 4), and `motor_torque` over the peak, shape
    (n, 2), are in all of them.

    Common arguments of subclasses: `plant` is the knowledge of a policy about the arms, `belief`
    its assumptions about person, suit and load, `lead` the lag of the motors [s], 0 to 0.2,
    `friction` the share of the motors' friction that is cancelled, 0 to 1, and `delay` the delay of
    the measured torque between person and suit [s], 0 to 0.5.

    Attributes:
        sensors: Names of the sensor suites that the class needs.
        assisted: Indices of the assisted joints, shoulder and elbow, among the four.
        peak: Peak torque of the motors [N·m], shape (2,).
        dt: Control period [s].
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, plant: Plant) -> None:
        self.assisted, self.peak, self.dt = plant.assisted, plant.peak, plant.dt
        self._layout = dict(plant.layout)
        self._rows = 0

    def reset(self) -> None:
        """Clears the memory of the last episode."""
        self._rows = 0

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the torques over the peaks, clipped to [-1, 1]; see `Policy.act`."""
        rows = observation.reshape(-1, observation.shape[-1])
        seen = {name: rows[:, part].astype(np.float64) for name, part in self._layout.items()}
        if not self._rows:
            self._rows = len(rows)
            self.begin(seen)
        elif len(rows) != self._rows:
            raise InputError(
                f"the policy sees {len(rows)} arms, and {self._rows} since its reset: reset it, or "
                "make one for each environment"
            )
        share = np.clip(self.torque(seen) / self.peak, -1, 1)
        return share.reshape(*observation.shape[:-1], len(self.peak))

    def begin(self, seen: Seen) -> None:
        """Makes a new memory; `seen` has the parts of the first observations of an episode."""

    def torque(self, seen: Seen) -> Array:
        """Returns the torque of the motors [N·m], shape (n, 2), also beyond the peaks.

        The base class calls `torque` once per control period with the parts of the observations by
        name, shape (n, size) each; `torque` updates the memory.
        """
        raise NotImplementedError
