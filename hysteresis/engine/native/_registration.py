"""Compiles callbacks with the C signatures of a plugin, and makes plugins known to MuJoCo.

A plugin is registered at once and compiled when it is first needed: by `compile_plugin`, or when
MuJoCo first calls one of its callbacks.
"""

import _thread
import ctypes
import threading
import traceback
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from numba import cfunc, types

from ._layout import PASSIVE, SENSOR, Plugin
from ._memory import mujoco_library

STAGE_POS, STAGE_VEL, STAGE_ACC = 1, 2, 3  # mjSTAGE_POS, mjSTAGE_VEL, mjSTAGE_ACC

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
# MuJoCo calls one of these before any other: the first two when it compiles a model, the last one
# when it makes an mjData.
FIRST = {
    "nstate": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_int),
    "nsensordata": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_int, ctypes.c_int),
    "init": ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_ssize_t, ctypes.c_ssize_t, ctypes.c_int),
}

_lock = threading.RLock()
_plugins: dict[str, "_Registered"] = {}  # C points into it as long as the process lives


def callback(function: Callable[..., Any]) -> Any:
    """Compiles a callback (a decorator); the name of the function says which one it is.

    The machine code is cached on disk, separately for each set of values that the function takes
    from the function around it. A function that has no file, as in a notebook, is not cached.

    Raises:
        KeyError: No callback has the name of the function.
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
        keys: Names of its config keys, in the order in which `config` counts them.
        build: Function that compiles and returns the callbacks; it is called when the plugin is
            first needed.
        stage: Stage whose results the sensors need, as `STAGE_VEL` for velocities.
        sensors: Whether it has sensors too. MuJoCo then calls `nsensordata`, and `compute` with
            mjPLUGIN_SENSOR as well as with mjPLUGIN_PASSIVE.

    Returns:
        The slot of the plugin, its number in `mjModel.plugin`.
    """
    with _lock:
        if name not in _plugins:
            _plugins[name] = _Registered(name, keys, build, stage, sensors)
        return _plugins[name].slot


def compile_plugin(name: str) -> None:
    """Compiles a registered plugin, unless that is done; it takes seconds the first time.

    Otherwise MuJoCo's first call compiles it, through which no exception can pass.
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
        """Returns a callback for MuJoCo's first call: it compiles the plugin, then repeats it."""

        def begin(*arguments: int) -> int:
            try:
                return self.compile()[which].ctypes(*arguments)
            except KeyboardInterrupt:
                _thread.interrupt_main()
            except BaseException:  # none may pass through MuJoCo, which gets a failure instead
                traceback.print_exc()
            return -1

        return begin
