"""Kernels that only other kernels call."""

from typing import Any

from numba import njit


def inner(function: Any = None, **options: Any) -> Any:
    """Compiles a function that only kernels call, without the wrapper for calls from Python.

    The wrapper takes as long to compile as a small kernel, and longer for structs of many arrays.
    Pass whole numbers to such a function as variables, or as `numpy.int64(0)`: numba compiles the
    function anew for each Python number in a call. `options` are those of `numba.njit`.
    """
    options = {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **options}
    return njit(**options) if function is None else njit(**options)(function)
