"""Code of the user, which is named by its place, and whose mistakes become sentences."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError, shown

Rewarding = Callable[[Mapping[str, Array], Mapping[str, NDArray]], Array]


def imported(what: str, place: str, kind: str) -> Any:
    """Returns the object at "package.module:name", which should be of a kind, such as a class."""
    module, _, name = place.partition(":")
    try:
        return getattr(import_module(module), name)
    except Exception as error:  # the user's code fails in any way that code can
        raise InputError(
            f"the {what} {place!r} cannot be imported ({type(error).__name__}: {error}): name a "
            f"module that is installed or in the working folder, and a {kind} in it"
        ) from error


def called(what: str, function: Callable[..., Any], *given: Any, **options: Any) -> Any:
    """Returns the result of a user's function; `what` begins the sentence of an error."""
    try:
        return function(*given, **options)
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # the user's code fails in any way that code can
        raise InputError(f"{what} ({type(error).__name__}: {error}): repair it") from error


class OwnReward:
    """A reward of the user, whose mistakes become sentences that name the reward.

    The reward is a function, or its place as "package.module:function". It is called once per
    control period for n rows at once, as `function(terms, measured)`: `terms` has the terms of the
    shipped reward, `effort`, `tracking` and `smoothness`, shape (n,). `measured` has the content of
    `info` by the same names, shape (n, size), and `lost`, shape (n,), which is true in the control
    period in which the arm is lost. The function returns the reward, shape (n,).
    """

    def __init__(self, given: str | Rewarding) -> None:
        self.name = given if isinstance(given, str) else getattr(given, "__name__", repr(given))
        self._function = imported("reward", given, "function") if isinstance(given, str) else given
        if not callable(self._function):
            raise InputError(
                f"the reward is {shown(given)}: give a function, or package.module:function"
            )

    def __call__(self, terms: Mapping[str, Array], measured: Mapping[str, NDArray]) -> Array:
        """Returns the reward of n rows, shape (n,)."""
        rows = measured["lost"].shape
        what = f"the reward {self.name!r} fails"
        found = called(what, lambda: np.asarray(self._function(terms, measured), float))
        if found.shape != rows:
            raise InputError(
                f"the reward {self.name!r} has the shape {found.shape}: return {rows}, one number "
                "for each row"
            )
        if not np.isfinite(found).all():
            row = int(np.flatnonzero(~np.isfinite(found))[0])
            raise InputError(
                f"the reward {self.name!r} is {found[row]} in row {row} of {rows[0]}: return "
                "finite numbers"
            )
        return found
