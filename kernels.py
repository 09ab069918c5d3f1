"""Kernels that only other kernels call, and kernels as functions of whole arrays."""

import inspect
from functools import cache
from typing import Any

from numba import njit, vectorize


def inner(function: Any = None, **options: Any) -> Any:
    """Compiles a function that only kernels call, without the wrapper for calls from Python.

    The wrapper takes as long to compile as a small kernel, and longer for structs of many arrays.
    Pass whole numbers to such a function as variables, or as `numpy.int64(0)`: numba compiles the
    function anew for each Python number in a call. `options` are those of `numba.njit`.
    """
    options = {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **options}
    return njit(**options) if function is None else njit(**options)(function)


@cache
def ufunc_of(kernel: Any) -> Any:
    """Returns the NumPy function that calls a kernel of floats for every element of its arguments.

    The function is compiled at its first use, since each compilation takes 40 ms, too long for an
    import. The result is a ufunc of NumPy, because a call of numba's object takes longer than the
    computation.
    """
    arguments = ", ".join("f8" for _ in inspect.signature(kernel.py_func).parameters)
    return vectorize(f"f8({arguments})", cache=True)(kernel.py_func).ufunc
