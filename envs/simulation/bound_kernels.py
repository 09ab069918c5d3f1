"""Kernels bound to the structs of arrays that they always work on.

Numba takes each array of an argument apart at every call. For a control cycle with a hundred arrays
that takes longer than the cycle of one arm. So addresses, shapes and strides of the arrays are
written into a table once, and the compiled kernel reads the table.
"""

import math
import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numba import typeof, types
from numba.core import cgutils
from numba.extending import NativeValue, intrinsic, models, register_model, unbox

T = TypeVar("T")


class Frozen(Generic[T]):
    """A tuple of structs as a bound kernel gets it; `thawed` returns the tuple."""


def bound(kernel: Any, first: Sequence[Any], rest: tuple) -> Callable[..., Any]:
    """Returns a function that calls a kernel with all arguments but the first ones given.

    Args:
        kernel: Kernel of numba, the last parameter of which is `Frozen`.
        first: Examples of the arguments that differ from call to call; the real ones have to be of
            the same types, and arrays in the same order of memory.
        rest: The tuple that `thawed` returns in the kernel: structs, arrays and numbers. Arrays are
            not copied: the kernel sees later changes.
    """
    table = np.array(_words(rest), np.int64)
    code = kernel.compile((*map(_type, first), _Frozen(_type(rest))))

    def call(*given: Any, address: int = table.ctypes.data, kept: Any = (table, rest)) -> Any:
        return code(*given, address)

    return call


def _words(value: Any) -> list[int]:
    """Returns a value as the 64-bit words from which `_read` makes it."""
    if isinstance(value, tuple):
        return [word for part in value for word in _words(part)]
    if isinstance(value, np.ndarray):
        return [value.ctypes.data, value.size, *value.shape, *value.strides]
    if isinstance(value, float):
        return [struct.unpack("q", struct.pack("d", value))[0]]
    return [int(value)]


def _type(value: Any) -> Any:
    """Returns the type of an argument, the same for one arm as for many, and for empty arrays.

    The arrays are parts of MuJoCo's longer rows of state. NumPy calls such an array contiguous for
    one row or none of its columns and not contiguous otherwise, so that each kernel would be
    compiled for both layouts.
    """
    if isinstance(value, tuple):
        return types.BaseTuple.from_types(tuple(map(_type, value)), type(value))
    found = typeof(value)
    if isinstance(found, types.Array) and found.ndim:
        row = math.prod(max(size, 1) for size in value.shape[1:])
        if value.strides[0] not in (0, row * value.itemsize):  # an empty array of ours has 0
            return found.copy(layout="A")
    return found


class _Frozen(types.Type):
    """Numba's type of `Frozen`: the address of a table of words.

    Args:
        content: Type of the tuple that `thawed` returns.
    """

    def __init__(self, content: types.BaseTuple) -> None:
        self.content = content
        super().__init__(name=f"Frozen({content})")


@register_model(_Frozen)
class _FrozenModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: _Frozen) -> None:
        super().__init__(manager, kind, cgutils.voidptr_t)


@unbox(_Frozen)
def _unbox(kind: _Frozen, address: Any, c: Any) -> NativeValue:
    return NativeValue(c.pyapi.long_as_voidptr(address))


def _thawed(typing_context: Any, frozen: _Frozen) -> Any:
    """Returns the tuple to which a kernel is bound."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        table = builder.bitcast(given[0], cgutils.intp_t.as_pointer())
        return _read(context, builder, frozen.content, table, 0)[0]

    return frozen.content(frozen), generate


def _read(context: Any, builder: Any, kind: Any, table: Any, place: int) -> tuple[Any, int]:
    """Returns a value of the table, and the place of the next one."""

    def word(i: int) -> Any:
        return builder.load(cgutils.gep_inbounds(builder, table, place + i))

    if isinstance(kind, types.BaseTuple):
        members: Any = kind
        parts = []
        for part in members:
            value, place = _read(context, builder, part, table, place)
            parts.append(value)
        return context.make_tuple(builder, kind, parts), place
    if isinstance(kind, types.Array):
        array, n = context.make_array(kind)(context, builder), kind.ndim
        array.data = builder.inttoptr(word(0), array.data.type)
        size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        array.nitems, array.itemsize = word(1), context.get_constant(types.intp, size)
        array.shape = cgutils.pack_array(builder, [word(2 + i) for i in range(n)])
        array.strides = cgutils.pack_array(builder, [word(2 + n + i) for i in range(n)])
        array.meminfo = cgutils.get_null_value(array.meminfo.type)  # not counted: `bound` owns it
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue(), place + 2 + 2 * n
    wanted = context.get_value_type(kind)
    if isinstance(kind, types.Boolean):
        value = builder.trunc(word(0), wanted)
    else:
        value = builder.bitcast(word(0), wanted)
    return value, place + 1


if TYPE_CHECKING:

    def thawed(frozen: Frozen[T]) -> T:
        """Returns the tuple to which a kernel is bound."""
        ...

else:
    thawed = intrinsic(_thawed)
