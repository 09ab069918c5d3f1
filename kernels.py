"""Kernels that only other kernels call, and kernels as functions of whole arrays."""

import inspect
from functools import cache
from typing import Any

from numba import njit, vectorize


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


@cache
def ufunc_of(kernel: Any) -> Any:
    """Returns NumPy's function that calls a kernel of floats for every element of its arguments.

    The function is compiled at its first use, since an import would wait 40 ms for each. NumPy's
    own object is returned, because a call of numba's takes longer than the computation.

    Args:
        kernel: Kernel of numba that takes floats only and returns one.
    """
    arguments = ", ".join("f8" for _ in inspect.signature(kernel.py_func).parameters)
    return vectorize(f"f8({arguments})", cache=True)(kernel.py_func).ufunc
