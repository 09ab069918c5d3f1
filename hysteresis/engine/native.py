"""A toolkit for MuJoCo engine plugins in Python, whose steps are compiled by numba.

A plugin adds passive forces to a simulation, and measures them with sensors. MuJoCo calls its
functions from C; no C compiler is needed. docs/robot.md builds one, a joint with Stribeck friction,
in forty lines. The steps are

1. a named tuple class of the fields that the compiled functions touch, filled by `layout`;
2. a function `build` that defines the functions of the plugin and returns them;
3. `register_plugin`, once per process, before a model that uses the plugin is compiled or loaded.

What runs once is plain Python, with the `Instance` in an mjModel as its argument:

    nstate(instance)                returns how many numbers of plugin_state the instance needs
    nsensordata(instance, sensor)   returns how many numbers a sensor measures (1 without it)
    init(instance)                  returns an integer, as ids of joints and sensors, that no reset
                                    and no saved state changes: the word of the instance
    reset(instance, state, word)    fills the array `state`, the numbers of the instance

An `InputError` of `init` becomes a warning of MuJoCo, which then refuses the model. What runs in
every step has the decorator `callback`. These functions are compiled, and run without Python's lock
and in any thread; the functions that they call must be compiled too, and none may raise:

    compute(m, d, instance, capability)   adds forces or writes sensors, and changes no state
    advance(m, d, instance)               moves the state to the end of a step

They take the addresses of mjModel (`m`) and mjData (`d`), the number of the instance, and `at`, the
`layout` of the plugin with the fields that the functions below name. A word holds several numbers
of `bits` bits each, which count from 1; 0 is none.

C functions are bound by name, not by address, so that compiled callbacks can be cached on disk. A
function with `cache=False` is compiled into the plugin's own code: a cached function would contain
the layout classes of all plugins, and would be unreadable without the module of each plugin.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false

import _thread
import ctypes
import re
import sys
import threading
import traceback
from collections import namedtuple
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco
import numpy as np
from llvmlite import ir
from numba import carray, cfunc, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from ...errors import InputError, shown
from ...kernels import inner
from ._layout import PASSIVE, SENSOR, Plugin, layout, struct

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


_name2id = mujoco_library().mj_name2id
_name2id.argtypes = [ctypes.c_ssize_t, ctypes.c_int, ctypes.c_char_p]
_warning = mujoco_library().mju_warning
_warning.argtypes = [ctypes.c_char_p]
llvmlite.binding.add_symbol(
    "activesuit_warning",
    ctypes.cast(_warning, ctypes.c_void_p).value,  # type: ignore[arg-type]
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


@inner(cache=False)
def int32_at(address, index):
    """Returns element `index` of the int array at `address`."""
    return carray(_pointer(address), (index + 1,), dtype=np.int32)[index]


@inner(cache=False)
def pointer_at(address):
    """Returns the pointer (or 64-bit count) stored at `address`."""
    return carray(_pointer(address), (1,), dtype=np.intp)[0]


@intrinsic(prefer_literal=True)
def warn(typing_context, sentence, text):
    """Issues a MuJoCo warning: a constant sentence, whose %s is the C string at `text`."""

    def codegen(context, builder, signature, arguments):
        literal = context.insert_const_string(builder.module, sentence.literal_value)
        function = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t], var_arg=True),
            "activesuit_warning",
        )
        builder.call(function, [literal, builder.inttoptr(arguments[1], cgutils.voidptr_t)])
        return context.get_dummy_value()

    return types.none(sentence, types.intp), codegen


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
    """Returns the word of an instance, which `init` has returned; it reads d_plugin_data."""
    return pointer_at(pointer_at(d + at.d_plugin_data) + 8 * instance)


@njit(inline="always")
def sensor_values(m, d, sensor, count, at):
    """Returns a view of the `count` values of a sensor; it reads m_sensor_adr and d_sensordata."""
    address = int32_at(pointer_at(m + at.m_sensor_adr), sensor)
    return doubles(pointer_at(d + at.d_sensordata) + 8 * address, count)


@inner
def packed(word, place, bits):
    """Returns the number at a place of a word, from 0; -1 for none."""
    return ((word >> (bits * place)) & (2**bits - 1)) - 1


def pack(numbers: Iterable[int], bits: int) -> int:
    """Returns a word of numbers from 0, or -1 for none, which `packed` reads."""
    numbers = [*numbers]
    if max(numbers) >= 2**bits - 1:
        raise InputError(
            f"the model has more than {2**bits - 1} objects of a kind; make the model smaller"
        )
    return sum((number + 1) << (bits * place) for place, number in enumerate(numbers))


WORDS = re.compile(r"[^ \t\n\r]+")
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
LARGEST, SMALLEST = 1e100, 1e-100  # sizes of numbers, whose squares and products stay finite
SENTENCE_LIMIT = 500


def numbers(config: Mapping[str, str], key: str) -> list[float]:
    """Returns the numbers of a config key with blanks between them; none for an empty text."""
    found = [_number(word) for word in WORDS.findall(config[key])]
    if not all(number == 0 or SMALLEST <= abs(number) <= LARGEST for number in found):
        raise InputError(
            f"{key} is {shown(config[key])}: give numbers, 0 or 1e-100 to 1e100 in size, with "
            "blanks between them"
        )
    return found


def number(config: Mapping[str, str], key: str) -> float:
    """Returns the one number of a config key."""
    found = [_number(word) for word in WORDS.findall(config[key])]
    if len(found) != 1 or not (found[0] == 0 or SMALLEST <= abs(found[0]) <= LARGEST):
        raise InputError(
            f"{key} is {shown(config[key])}: give one number, 0 or 1e-100 to 1e100 in size"
        )
    return found[0]


def _number(word: str) -> float:
    """Returns a decimal number, or NaN for other words, also those that `float` accepts."""
    return float(word) if NUMBER.fullmatch(word) else np.nan


_MODEL, _DATA = struct("mjModel"), struct("mjData")
Fields = namedtuple(
    "Fields",
    "m_nplugin m_nsensor m_npluginattr m_jnt_type m_jnt_qposadr m_qpos0 m_sensor_type "
    "m_sensor_plugin m_plugin m_plugin_statenum m_plugin_attr m_plugin_attradr m_names "
    "m_name_sensoradr d_plugin_data mjSENS_PLUGIN",
)
"""What set-up in Python reads, and `layout` checks."""


class Instance:
    """An instance of a plugin in an mjModel.

    Attributes:
        model: The mjModel, a ctypes structure, with the addresses of its arrays.
        number: Number of the instance.
    """

    def __init__(self, address: int, number: int) -> None:
        self.model, self.number = _MODEL.from_address(address), number

    def sibling(self, number: int) -> "Instance":
        """Returns another instance in the same model."""
        return Instance(ctypes.addressof(self.model), number)

    def integer(self, array: str, index: int) -> int:
        """Returns an element of an int array of the model."""
        return ctypes.c_int.from_address(getattr(self.model, array) + 4 * index).value

    @property
    def plugin(self) -> "Registered":
        """The plugin, with its `name` and its `keys`."""
        return _slots[self.integer("plugin", self.number)]

    @cached_property
    def raw(self) -> bytes:
        """The values of all config keys as C strings, which tell configs apart."""
        begin, last = self.integer("plugin_attradr", self.number), self.number + 1
        end = self.model.npluginattr
        if last < self.model.nplugin:
            end = self.integer("plugin_attradr", last)
        return ctypes.string_at(self.model.plugin_attr + begin, end - begin)

    @cached_property
    def config(self) -> dict[str, str]:
        """The text of each config key, empty where the key was not given."""
        return config_of(self.plugin.keys, self.raw)

    def find(self, noun: str, key: str) -> int:
        """Returns the id of the object, as a "joint", that a config key names."""
        name = self.config[key]
        kind = mujoco.mju_str2Type(noun)
        found = _name2id(ctypes.addressof(self.model), kind, name.encode())
        if found < 0:
            about = "" if key == self.plugin.keys[0] else f"{key} is {shown(name)}: "
            raise InputError(
                f"{about}the model has no such {noun}; name one, and attach plugins after a spec "
                "got its name prefix"
            )
        return found

    def sensor_name(self, sensor: int) -> str:
        """Returns the name of a sensor."""
        address = self.model.names + self.integer("name_sensoradr", sensor)
        return ctypes.string_at(address).decode()

    def sensors(self, quantities: Sequence[str]) -> list[int]:
        """Returns the instance's sensor of each quantity, with which its name ends; -1 for none."""
        found, count = [-1] * len(quantities), self.model.nsensor
        owners = (ctypes.c_int * count).from_address(self.model.sensor_plugin or 0) if count else ()
        for sensor, owner in enumerate(owners):
            if owner != self.number or self.integer("sensor_type", sensor) != SENSOR_TYPE:
                continue
            name = self.sensor_name(sensor)
            kind = next((k for k, one in enumerate(quantities) if name.endswith(one)), None)
            if kind is None:
                raise InputError(
                    "the name of each of its sensors must end in "
                    f"{', '.join(quantities[:-1])} or {quantities[-1]}, which is the measured "
                    "quantity"
                )
            if found[kind] >= 0:
                raise InputError("two of its sensors measure the same; leave one out")
            found[kind] = sensor
        return found

    def complain(self, error: Exception) -> None:
        """Issues a MuJoCo warning about the instance, which its first config key describes."""
        plugin = self.plugin
        subject = f"{plugin.keys[0]} {shown(self.config[plugin.keys[0]])}" if plugin.keys else "it"
        sentence = f"{plugin.name} of {subject}: {error}"[:SENTENCE_LIMIT]
        _warning(sentence.replace("%", "%%").encode())


