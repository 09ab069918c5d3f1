"""Policies of a user's own code, which fails in any way that code can."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, shown
from ..interface.own_code import called
from .base import Policy


class OwnPolicy:
    """A policy of a user's own, whose mistakes become sentences that name it.

    Args:
        name: Name of the policy.
        motors: Number of motors.
        make: The user's class or function.
        *given: Arguments of the class or function.
        **options: Options of the class or function.

    Attributes:
        policy: The policy that the user's code makes.
        practice: Number of rollouts in which it learns before it is scored.
    """

    def __init__(
        self, name: str, motors: int, make: Callable[..., Policy], *given: Any, **options: Any
    ) -> None:
        self._name, self._motors = name, motors
        self.policy = called(f"policy {name!r} cannot be made", make, *given, **options)
        for method in ("reset", "act"):
            if not callable(getattr(self.policy, method, None)):
                raise InputError(
                    f"policy {name!r} makes {shown(self.policy)}, which has no {method}(): give a "
                    "function that returns an object with reset() and act(observation)"
                )
        self.practice = getattr(self.policy, "practice", 0)

    def reset(self) -> None:
        """Clears the memory of the policy."""
        called(f"policy {self._name!r} fails in reset()", self.policy.reset)

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the action of the policy."""
        what = f"policy {self._name!r} fails in act()"
        found = called(what, lambda: np.asarray(self.policy.act(observation), np.float64))
        wanted = (*observation.shape[:-1], self._motors)
        bad = found[~np.isfinite(found)]
        if found.shape != wanted or bad.size:
            shape = f"an action of shape {found.shape}"
            raise InputError(
                f"policy {self._name!r} returns {shape if found.shape != wanted else bad[0].item()}"
                f": return finite numbers from -1 to 1 of shape {wanted}"
            )
        return found
