"""Makes the plugin known to MuJoCo, once per process."""

import ctypes
import threading

from . import _callbacks
from ._configuration import ATTRIBUTES
from ._layout import PASSIVE, SENSOR, layout
from ._memory import mujoco_library

PLUGIN_NAME = "activesuit.jiles_atherton"
STAGE_POS = 1  # mjSTAGE_POS: the sensors depend on the position and the sign of the velocity
_lock = threading.Lock()
_registered: list[object] = []  # what the C side points into, for the life of the process
_slot = -1


class _Plugin(ctypes.Structure):
    """The C struct mjpPlugin of mujoco/mjplugin.h."""

    _fields_ = [
        ("name", ctypes.c_char_p),
        ("nattribute", ctypes.c_int),
        ("attributes", ctypes.POINTER(ctypes.c_char_p)),
        ("capabilityflags", ctypes.c_int),
        ("needstage", ctypes.c_int),
        *(
            (name, ctypes.c_void_p)
            for name in (
                "nstate",
                "nsensordata",
                "init",
                "destroy",
                "copy",
                "reset",
                "compute",
                "advance",
                "visualize",
                "actuator_act_dot",
                "sdf_distance",
                "sdf_gradient",
                "sdf_staticdistance",
                "sdf_attribute",
                "sdf_aabb",
            )
        ),
    ]


def register() -> int:
    """Registers `activesuit.jiles_atherton` with MuJoCo, once; returns its slot (`mjModel.plugin`).

    Raises:
        RuntimeError: the installed MuJoCo is laid out differently from what it says.
    """
    global _slot  # noqa: PLW0603
    with _lock:
        if _registered:
            return _slot
        library = mujoco_library()
        callbacks = _callbacks.build(layout())
        keys = (ctypes.c_char_p * len(ATTRIBUTES))(*(key.encode() for key in ATTRIBUTES))
        plugin = _Plugin()
        library.mjp_defaultPlugin(ctypes.byref(plugin))
        plugin.name = PLUGIN_NAME.encode()
        plugin.nattribute = len(keys)
        plugin.attributes = keys
        plugin.capabilityflags = PASSIVE | SENSOR
        plugin.needstage = STAGE_POS
        for name, callback in callbacks.items():
            setattr(plugin, name, callback.address)
        _slot = library.mjp_registerPlugin(ctypes.byref(plugin))
        _registered.extend((callbacks, keys, plugin))
        return _slot
