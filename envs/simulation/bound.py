"""Kernels bound to the arrays that they always work on."""

from collections.abc import Callable, Sequence
from typing import Any

from numba import typeof, types


def bound(kernel: Any, first: Sequence[Any], rest: Sequence[Any]) -> Callable[..., Any]:
    """Returns a function that calls a kernel with all arguments but the first ones given.

    A kernel of numba looks at the type of every argument before each call, which takes as long as
    its work on one arm where there are fifty. Here the types are looked at once.

    Args:
        kernel: Kernel of numba.
        first: Examples of the arguments that differ from call to call; the real ones have to be of
            the same types, and arrays in the same order of memory.
        rest: The other arguments. Arrays are not copied: the kernel sees what is written in them.
    """
    code, rest = kernel.compile(tuple(map(_type, (*first, *rest)))), tuple(rest)
    return lambda *given: code(*given, *rest)


def _type(value: Any) -> types.Type:
    """Returns the type of an argument, the same for one arm as for many.

    A row of MuJoCo's state is a part of a longer one. NumPy calls an array of one such row
    contiguous and an array of many not, for which all kernels would be compiled a second time.
    """
    found = typeof(value)
    if isinstance(found, types.Array) and found.ndim and value.size:
        if value.strides[0] != value[0].nbytes:
            return found.copy(layout="A")
    return found
