"""Makes the plugins known to MuJoCo, once per process."""

import ctypes
import threading
from typing import Any

from .. import _callbacks
from .._models import COMMON_KEYS, OWN_KEYS, PLUGIN_NAMES
from ._layout import PASSIVE, SENSOR, Plugin, layout
from ._memory import mujoco_library

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
            for name, keys in zip(PLUGIN_NAMES, OWN_KEYS, strict=True):
                _slots[name] = register_plugin(name, COMMON_KEYS + keys, callbacks, STAGE_POS)
        return dict(_slots)


def register_plugin(name: str, keys: tuple[str, ...], callbacks: dict[str, Any], stage: int) -> int:
    """Registers one plugin of passive forces and sensors; returns its slot.

    Args:
        name: the plugin's name in MJCF.
        keys: its config keys.
        callbacks: compiled C functions by the name of their field in mjpPlugin.
        stage: the mjtStage whose results its sensors need.
    """
    library = mujoco_library()
    attributes = (ctypes.c_char_p * len(keys))(*(key.encode() for key in keys))
    plugin = Plugin()
    library.mjp_defaultPlugin(ctypes.byref(plugin))
    plugin.name = name.encode()
    plugin.nattribute = len(keys)
    plugin.attributes = attributes
    plugin.capabilityflags = PASSIVE | SENSOR
    plugin.needstage = stage
    for callback, compiled in callbacks.items():
        setattr(plugin, callback, compiled.address)
    _registered.extend((attributes, plugin, callbacks))
    return library.mjp_registerPlugin(ctypes.byref(plugin))
