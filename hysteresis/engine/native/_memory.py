"""Raw memory and C calls for numba code: what a MuJoCo callback needs and Python cannot express.

C functions are bound by name, not by address, so that compiled callbacks can be cached on disk.
"""

# pyright: reportCallIssue=false, reportPrivateImportUsage=false

import ctypes
import sys
from functools import cache
from pathlib import Path

import llvmlite.binding
import mujoco
import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from ....kernels import inner

LIBRARY_NAMES = {"win32": "mujoco.dll", "darwin": "libmujoco*.dylib"}


@cache
def mujoco_library() -> ctypes.CDLL:
    """Returns the MuJoCo C library that the Python bindings have loaded.

    Raises:
        RuntimeError: The wheel holds no such library.
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


_c_library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
_bind("activesuit_name2id", mujoco_library().mj_name2id)
_bind("activesuit_plugin_at", mujoco_library().mjp_getPluginAtSlot)
_bind("activesuit_warning", mujoco_library().mju_warning)
_bind("activesuit_strtod", _c_library.strtod)
_bind("activesuit_localeconv", _c_library.localeconv)

name2id = types.ExternalFunction(
    "activesuit_name2id", types.int32(types.intp, types.int32, types.intp)
)
plugin_at = types.ExternalFunction("activesuit_plugin_at", types.intp(types.int32))
strtod = types.ExternalFunction("activesuit_strtod", types.float64(types.intp, types.intp))
localeconv = types.ExternalFunction("activesuit_localeconv", types.intp())


@intrinsic
def _pointer(typing_context, address):
    def codegen(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), codegen


@njit(inline="always")
def doubles(address, count):
    """Returns a view of `count` doubles at `address`."""
    return carray(_pointer(address), (count,), dtype=np.float64)


@inner(cache=False)
def int32_at(address, index):
    """Returns element `index` of the int array at `address`."""
    return carray(_pointer(address), (index + 1,), dtype=np.int32)[index]


@inner(cache=False)
def pointer_at(address):
    """Returns the pointer (or 64-bit count) stored at `address`."""
    return carray(_pointer(address), (1,), dtype=np.intp)[0]


@inner(cache=False)
def character_at(address):
    """Returns the byte at `address`."""
    return carray(_pointer(address), (1,), dtype=np.uint8)[0]


@inner(cache=False)
def store_pointer(address, value):
    """Stores a pointer-sized integer at `address`."""
    carray(_pointer(address), (1,), dtype=np.intp)[0] = value


@intrinsic
def warn(typing_context, text):
    """Issues the C string at the address `text` as a MuJoCo warning."""

    def codegen(context, builder, signature, arguments):
        literal = context.insert_const_string(builder.module, "%s")
        function = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t], var_arg=True),
            "activesuit_warning",
        )
        builder.call(function, [literal, builder.inttoptr(arguments[0], cgutils.voidptr_t)])
        return context.get_dummy_value()

    return types.none(types.intp), codegen
