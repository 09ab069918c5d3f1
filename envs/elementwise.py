"""Scalar kernels as functions of arrays, element by element."""

import inspect
from functools import cache
from typing import Any

from numba import vectorize


@cache
def elementwise(kernel: Any) -> Any:
    """Returns NumPy's function that calls a kernel of floats for every element of its arguments.

    The function is compiled at its first use, since an import would wait 40 ms for each. NumPy's
    own object is returned, because a call of numba's takes longer than the computation.

    Args:
        kernel: Kernel of numba that takes floats only and returns one.
    """
    arguments = ", ".join("f8" for _ in inspect.signature(kernel.py_func).parameters)
    return vectorize(f"f8({arguments})", cache=True)(kernel.py_func).ufunc
