"""Raw memory and C calls for numba code: what a MuJoCo callback needs and Python cannot express.

C functions are bound by name, not by address, so that compiled callbacks can be cached on disk.
"""

# pyright: reportCallIssue=false, reportPrivateImportUsage=false

import ctypes
import sys
from pathlib import Path

import llvmlite.binding
import mujoco
import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

LIBRARY_NAMES = {"win32": "mujoco.dll", "darwin": "libmujoco*.dylib"}


def mujoco_library() -> ctypes.CDLL:
    """Returns the MuJoCo C library that the Python bindings have loaded.

    Raises:
        RuntimeError: the wheel holds no such library.
    """
    folder = Path(mujoco.__file__).parent
    pattern = LIBRARY_NAMES.get(sys.platform, "libmujoco.so*")
    for path in sorted(folder.glob(pattern)):
        return ctypes.CDLL(str(path))
    raise RuntimeError(
        f"no {pattern} beside the mujoco package in {str(folder)!r}: reinstall mujoco"
    )


def _bind(symbol: str, function: object) -> None:
    address = ctypes.cast(function, ctypes.c_void_p).value  # type: ignore[arg-type]
    llvmlite.binding.add_symbol(symbol, address)


_C = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)
_MUJOCO = mujoco_library()
_bind("activesuit_strtod", _C.strtod)
_bind("activesuit_name2id", _MUJOCO.mj_name2id)
_bind("activesuit_warning", _MUJOCO.mju_warning)

name2id = types.ExternalFunction(
    "activesuit_name2id", types.int32(types.intp, types.int32, types.intp)
)


@intrinsic
def _pointer(typing_context, address):
    def codegen(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), codegen


@njit(inline="always")
def doubles(address, count):
    """Returns a view of `count` doubles at `address`."""
    return carray(_pointer(address), (count,), dtype=np.float64)


@njit(inline="always")
def int32_at(address, index):
    """Returns element `index` of the int array at `address`."""
    return carray(_pointer(address), (index + 1,), dtype=np.int32)[index]


@njit(inline="always")
def pointer_at(address):
    """Returns the pointer (or 64-bit count) stored at `address`."""
    return carray(_pointer(address), (1,), dtype=np.intp)[0]


@njit(inline="always")
def character_at(address):
    """Returns the byte at `address`."""
    return carray(_pointer(address), (1,), dtype=np.uint8)[0]


@intrinsic
def parse_double(typing_context, text):
    """Parses the C string at address `text`; returns (value, whether all of it was a number)."""

    def codegen(context, builder, signature, arguments):
        integer = arguments[0].type
        end = cgutils.alloca_once(builder, integer)
        function = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(ir.DoubleType(), [integer, integer.as_pointer()]),
            "activesuit_strtod",
        )
        value = builder.call(function, [arguments[0], end])
        stop = builder.load(end)
        rest = builder.load(builder.inttoptr(stop, cgutils.voidptr_t))
        whole = builder.and_(
            builder.icmp_unsigned("!=", stop, arguments[0]),
            builder.icmp_unsigned("==", rest, rest.type(0)),
        )
        return context.make_tuple(builder, signature.return_type, [value, whole])

    return types.Tuple((types.float64, types.boolean))(types.intp), codegen


@intrinsic(prefer_literal=True)
def warn(typing_context, message, name):
    """Issues `message`, a literal with one %s, as a MuJoCo warning about the C string `name`."""

    def codegen(context, builder, signature, arguments):
        text = context.insert_const_string(builder.module, signature.args[0].literal_value)
        function = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t], var_arg=True),
            "activesuit_warning",
        )
        builder.call(function, [text, builder.inttoptr(arguments[1], cgutils.voidptr_t)])
        return context.get_dummy_value()

    if isinstance(message, types.StringLiteral):
        return types.none(message, types.intp), codegen
    return None
