"""A toolkit for MuJoCo engine plugins that are written in Python and compiled by numba.

A plugin is a set of callbacks that MuJoCo calls from C, without Python's lock and from any thread:
it adds passive forces and measures them with sensors. No C compiler is needed. docs/robot.md builds
one, a joint with Stribeck friction, in forty lines. The steps are

1. a named tuple class of the fields that the callbacks touch, filled by `layout`;
2. a function that defines the callbacks with the decorator `callback`; they get addresses as
   integers, and reach numbers with `pointer_at`, `int32_at` and `doubles`, the config with `config`
   and `parse_numbers`, their own state with `state_of`;
3. `register_plugin`, once per process, before a model that uses the plugin is compiled or loaded.

The functions that a callback calls must be compiled too (`numba.njit`), and none may raise.
`complain` says in a sentence what is wrong, and `init` then returns -1: MuJoCo refuses the model.

Every function below takes the addresses of mjModel (`m`) or mjData (`d`), the number of the
instance, and `at`, the `layout` of the plugin with the fields that the function names; `text` is
the address of a C string. The pointer-sized word of an instance holds several numbers of `bits`
bits each, which count from 1; 0 is none.

C functions are bound by name, not by address, so that compiled callbacks can be cached on disk. A
function with `cache=False` is compiled into the plugin's own code: a cached function would contain
the layout classes of all plugins, and would be unreadable without the module of each plugin.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false

import _thread
import ctypes
import math
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco
import numpy as np
from llvmlite import ir
from numba import carray, cfunc, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from ...kernels import inner
from ._layout import ATTRIBUTES, PASSIVE, SENSOR, Plugin, layout  # noqa: F401  (for plugins)

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


_c_library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
for _symbol, _function in {
    "name2id": mujoco_library().mj_name2id,
    "plugin_at": mujoco_library().mjp_getPluginAtSlot,
    "warning": mujoco_library().mju_warning,
    "strtod": _c_library.strtod,
    "localeconv": _c_library.localeconv,
}.items():
    _address = ctypes.cast(_function, ctypes.c_void_p).value  # type: ignore[arg-type]
    llvmlite.binding.add_symbol(f"activesuit_{_symbol}", _address)

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


BLANKS = (ord(" "), ord("\t"), ord("\n"), ord("\r"))
SENTENCE_LIMIT = 600
LARGEST, SMALLEST = 1e100, 1e-100  # sizes of numbers, whose squares and products stay finite


@inner
def length(text):
    """Returns the length of the C string at `text`."""
    count = 0
    while character_at(text + count) != 0:
        count += 1
    return count


@inner
def starts_with(text, beginning):
    """Returns whether the C string at `text` starts with the bytes `beginning`."""
    for i in range(len(beginning)):
        if character_at(text + i) != beginning[i]:  # a shorter text ends in 0 and differs there
            return False
    return True


@inner
def behind_blanks(text):
    """Returns the address of the first character at or after `text` that is not a blank."""
    while character_at(text) in BLANKS:
        text += 1
    return text


@inner
def behind_digits(text):
    """Returns the address of the first character at or after `text` that is not a digit."""
    while ord("0") <= character_at(text) <= ord("9"):
        text += 1
    return text


@inner
def behind_number(text):
    """Returns the address behind the decimal number at `text`; `text` itself if there is none."""
    start = text + (character_at(text) in (ord("-"), ord("+")))
    end = behind_digits(start)
    digits = end - start
    if character_at(end) == ord("."):
        fraction = behind_digits(end + 1)
        digits += fraction - end - 1
        end = fraction
    if digits == 0:
        return text
    if character_at(end) in (ord("e"), ord("E")):
        power = end + 1 + (character_at(end + 1) in (ord("-"), ord("+")))
        behind = behind_digits(power)
        end = behind if behind > power else text
    return end


@inner
def to_number(text, end):
    """Returns the decimal number between two addresses, rounded as Python rounds it.

    C's strtod rounds so, but expects the decimal point of the process's locale.
    """
    point = pointer_at(localeconv())
    copy = np.zeros(end - text + length(point) + 1, np.uint8)
    n = 0
    for i in range(text, end):
        if character_at(i) == ord("."):
            for j in range(length(point)):
                copy[n] = character_at(point + j)
                n += 1
        else:
            copy[n] = character_at(i)
            n += 1
    value = strtod(copy.ctypes.data, 0)
    return value if copy[n] == 0 else math.nan  # this use keeps the copy alive during `strtod`


@inner
def parse_numbers(text, values):
    """Fills `values` with the blank-separated numbers of the C string at `text`.

    Returns how many numbers there are, even if they do not all fit; -1 if one is not finite,
    larger than 1e100, or smaller than 1e-100 and not 0.
    """
    count = 0
    text = behind_blanks(text)
    while character_at(text) != 0:
        end = behind_number(text)
        if end == text or not (character_at(end) == 0 or character_at(end) in BLANKS):
            return -1
        value = to_number(text, end)
        size = abs(value)
        if not size <= LARGEST or 0 < size < SMALLEST:
            return -1
        if count < values.size:
            values[count] = value
        count += 1
        text = behind_blanks(end)
    return count


@inner
def count_words(text):
    """Returns how many blank-separated words the C string at `text` has."""
    count = 0
    text = behind_blanks(text)
    while character_at(text) != 0:
        while character_at(text) != 0 and character_at(text) not in BLANKS:
            text += 1
        count += 1
        text = behind_blanks(text)
    return count


@inner
def add_text(sentence, n, text):
    """Appends the C string at `text` to a sentence of n characters; returns the new n."""
    i = 0
    while character_at(text + i) != 0 and n < SENTENCE_LIMIT - 1:
        sentence[n] = character_at(text + i)
        n, i = n + 1, i + 1
    return n


@inner
def add(sentence, n, words):
    """Appends the bytes `words` to a sentence of n characters; returns the new n."""
    for i in range(len(words)):
        if n < SENTENCE_LIMIT - 1:
            sentence[n] = words[i]
            n += 1
    return n


@inner
def issue(sentence):
    """Issues a sentence as a MuJoCo warning."""
    warn(sentence.ctypes.data)
    return sentence[0]  # this use keeps the sentence alive during `warn`


@inner
def choice_of(text, words):
    """Returns the index of the C string `text` among `words`, as b"rad deg"; -1 for none."""
    number, start = 0, 0
    for end in range(len(words) + 1):
        if end == len(words) or words[end] == ord(" "):
            if is_word(text, words, start, end):
                return number
            number, start = number + 1, end + 1
    return -1


@inner
def is_word(text, words, start, end):
    """Returns whether the C string at `text` is the bytes from `start` to `end`."""
    for i in range(start, end):
        if character_at(text + i - start) != words[i]:  # a shorter text ends in 0 and differs there
            return False
    return character_at(text + end - start) == 0


@inner
def add_choices(sentence, n, words):
    """Appends words, which blanks separate in `words`, as "a, b or c"; returns the new n."""
    last = len(words) - 1
    while last >= 0 and words[last] != ord(" "):
        last -= 1
    for i in range(len(words)):
        if words[i] != ord(" "):
            if n < SENTENCE_LIMIT - 1:
                sentence[n] = words[i]
                n += 1
        elif i == last:
            n = add(sentence, n, b" or ")
        else:
            n = add(sentence, n, b", ")
    return n


FOUND, UNKNOWN, TWICE = range(3)


@inner(cache=False)
def config(m, instance, key, at):
    """Returns the address of the value of config key number `key`, a C string ("" if not given).

    It reads m_plugin_attr and m_plugin_attradr.
    """
    text = pointer_at(m + at.m_plugin_attr) + int32_at(
        pointer_at(m + at.m_plugin_attradr), instance
    )
    for _ in range(key):
        while character_at(text) != 0:
            text += 1
        text += 1
    return text


@inner(cache=False)
def plugin_name(m, instance, at):
    """Returns the address of the name of an instance's plugin; it reads m_plugin."""
    return pointer_at(plugin_at(int32_at(pointer_at(m + at.m_plugin), instance)))


