"""Kernels bound to the arrays that they always work on."""

from collections.abc import Callable, Sequence
from typing import Any

from numba import typeof, types


def bound(kernel: Any, first: Sequence[Any], rest: Sequence[Any]) -> Callable[..., Any]:
    """Returns a function that calls a kernel with all arguments but the first ones given.

    Numba inspects the types of all arguments at each call of a kernel. For fifty arguments this
    takes as long as the kernel's work on one arm. Here the types are inspected once.

    Args:
        kernel: Kernel of numba.
        first: Examples of the arguments that differ from call to call; the real ones have to be of
            the same types, and arrays in the same order of memory.
        rest: The other arguments. Arrays are not copied: the kernel sees later changes.
    """
    code, rest = kernel.compile(tuple(map(_type, (*first, *rest)))), tuple(rest)
    return lambda *given: code(*given, *rest)


def _type(value: Any) -> types.Type:
    """Returns the type of an argument, the same for one arm as for many.

    The arrays are parts of MuJoCo's longer rows of state. NumPy calls such an array contiguous for
    one row and not contiguous for many, so that each kernel would be compiled for both layouts.
    """
    found = typeof(value)
    if isinstance(found, types.Array) and found.ndim and value.size:
        if value.strides[0] != value[0].nbytes:
            return found.copy(layout="A")
    return found
