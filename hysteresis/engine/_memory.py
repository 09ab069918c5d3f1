"""Raw memory and C calls for numba code: what a MuJoCo callback needs and Python cannot express.

C functions are bound by name, not by address, so that compiled callbacks can be cached on disk.
"""

# pyright: reportCallIssue=false, reportPrivateImportUsage=false

import ctypes
import math
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

LIBRARY_NAMES = {"win32": "mujoco.dll", "darwin": "libmujoco*.dylib"}


@cache
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


_bind("activesuit_name2id", mujoco_library().mj_name2id)
_bind("activesuit_warning", mujoco_library().mju_warning)

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


@njit(inline="always")
def store_pointer(address, value):
    """Stores a pointer-sized integer at `address`."""
    carray(_pointer(address), (1,), dtype=np.intp)[0] = value


@njit(cache=True)
def length(text):
    """Returns the length of the C string at `text`."""
    count = 0
    while character_at(text + count) != 0:
        count += 1
    return count


@njit(cache=True)
def ends_with(text, ending):
    """Returns whether the C string at `text` ends with the bytes `ending`."""
    start = length(text) - len(ending)
    if start < 0:
        return False
    for i in range(len(ending)):
        if character_at(text + start + i) != ending[i]:
            return False
    return True


@njit(cache=True)
def equals(text, word):
    """Returns whether the C string at `text` is the bytes `word`."""
    return length(text) == len(word) and ends_with(text, word)


@njit(cache=True)
def parse_number(text):
    """Parses the C string at `text`: (value, whether all of it is a finite decimal number).

    C's own strtod would read "0.5" as 0 in a process whose locale has a decimal comma.
    """
    sign = 1.0
    if character_at(text) == ord("-"):
        sign = -1.0
    if character_at(text) in (ord("-"), ord("+")):
        text += 1
    mantissa, exponent, digits, after_point = 0, 0, 0, False
    while ord("0") <= character_at(text) <= ord("9") or (
        character_at(text) == ord(".") and not after_point
    ):
        if character_at(text) == ord("."):
            after_point = True
        else:
            digits += 1
            if mantissa < 10**17:
                mantissa = 10 * mantissa + (character_at(text) - ord("0"))
                exponent -= after_point
            else:
                exponent += not after_point
        text += 1
    if digits > 0 and character_at(text) in (ord("e"), ord("E")):
        text += 1
        negative = character_at(text) == ord("-")
        if character_at(text) in (ord("-"), ord("+")):
            text += 1
        power, digits = 0, 0
        while ord("0") <= character_at(text) <= ord("9"):
            power = min(10 * power + (character_at(text) - ord("0")), 10_000)
            digits += 1
            text += 1
        exponent += -power if negative else power
    value = mantissa * 10.0**exponent if exponent >= 0 else mantissa / 10.0**-exponent
    return sign * value, digits > 0 and character_at(text) == 0 and math.isfinite(value)


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