@inner(cache=False)
def key_name(m, instance, key, at):
    """Returns the address of the name of a config key; it reads m_plugin."""
    plugin = plugin_at(int32_at(pointer_at(m + at.m_plugin), instance))
    return pointer_at(pointer_at(plugin + ATTRIBUTES) + 8 * key)


@njit(inline="always")
def state_of(m, d, instance, at):
    """Returns the address of an instance's numbers in `mjData.plugin_state`.

    It reads m_plugin_stateadr and d_plugin_state.
    """
    address = int32_at(pointer_at(m + at.m_plugin_stateadr), instance)
    return pointer_at(d + at.d_plugin_state) + 8 * address


@njit(inline="always")
def state_size(m, instance, at):
    """Returns how many numbers of `plugin_state` an instance has; it reads m_plugin_statenum."""
    return int32_at(pointer_at(m + at.m_plugin_statenum), instance)


@inner(cache=False)
def word_of(d, instance, at):
    """Returns the integer that an instance keeps in `plugin_data`; it reads d_plugin_data."""
    return pointer_at(pointer_at(d + at.d_plugin_data) + 8 * instance)


@inner(cache=False)
def set_word(d, instance, word, at):
    """Stores the integer of `word_of`, which no reset and no saved state changes."""
    store_pointer(pointer_at(d + at.d_plugin_data) + 8 * instance, word)


