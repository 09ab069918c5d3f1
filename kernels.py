"""The decorator of kernels that only other kernels call."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def inner(function: F) -> F:
    """Compiles a function that only kernels call: into its callers, and not for Python.

    The way from Python into a kernel with many arrays takes as long to compile as the kernel. Give
    whole numbers to such a function as variables, or as `numpy.int64(0)`: numba compiles it anew
    for each number that stands in a call.
    """
    options: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return njit(cache=True, forceinline=True, **options)(function)
