"""Pictures and windows; OpenGL is not used before the first picture or window."""

import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..checks import within
from ..errors import InputError, unknown_name
from .freed_memory import give_back
from .model import ArmConfig, compose
from .model.workplace import CARRIED, Edits
from .simulation.simulation import Posture

RenderQuality = Literal["fast", "fine"]

WINDOW_CLOSES = 5.0  # [s], longest wait for a window to close
SEEN, HIDDEN = 2, 5  # groups of geoms
FARTHER = 1.5  # times the usual distance of the camera, where something is beside the arm
LONGEST_BETWEEN = 10.0  # [s], greatest `picture_dt`


@dataclass(frozen=True)
class _Quality:
    """Settings of OpenGL, which take time of the processor without a graphics card."""

    shadowsize: int  # pixels; 0 draws no shadows
    offsamples: int  # samples a pixel; more than 0 smooths edges
    numslices: int  # number of slices around a round shape
    numstacks: int  # number of stacks along a round shape
    reflection: bool

    def ask(self, model: mujoco.MjModel) -> None:
        quality = model.vis.quality
        quality.shadowsize, quality.offsamples = self.shadowsize, self.offsamples
        quality.numslices, quality.numstacks = self.numslices, self.numstacks


QUALITIES = {
    "fast": _Quality(shadowsize=0, offsamples=0, numslices=36, numstacks=24, reflection=False),
    "fine": _Quality(shadowsize=4096, offsamples=8, numslices=64, numstacks=48, reflection=True),
}


class Capsule(NamedTuple):
    """A cylinder with round ends, to draw beside an arm."""

    begin: Array  # middle of one end in the world [m], shape (3,)
    end: Array  # middle of the other end [m]
    radius: float  # m
    color: Array  # red, green, blue and opacity, 0 to 1, shape (4,)

    def into(self, geom: mujoco.MjvGeom) -> mujoco.MjvGeom:
        """Turns a geom of a scene into this capsule, and returns the geom."""
        capsule, origin = mujoco.mjtGeom.mjGEOM_CAPSULE, np.zeros(3)
        color = np.asarray(self.color, np.float32)
        mujoco.mjv_initGeom(geom, capsule, origin, origin, np.eye(3).ravel(), color)
        mujoco.mjv_connector(geom, capsule, self.radius, self.begin, self.end)
        return geom


class RenderingUnavailableError(InputError):
    """Rendering is not possible on this machine, which has no usable OpenGL."""


