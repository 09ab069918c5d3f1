"""Residual policies: a network corrects another policy, action = policy + scale x network.

Source: Johannink et al. 2019, ICRA; Silver, Allen, Tenenbaum and Kaelbling 2018, arXiv:1812.06298.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from .base import Policy

SCALE, LEAST_SCALE, MOST_SCALE = 0.3, 0.01, 2.0  # greatest correction over the peak torque


def corrected(given: Array, correction: NDArray[np.floating[Any]], scale: float) -> Array:
    """Returns the corrected actions, shape (..., motors), from those of policy and network."""
    return np.clip(given + scale * np.clip(correction, -1.0, 1.0), -1.0, 1.0)


class ResidualPolicy:
    """A policy plus `scale` times the action of a correction.

    The correction observes the observation followed by the action of `policy`.
    """

    def __init__(self, policy: Policy, correction: Policy, scale: float) -> None:
        self._policy, self._correction, self._scale = policy, correction, scale

    def reset(self) -> None:
        """Clears the memory of both."""
        self._policy.reset()
        self._correction.reset()

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the corrected action."""
        given = self._policy.act(observation)
        seen = np.concatenate([observation, given], axis=-1, dtype=np.float32)
        return corrected(given, self._correction.act(seen), self._scale)


class Cohorts:
    """A policy in rows whose episodes begin at different times.

    A policy needs rows that begin together: these are a cohort with its own policy. When a row
    begins a new episode, it joins a new cohort; the policy of the old cohort still computes an
    action for the row, without effect, until all rows have left the cohort.
    """

    def __init__(self, make: Callable[[], Policy], rows: int, motors: int) -> None:
        self._make, self._motors = make, motors
        self._idle: list[Policy] = []
        self._running: dict[int, tuple[Policy, NDArray[np.int64]]] = {}
        self._cohort = np.full(rows, -1)  # number of the cohort of each row

    def begin(self, rows: NDArray[np.int64], observation: NDArray[np.float32]) -> Array:
        """Begins new episodes in rows, shape (k,); returns their first actions, (k, motors).

        The observations are those of all rows, shape (n, size).
        """
        new = max(self._running, default=-1) + 1
        self._cohort[rows] = new
        for i in [*self._running]:
            if not (self._cohort == i).any():
                self._idle.append(self._running.pop(i)[0])
        policy = self._idle.pop() if self._idle else self._make()
        policy.reset()
        self._running[new] = (policy, rows.copy())
        return policy.act(observation[rows])

    def act(self, observation: NDArray[np.float32]) -> Array:
        """Returns the actions of all rows, shape (n, motors)."""
        action = np.empty((len(observation), self._motors))
        for i, (policy, rows) in self._running.items():
            given = policy.act(observation[rows])
            present = self._cohort[rows] == i
            action[rows[present]] = given[present]
        return action

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_make": None, "_idle": []}

    def restore(self, other: "Cohorts") -> None:
        """Continues from the state of another object, such as an unpickled copy."""
        self._running, self._cohort = other._running, other._cohort