@inner(cache=False)
def is_sensor_of(m, sensor, instance, at):
    """Returns whether a sensor belongs to an instance.

    It reads m_sensor_plugin, m_sensor_type and mjSENS_PLUGIN.
    """
    ours = int32_at(pointer_at(m + at.m_sensor_plugin), sensor) == instance
    return ours and int32_at(pointer_at(m + at.m_sensor_type), sensor) == at.mjSENS_PLUGIN


@inner(cache=False)
def sensor_name(m, sensor, at):
    """Returns the address of a sensor's name; it reads m_names and m_name_sensoradr."""
    return pointer_at(m + at.m_names) + int32_at(pointer_at(m + at.m_name_sensoradr), sensor)


@njit(inline="always")
def sensor_values(m, d, sensor, count, at):
    """Returns a view of the `count` values of a sensor; it reads m_sensor_adr and d_sensordata."""
    address = int32_at(pointer_at(m + at.m_sensor_adr), sensor)
    return doubles(pointer_at(d + at.d_sensordata) + 8 * address, count)


@inner(cache=False)
def begin_complaint(m, instance, noun, subject, key, at):
    """Begins a sentence about a config: "PLUGIN of NOUN 'SUBJECT': KEY is 'VALUE': ".

    `noun` is the thing that the instance acts on, as b"joint", and `subject` the number of the
    config key with the name of this thing. `key` is the number of the wrong key; the part about the
    key is left out where `key` is `subject`. Returns the sentence, to which `add` and `add_text`
    append, and the length of the sentence.
    """
    sentence = np.zeros(SENTENCE_LIMIT, np.uint8)
    n = add_text(sentence, 0, plugin_name(m, instance, at))
    n = add(sentence, n, b" of ")
    n = add(sentence, n, noun)
    n = add(sentence, n, b" '")
    n = add_text(sentence, n, config(m, instance, subject, at))
    n = add(sentence, n, b"': ")
    if key != subject:
        n = add_text(sentence, n, key_name(m, instance, key, at))
        n = add(sentence, n, b" is '")
        n = add_text(sentence, n, config(m, instance, key, at))
        n = add(sentence, n, b"': ")
    return sentence, n


@inner(cache=False)
def complain(m, instance, noun, subject, key, reason, at):
    """Issues a MuJoCo warning: a sentence about a config that ends with `reason`."""
    sentence, n = begin_complaint(m, instance, noun, subject, key, at)
    add(sentence, n, reason)
    issue(sentence)


@inner
def packed(ids, place, bits):
    """Returns the number at a place of the word `ids`, from 0; -1 for none."""
    return ((ids >> (bits * place)) & (2**bits - 1)) - 1


@inner
def sensor_kind(name, endings):
    """Returns the index of the end of `name` among `endings`, as b"force torque"; -1 for none."""
    for start in range(length(name)):
        kind = choice_of(name + start, endings)
        if kind >= 0:
            return kind
    return -1


@inner
def pack_sensors(m, instance, ids, first, bits, endings, at):
    """Returns (FOUND, UNKNOWN or TWICE, the word `ids` with the sensors of an instance added).

    UNKNOWN is a sensor whose name has none of the endings, and TWICE a second sensor of one ending.
    The sensor with the first ending gets the place `first`. The function reads m_nsensor and the
    fields of `sensor_name` and `is_sensor_of`.
    """
    for sensor in range(pointer_at(m + at.m_nsensor)):
        if is_sensor_of(m, sensor, instance, at):
            kind = sensor_kind(sensor_name(m, sensor, at), endings)
            if kind < 0:
                return UNKNOWN, ids
            if packed(ids, first + kind, bits) >= 0:
                return TWICE, ids
            ids |= (sensor + 1) << (bits * (first + kind))
    return FOUND, ids


STAGE_POS, STAGE_VEL = 1, 2  # mjSTAGE_POS, mjSTAGE_VEL

