"""Kernels bound to the structs of arrays that they always work on.

    >>> from typing import NamedTuple
    >>> from numba import njit
    >>> class Arms(NamedTuple):
    ...     angle: np.ndarray
    ...     step: float
    >>> @njit
    ... def turn(row, arms):
    ...     arms.angle[row] += arms.step
    >>> arms = Arms(angle=np.zeros((3, 2)), step=0.5)
    >>> turn_one = bound(turn, (0,), arms)
    >>> turn_one(1)
    >>> arms.angle.tolist()
    [[0.0, 0.0], [0.5, 0.5], [0.0, 0.0]]

Numba takes each array of an argument apart at every call. For a control cycle with a hundred arrays
that takes longer than the cycle of one arm. So `bound` writes once where the arrays are, into a
table of 64-bit words, and the machine code gets the address of the table alone:

    table   word 0     1     2     3     4       5       6
            address    size  rows  cols  stride  stride  step
            of angle   6     3     2     16      8       0.5
               |
    memory     +----> 0.0  0.0  0.5  0.5  0.0  0.0     the array of NumPy itself

`arms.angle` in a kernel reads words 0 to 5, `arms.step` word 6, and a struct within a struct is an
address within the table. Numbers never change. Arrays change in place: write `arms.angle[:] = 0`.
The function that `bound` returns keeps table and arrays alive; it cannot be pickled.
"""

import math
import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numba import typeof, types
from numba.core import cgutils
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import NativeValue, infer_getattr, models, register_model, unbox


def bound(kernel: Any, first: Sequence[Any], rest: Any) -> Callable[..., Any]:
    """Returns a function that calls a kernel of numba with all arguments but the last one.

    `first` are examples of the arguments that differ from call to call: the real arguments have to
    be of the same types, and arrays in the same order of memory. `rest` is the last argument, a
    named tuple of arrays, numbers and named tuples.
    """
    table = np.array(_words(rest), np.int64)
    code = kernel.compile((*map(_type, first), _Frozen(_type(rest))))

    def call(*given: Any, address: int = table.ctypes.data, kept: Any = (table, rest)) -> Any:
        return code(*given, address)

    return call


def _words(value: Any) -> list[int]:
    """Returns a value as the 64-bit words from which `_member` makes it."""
    if isinstance(value, tuple):
        return [word for part in value for word in _words(part)]
    if isinstance(value, np.ndarray):
        return [value.ctypes.data, value.size, *value.shape, *value.strides]
    if isinstance(value, float):
        return [struct.unpack("q", struct.pack("d", value))[0]]
    return [int(value)]


def _count(kind: Any) -> int:
    """Returns the number of words of a value of a type."""
    if isinstance(kind, types.BaseTuple):
        members: Any = kind
        return sum(map(_count, members))
    return 2 + 2 * kind.ndim if isinstance(kind, types.Array) else 1


def _type(value: Any) -> Any:
    """Returns the type of an argument, the same for one arm, for many arms, and for empty arrays.

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
    """Numba's type of a named tuple in a table, which is the address of its first word."""

    def __init__(self, content: Any) -> None:
        self.content = content
        super().__init__(name=f"Frozen({content})")


@register_model(_Frozen)
class _FrozenModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: _Frozen) -> None:
        super().__init__(manager, kind, cgutils.voidptr_t)


@unbox(_Frozen)
def _unbox(kind: _Frozen, address: Any, c: Any) -> NativeValue:
    return NativeValue(c.pyapi.long_as_voidptr(address))


@infer_getattr
class _MemberType(AttributeTemplate):
    key = _Frozen

    def generic_resolve(self, kind: _Frozen, name: str) -> Any:
        if name not in kind.content.fields:
            return None
        member = kind.content[kind.content.fields.index(name)]
        return _Frozen(member) if isinstance(member, types.BaseTuple) else member


@lower_getattr_generic(_Frozen)
def _member(context: Any, builder: Any, kind: _Frozen, address: Any, name: str) -> Any:
    """Returns a member of a struct: an array, a number, or the address of a struct within."""
    members = list(kind.content)
    place = kind.content.fields.index(name)
    first, member = sum(map(_count, members[:place])), members[place]
    table = builder.bitcast(address, cgutils.intp_t.as_pointer())

    def word(i: int) -> Any:
        found = builder.load(cgutils.gep_inbounds(builder, table, first + i))
        found.set_metadata("invariant.load", builder.module.add_metadata([]))  # see the top
        return found

    if isinstance(member, types.BaseTuple):
        return builder.bitcast(cgutils.gep_inbounds(builder, table, first), cgutils.voidptr_t)
    if isinstance(member, types.Array):
        array, n = context.make_array(member)(context, builder), member.ndim
        array.data = builder.inttoptr(word(0), array.data.type)
        size = context.get_abi_sizeof(context.get_data_type(member.dtype))
        array.nitems, array.itemsize = word(1), context.get_constant(types.intp, size)
        array.shape = cgutils.pack_array(builder, [word(2 + i) for i in range(n)])
        array.strides = cgutils.pack_array(builder, [word(2 + n + i) for i in range(n)])
        array.meminfo = cgutils.get_null_value(array.meminfo.type)  # not counted: `bound` owns it
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    wanted = context.get_value_type(member)
    if isinstance(member, types.Boolean):
        return builder.trunc(word(0), wanted)
    return builder.bitcast(word(0), wanted)