SENSOR_TYPE = int(mujoco.mjtSensor.mjSENS_PLUGIN)


def config_of(keys: Sequence[str], raw: bytes) -> dict[str, str]:
    """Returns the texts of config keys, which are end to end in `raw` as C strings."""
    texts = (text.decode(errors="replace") for text in raw.split(b"\0"))
    return dict(zip(keys, texts, strict=False))


STAGE_POS, STAGE_VEL = 1, 2  # mjSTAGE_POS, mjSTAGE_VEL

# The arguments of each callback, from mujoco/mjplugin.h; pointers are integers here.
_POINTER, _INT = types.intp, types.int32
SIGNATURES = {
    "copy": types.void(_POINTER, _POINTER, _POINTER, _INT),
    "compute": types.void(_POINTER, _POINTER, _INT, _INT),
    "advance": types.void(_POINTER, _POINTER, _INT),
}
_P, _I = ctypes.c_ssize_t, ctypes.c_int
SETUP = {
    "nstate": ctypes.CFUNCTYPE(_I, _P, _I),
    "nsensordata": ctypes.CFUNCTYPE(_I, _P, _I, _I),
    "init": ctypes.CFUNCTYPE(_I, _P, _P, _I),
    "reset": ctypes.CFUNCTYPE(None, _P, _P, _P, _I),
}

