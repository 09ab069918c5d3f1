"""The command line `activesuit` and nothing that a library user would import."""

import ctypes
import os
import sys


def _render_without_display() -> None:
    """Chooses EGL where there is no display but a libEGL; MuJoCo reads the choice when imported."""
    if sys.platform != "linux" or {"MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return
    os.environ["MUJOCO_GL"] = "egl"


_render_without_display()
