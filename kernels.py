"""The decorator of kernels that only other kernels call."""

from typing import Any

from numba import njit


def inner(function: Any = None, **options: Any) -> Any:
    """Compiles a function that only kernels call, without a way into it from Python.

    This way takes as long to compile as a small kernel, and longer for structs of many arrays.

    Give whole numbers to such a function as variables, or as `numpy.int64(0)`: numba compiles it
    anew for each Python number that stands in a call, also for named ones.

    Args:
        function: The function.
        **options: Options of `numba.njit`; by default the code is cached.
    """
    options = {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **options}
    return njit(**options) if function is None else njit(**options)(function)