class ArmRenderer:
    """Draws one arm from one camera.

    The drawn model and the objects of OpenGL are made for the first picture, and never pickled.

    Args:
        config: Configuration of the arm.
        edits: Additions of a task to the model.
        camera: Name of a camera of the model.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
        quality: "fast", which is quick without a graphics card too, or "fine", with shadows,
            smooth edges and reflections.
        picture_dt: Simulated time between new pictures [s]. Before this time has passed, `picture`
            returns the last picture again.

    Attributes:
        beside: Function that returns the capsules to draw beside the arm; None for no capsules.
    """

    # Reason for which OpenGL does not work in this process: a second attempt could abort it.
    _unavailable: ClassVar[str | None] = None

    def __init__(
        self,
        config: ArmConfig,
        edits: Edits | None,
        camera: str,
        width: int,
        height: int,
        quality: RenderQuality = "fast",
        picture_dt: float = 0.0,
    ) -> None:
        if not all(isinstance(size, int) and size >= 1 for size in (width, height)):
            raise InputError(
                f"the picture size is {width!r} x {height!r}: use whole numbers, at least 1 x 1 "
                "pixel"
            )
        if not isinstance(quality, str) or quality not in QUALITIES:
            raise unknown_name("render_quality", quality, list(QUALITIES))
        within("picture_dt", picture_dt, 0, LONGEST_BETWEEN, " s")
        self.beside: Callable[[], Sequence[Capsule]] | None = None
        self._config, self._edits, self._camera = config, edits, camera
        self._width, self._height, self._picture_dt = width, height, picture_dt
        self._quality = QUALITIES[quality]
        self._drawn: tuple[mujoco.MjModel, mujoco.MjData] | None = None
        self._last: tuple[float, NDArray[np.uint8]] | None = None
        self._offscreen: Any = None
        self._window: Any = None
        self._window_threads: set[threading.Thread] = set()
        self._process = os.getpid()
        self._shown = 0.0

    def picture(self, posture: Posture) -> NDArray[np.uint8]:
        """Returns a picture of the arm, shape (height, width, 3).

        Raises:
            RenderingUnavailableError: This machine has no OpenGL.
            InputError: The model has no such camera.
        """
        if self._last is not None:
            begin, picture = self._last
            if 0 < posture.time - begin < self._picture_dt - 1e-9:
                return picture.copy()
        model, data = self._posed(posture)
        cameras = [model.camera(i).name for i in range(model.ncam)]
        if self._camera not in cameras:
            raise unknown_name("camera", self._camera, cameras)
        offscreen = self._opengl(model)
        offscreen.update_scene(data, camera=self._camera)
        _add(self.beside() if self.beside else (), offscreen.scene)
        picture = offscreen.render().copy()
        if self._picture_dt > 0:
            self._last = posture.time, picture.copy()
        return picture

    def forget(self) -> None:
        """Forgets the last picture: the next call of `picture` draws a new one."""
        self._last = None

    def _posed(self, posture: Posture) -> tuple[mujoco.MjModel, mujoco.MjData]:
        if self._drawn is None:
            model = compose(self._config, edits=self._edits)
            self._drawn = model, mujoco.MjData(model)
        model, data = self._drawn
        data.time, data.qpos[:] = posture.time, posture.position
        for i in range(model.ngeom):
            if model.geom(i).name.startswith(CARRIED):
                model.geom_group[i] = SEEN if posture.loaded else HIDDEN
        mujoco.mj_fwdPosition(model, data)
        return model, data

    def _opengl(self, model: mujoco.MjModel) -> mujoco.Renderer:
        if self._offscreen is not None and self._process != os.getpid():
            raise RenderingUnavailableError(
                "this process was forked after OpenGL was in use, which OpenGL does not survive: "
                "start workers by spawn or forkserver"
            )
        if self._offscreen is None:
            self._process = os.getpid()
            self._quality.ask(model)
            buffer = model.vis.global_
            buffer.offwidth = max(buffer.offwidth, self._width)
            buffer.offheight = max(buffer.offheight, self._height)
            try:
                if ArmRenderer._unavailable is None:
                    self._offscreen = mujoco.Renderer(model, self._height, self._width)
            except Exception as error:  # GL back ends raise exceptions of any class
                ArmRenderer._unavailable = f"{type(error).__name__}: {error}"
        if self._offscreen is None:
            raise RenderingUnavailableError(
                f"no OpenGL context ({ArmRenderer._unavailable}): on a machine without a display "
                "install libegl1 and set MUJOCO_GL=egl before Python starts"
            )
        flags = self._offscreen.scene.flags
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = self._quality.reflection
        return self._offscreen

    def show(self, posture: Posture, period: float) -> None:
        """Opens a window at the first call, and updates it at most once per `period` [s].

        The camera of the window begins farther away if capsules are drawn beside the arm.

        Raises:
            RenderingUnavailableError: No window can be opened on this machine, or it was closed.
        """
        beside = None if self.beside is None else self.beside()
        model, data = self._posed(posture)
        if self._window is None:
            if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
                raise RenderingUnavailableError(
                    "there is no display to open a window on: use render_mode='rgb_array'"
                )
            import mujoco.viewer

            others = set(threading.enumerate())
            self._quality.ask(model)
            try:
                self._window = mujoco.viewer.launch_passive(model, data)
            except Exception as error:
                raise RenderingUnavailableError(
                    f"no window can be opened ({error}): use render_mode='rgb_array' on a machine "
                    "without a display"
                ) from error
            self._window_threads = set(threading.enumerate()) - others
            with self._window.lock():
                mujoco.mjv_defaultFreeCamera(model, self._window.cam)
                if beside is not None:
                    self._window.cam.distance *= FARTHER
        if not self._window.is_running():
            raise RenderingUnavailableError("the window was closed: make the environment again")
        time.sleep(max(0.0, self._shown + period - time.monotonic()))
        self._shown = time.monotonic()
        with self._window.lock():
            self._window.user_scn.ngeom = 0
            _add(beside or (), self._window.user_scn)
        self._window.sync()

    def close(self) -> None:
        """Frees the OpenGL objects; later calls do nothing."""
        for part in (self._offscreen, self._window):
            if part is not None:
                part.close()
        for thread in self._window_threads:
            thread.join(WINDOW_CLOSES)  # a process crashes if it ends before its window
        self._offscreen, self._window, self._window_threads = None, None, set()
        self._last = None
        give_back()

    def __getstate__(self) -> dict[str, Any]:
        fresh = {"_offscreen": None, "_window": None, "_window_threads": set(), "_last": None}
        return {**self.__dict__, **fresh, "_drawn": None, "beside": None}


def _add(capsules: Sequence[Capsule], scene: mujoco.MjvScene) -> None:
    """Adds as many capsules to a scene as the scene has room for."""
    for geom, capsule in zip(scene.geoms[scene.ngeom :], capsules, strict=False):
        capsule.into(geom)
        scene.ngeom += 1
