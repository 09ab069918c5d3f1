"""Compiles callbacks with the C signatures of a plugin, and makes plugins known to MuJoCo."""

import ctypes
import threading
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

_lock = threading.RLock()
_slots: dict[str, int] = {}
_kept: list[object] = []  # what the C side points into, for the life of the process


def callback(function: Callable[..., Any]) -> Any:
    """Compiles a callback (a decorator); the name of the function says which one it is.

    The machine code is cached on disk, separately for each set of values that the function takes
    from the function around it; but not where the function has no file, as in a notebook.

    Raises:
        KeyError: The name is that of no callback.
    """
    signature = SIGNATURES[function.__name__]
    try:
        return cfunc(signature, cache=True)(function)
    except RuntimeError:  # numba found no place for a cache
        return cfunc(signature)(function)


def register_plugin(
    name: str, keys: Sequence[str], build: Callable[[], Iterable[Any]], stage: int = STAGE_POS
) -> int:
    """Registers a plugin of passive forces with MuJoCo, once per process.

    A plugin with the callback `nsensordata` has sensors too: MuJoCo then calls `compute` with
    mjPLUGIN_SENSOR as well as with mjPLUGIN_PASSIVE.

    Args:
        name: Unique name of the plugin, which MJCF refers to.
        keys: Names of its config keys, in the order in which `config` counts them.
        build: Function that compiles the callbacks; it is called the first time only.
        stage: Stage whose results the sensors need, as `STAGE_VEL` for velocities.

    Returns:
        The slot of the plugin, its number in `mjModel.plugin`.
    """
    with _lock:
        if name not in _slots:
            _slots[name] = _register(name, keys, list(build()), stage)
        return _slots[name]


def _register(name: str, keys: Sequence[str], callbacks: Sequence[Any], stage: int) -> int:
    library = mujoco_library()
    attributes = (ctypes.c_char_p * len(keys))(*(key.encode() for key in keys))
    plugin = Plugin()
    library.mjp_defaultPlugin(ctypes.byref(plugin))
    plugin.name = name.encode()
    plugin.nattribute = len(keys)
    plugin.attributes = attributes
    has_sensors = any(compiled.__name__ == "nsensordata" for compiled in callbacks)
    plugin.capabilityflags = PASSIVE | SENSOR if has_sensors else PASSIVE
    plugin.needstage = stage
    for compiled in callbacks:
        setattr(plugin, compiled.__name__, compiled.address)
        _kept.append(compiled)
    _kept.extend((attributes, plugin))
    return library.mjp_registerPlugin(ctypes.byref(plugin))
