"""The command line `activesuit`; the library does not need this package."""

import ctypes
import os
import sys


def _render_without_display() -> None:
    """Lets MuJoCo render by EGL on a machine without a display; MuJoCo reads this when imported."""
    if sys.platform != "linux" or {"MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return
    os.environ["MUJOCO_GL"] = "egl"


_render_without_display()
