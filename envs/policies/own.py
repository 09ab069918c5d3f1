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
        policy: The policy.
        motors: Number of motors.

    Attributes:
        policy: The policy.
        practice: Number of rollouts in which it learns before it is scored.
    """

    def __init__(self, name: str, policy: Policy, motors: int) -> None:
        self.policy, self._name, self._motors = policy, name, motors
        self.practice = getattr(policy, "practice", 0)

    def reset(self) -> None:
        """Clears the memory of the policy."""
        called(f"policy {self._name!r} fails in reset()", self.policy.reset)

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the action of the policy."""
        what = f"policy {self._name!r} fails in act()"
        found = called(what, lambda: np.asarray(self.policy.act(observation), np.float64))
        wanted = (*observation.shape[:-1], self._motors)
        if found.shape != wanted:
            raise InputError(
                f"policy {self._name!r} returns an action of shape {found.shape}: return finite "
                f"numbers from -1 to 1 of shape {wanted}"
            )
        if not np.isfinite(found).all():
            raise InputError(
                f"policy {self._name!r} returns {shown(found[~np.isfinite(found)][0].item())}: "
                f"return finite numbers from -1 to 1 of shape {wanted}"
            )
        return found


def own_policy(
    name: str, make: Callable[..., Policy], motors: int, *given: Any, **options: Any
) -> OwnPolicy:
    """Returns what a user's code makes, if it can act.

    Args:
        name: Name of the policy.
        make: The user's class or function.
        motors: Number of motors.
        *given: Its arguments.
        **options: Its options.
    """
    policy = called(f"policy {name!r} cannot be made", make, *given, **options)
    for method in ("reset", "act"):
        if not callable(getattr(policy, method, None)):
            raise InputError(
                f"policy {name!r} makes {shown(policy)}, which has no {method}(): give a function "
                "that returns an object with reset() and act(observation)"
            )
    return OwnPolicy(name, policy, motors)
