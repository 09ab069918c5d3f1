"""Checks of values that users give; each raises an InputError for a value that cannot be used."""

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

from .errors import InputError, shown

MOST = 10_000_000  # largest count; more would take days, or all memory
HIGHEST_SEED = 2**63 - 1


def number(name: str, value: Any, unit: str = "") -> float:
    """Returns `value` as a float; refuses values that are no finite numbers."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{name} is {shown(value)}: give a number{_in(unit)}")
    try:
        converted = float(value)
    except OverflowError:
        converted = math.inf
    if not math.isfinite(converted):
        raise InputError(f"{name} is {converted}: give a finite number{_in(unit)}")
    return converted


def numbers(name: str, values: Any, unit: str) -> tuple[float, ...]:
    """Returns `values` as floats; refuses an empty series and values not finite."""
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.empty(0, dtype=object)
    if array.ndim != 1 or array.dtype.kind not in "iuf" or array.size == 0:
        raise InputError(f"{name} is {shown(values)}: give at least one number{_in(unit)}")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise InputError(f"{name}[{bad[0]}] is {array[bad[0]]}: give finite numbers{_in(unit)}")
    return tuple(array.astype(np.float64).tolist())


def at_least(name: str, value: int, least: int, most: int = MOST) -> None:
    """Checks that a value is a whole number from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InputError(f"{name} is {shown(value)}: use a whole number of at least {least}")
    if value < least:
        raise InputError(f"{name} is {shown(value)}: use at least {least}")
    if value > most:
        raise InputError(f"{name} is {shown(value)}: use at most {most:,}")


def check_seed(value: Any) -> int:
    """Returns a seed of random numbers as an int; raises an InputError for any other value."""
    at_least("seed", value, 0, HIGHEST_SEED)
    return int(value)


def once(what: str, names: Iterable[object]) -> None:
    """Checks that no name is given twice."""
    given = [str(name) for name in names]
    if len(set(given)) < len(given):
        raise InputError(f"the {what} are {', '.join(given)}: name each one once")


def workers(value: int) -> None:
    """Checks a number of workers: at least 1, or -1 for all cores."""
    if isinstance(value, bool) or not isinstance(value, Integral) or (value < 1 and value != -1):
        raise InputError(f"workers is {shown(value)}: use 1 or more, or -1 for all cores")


def within(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Checks that a value is a number from `low` to `high`."""
    if isinstance(value, bool) or not (isinstance(value, Real) and low <= value <= high):
        raise InputError(f"{name} is {shown(value)}: use a number from {low:g} to {high:g}{unit}")


def pair(name: str, given: Any, low: float, high: float, unit: str = "") -> tuple[float, float]:
    """Returns a least and a greatest number, both from `low` to `high`."""
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise InputError(f"{name} is {shown(given)}: give two numbers, the least and the greatest")
    for value in given:
        within(name, value, low, high, unit)
    if given[0] > given[1]:
        raise InputError(f"{name} is {shown(given)}: give the smaller number first")
    return float(given[0]), float(given[1])


def flag(name: str, value: bool) -> None:
    """Checks that a value is True or False; the text "no", for example, would count as true."""
    if not isinstance(value, bool):
        raise InputError(f"{name} is {shown(value)}: use True or False")


def scales(**values: float) -> None:
    """Checks that scale factors are finite and above 0."""
    for name, value in values.items():
        if not number(f"{name} scale", value) > 0:
            raise InputError(f"{name} scale is {value}: give a finite number above 0")


def _in(unit: str) -> str:
    return f" ({unit})" if unit else ""
