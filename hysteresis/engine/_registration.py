"""Makes the plugins known to MuJoCo, once per process."""

import ctypes
import threading

from . import _callbacks
from ._layout import PASSIVE, SENSOR, Plugin, layout
from ._memory import mujoco_library
from ._models import COMMON_KEYS, OWN_KEYS, PLUGIN_NAMES

STAGE_POS = 1  # mjSTAGE_POS: the sensors depend on the position and the sign of the velocity
_lock = threading.Lock()
_registered: list[object] = []  # what the C side points into, for the life of the process
_slots: dict[str, int] = {}


def register() -> dict[str, int]:
    """Registers a plugin for each model with MuJoCo, once; returns their slots (`mjModel.plugin`).

    Raises:
        RuntimeError: the installed MuJoCo is laid out differently from what it says.
    """
    with _lock:
        if not _slots:
            callbacks = _callbacks.build(layout())
            _registered.append(callbacks)
            for name, keys in zip(PLUGIN_NAMES, OWN_KEYS, strict=True):
                _slots[name] = _register(name, COMMON_KEYS + keys, callbacks)
        return dict(_slots)


def _register(name: str, keys: tuple[str, ...], callbacks: dict) -> int:
    library = mujoco_library()
    attributes = (ctypes.c_char_p * len(keys))(*(key.encode() for key in keys))
    plugin = Plugin()
    library.mjp_defaultPlugin(ctypes.byref(plugin))
    plugin.name = name.encode()
    plugin.nattribute = len(keys)
    plugin.attributes = attributes
    plugin.capabilityflags = PASSIVE | SENSOR
    plugin.needstage = STAGE_POS
    for callback, compiled in callbacks.items():
        setattr(plugin, callback, compiled.address)
    _registered.extend((attributes, plugin))
    return library.mjp_registerPlugin(ctypes.byref(plugin))