# The arguments of each callback, from mujoco/mjplugin.h; pointers are integers here.
_POINTER, _INT = types.intp, types.int32
SIGNATURES = {
    "nstate": _INT(_POINTER, _INT),
    "nsensordata": _INT(_POINTER, _INT, _INT),
    "init": _INT(_POINTER, _POINTER, _INT),
    "destroy": types.void(_POINTER, _INT),
    "copy": types.void(_POINTER, _POINTER, _POINTER, _INT),
    "reset": types.void(_POINTER, _POINTER, _POINTER, _INT),
    "compute": types.void(_POINTER, _POINTER, _INT, _INT),
    "advance": types.void(_POINTER, _POINTER, _INT),
}
# MuJoCo calls one of these callbacks first: `nstate` or `nsensordata` when a model is compiled, and
# `init` when an mjData is made.
FIRST = {
    "nstate": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_int),
    "nsensordata": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_int, ctypes.c_int),
    "init": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_ssize_t, ctypes.c_int),
}

_lock = threading.RLock()
_plugins: dict[
    str, "_Registered"
] = {}  # C has pointers into these objects as long as the process lives


def callback(function: Callable[..., Any]) -> Any:
    """Compiles the callback of the function's name, a key of `SIGNATURES` (a decorator).

    The machine code is cached on disk, separately for each set of values that the function takes
    from the function around it. A function that has no file, as in a notebook, is not cached.
    """
    signature = SIGNATURES[function.__name__]
    try:
        return cfunc(signature, cache=True)(function)
    except RuntimeError:  # numba found no place for a cache
        return cfunc(signature)(function)


def register_plugin(
    name: str,
    keys: Sequence[str],
    build: Callable[[], Iterable[Any]],
    stage: int = STAGE_POS,
    *,
    sensors: bool = False,
) -> int:
    """Registers a plugin of passive forces with MuJoCo, once per process.

    Args:
        name: Unique name of the plugin, which MJCF refers to.
        keys: Names of the config keys, in the order in which `config` counts keys.
        build: Function that compiles and returns the callbacks; it is called when the plugin is
            first needed.
        stage: Stage whose results the sensors need, as `STAGE_VEL` for velocities.
        sensors: Whether the plugin has sensors too. MuJoCo then calls `nsensordata`, and `compute`
            with mjPLUGIN_SENSOR as well as with mjPLUGIN_PASSIVE.

    Returns:
        The slot of the plugin, its number in `mjModel.plugin`.
    """
    with _lock:
        if name not in _plugins:
            _plugins[name] = _Registered(name, keys, build, stage, sensors)
        return _plugins[name].slot


def compile_plugin(name: str) -> None:
    """Compiles a registered plugin, unless that is done; the first time takes seconds.

    Without this call MuJoCo's first call compiles the plugin, and no exception can pass through.
    """
    _plugins[name].compile()


class _Registered:
    """A registered plugin, whose callbacks are put in place when they are compiled.

    Attributes:
        slot: Number of the plugin in `mjModel.plugin`.
    """

    def __init__(
        self,
        name: str,
        keys: Sequence[str],
        build: Callable[[], Iterable[Any]],
        stage: int,
        sensors: bool,
    ) -> None:
        self._name, self._build = name, build
        self._callbacks: dict[str, Any] = {}
        self._keys = (ctypes.c_char_p * len(keys))(*(key.encode() for key in keys))
        self._first = {which: kind(self._beginning(which)) for which, kind in FIRST.items()}
        library = mujoco_library()
        plugin = Plugin()
        library.mjp_defaultPlugin(ctypes.byref(plugin))
        plugin.name = name.encode()
        plugin.nattribute = len(keys)
        plugin.attributes = self._keys
        plugin.capabilityflags = PASSIVE | SENSOR if sensors else PASSIVE
        plugin.needstage = stage
        for which, function in self._first.items():
            setattr(plugin, which, ctypes.cast(function, ctypes.c_void_p).value)
        self.slot: int = library.mjp_registerPlugin(ctypes.byref(plugin))
        library.mjp_getPluginAtSlot.restype = ctypes.POINTER(Plugin)
        self._entry = library.mjp_getPluginAtSlot(self.slot).contents  # MuJoCo's own copy

    def compile(self) -> dict[str, Any]:
        """Replaces the first callbacks by the compiled ones, and returns these by name."""
        with _lock:
            if not self._callbacks:
                self._callbacks = {one.__name__: one for one in self._build()}
                for which, compiled in self._callbacks.items():
                    setattr(self._entry, which, compiled.address)
            return self._callbacks

    def _beginning(self, which: str) -> Callable[..., int]:
        """Returns a callback for MuJoCo's first call, which compiles the plugin and goes on."""

        def begin(*arguments: int) -> int:
            try:
                return self.compile()[which].ctypes(*arguments)
            except KeyboardInterrupt:
                _thread.interrupt_main()
            except BaseException:  # none may pass through MuJoCo, which gets a failure instead
                traceback.print_exc()
            return -1

        return begin