_lock = threading.RLock()
_plugins: dict[
    str, "Registered"
] = {}  # C has pointers into these objects as long as the process lives
_slots: dict[int, "Registered"] = {}


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


def _copier(at: Any) -> Any:
    """Compiles the callback that gives a copied mjData the words of all instances."""

    @callback
    def copy(destination, m, source, instance):
        words = carray(_pointer(pointer_at(destination + at)), (instance + 1,), dtype=np.intp)
        words[instance] = pointer_at(pointer_at(source + at) + 8 * instance)

    return copy


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
        keys: Names of the config keys; the first one names the thing on which an instance acts.
        build: Function that returns the functions of the plugin; it is called, and compiles, when
            the plugin is first needed.
        stage: Stage whose results the sensors need, as `STAGE_VEL` for velocities.
        sensors: Whether the plugin has sensors too. MuJoCo then calls `compute` with
            mjPLUGIN_SENSOR as well as with mjPLUGIN_PASSIVE.

    Returns:
        The slot of the plugin, its number in `mjModel.plugin`.
    """
    with _lock:
        if name not in _plugins:
            layout(Fields)
            _plugins[name] = Registered(name, keys, build, stage, sensors)
            _slots[_plugins[name].slot] = _plugins[name]
        return _plugins[name].slot


def compile_plugin(name: str) -> None:
    """Compiles a registered plugin, unless that is done; the first time takes seconds.

    Without this call MuJoCo's first call compiles the plugin, and no exception can pass through.
    """
    _plugins[name].functions()


class Registered:
    """A registered plugin, whose callbacks are put in place when they are compiled.

    Attributes:
        name: Name of the plugin.
        keys: Names of its config keys.
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
        self.name, self.keys, self._build = name, tuple(keys), build
        self._functions: dict[str, Any] = {}
        self._keys = (ctypes.c_char_p * len(keys))(*(key.encode() for key in keys))
        self._setup = {which: kind(self._guarded(which)) for which, kind in SETUP.items()}
        library = mujoco_library()
        plugin = Plugin()
        library.mjp_defaultPlugin(ctypes.byref(plugin))
        plugin.name = name.encode()
        plugin.nattribute = len(keys)
        plugin.attributes = self._keys
        plugin.capabilityflags = PASSIVE | SENSOR if sensors else PASSIVE
        plugin.needstage = stage
        for which, function in self._setup.items():
            setattr(plugin, which, ctypes.cast(function, ctypes.c_void_p).value)
        self.slot: int = library.mjp_registerPlugin(ctypes.byref(plugin))
        library.mjp_getPluginAtSlot.restype = ctypes.POINTER(Plugin)
        self._entry = library.mjp_getPluginAtSlot(self.slot).contents  # MuJoCo's own copy

    def functions(self) -> dict[str, Any]:
        """Returns all functions by name; compiles at first, and tells MuJoCo what is compiled."""
        with _lock:
            if not self._functions:
                copier = _copier(layout(Fields).d_plugin_data)
                self._functions = {one.__name__: one for one in (copier, *self._build())}
                for which in SIGNATURES.keys() & self._functions:
                    setattr(self._entry, which, self._functions[which].address)
            return self._functions

    def _guarded(self, which: str) -> Callable[..., int]:
        """Returns a callback through which no exception passes into MuJoCo."""
        function = getattr(self, f"_{which}")

        def guarded(*arguments: int) -> int:
            try:
                return function(*arguments)
            except KeyboardInterrupt:
                _thread.interrupt_main()
            except BaseException:  # MuJoCo gets a failure instead
                traceback.print_exc()
            return -1

        return guarded

    def _nstate(self, m: int, number: int) -> int:
        try:
            return self.functions()["nstate"](Instance(m, number))
        except InputError:  # `init` will say it
            return 0

    def _nsensordata(self, m: int, number: int, sensor: int) -> int:
        count = self.functions().get("nsensordata")
        return count(Instance(m, number), sensor) if count else 1

    def _init(self, m: int, d: int, number: int) -> int:
        instance = Instance(m, number)
        try:
            word = self.functions()["init"](instance)
        except InputError as error:
            instance.complain(error)
            return -1
        ctypes.c_ssize_t.from_address(_DATA.from_address(d).plugin_data + 8 * number).value = word
        return 0

    def _reset(self, m: int, state: int, word: int, number: int) -> int:
        instance = Instance(m, number)
        size = instance.integer("plugin_statenum", number)
        buffer: Any = (ctypes.c_double * size).from_address(state)
        try:
            self._functions["reset"](instance, np.ndarray(size, np.float64, buffer), word)
        except InputError as error:
            instance.complain(error)
        return 0
