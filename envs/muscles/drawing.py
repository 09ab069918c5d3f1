"""Pictures of MyoArm in the posture of our arm, its muscles colored by their activation."""

import mujoco
import numpy as np
from matplotlib import colormaps
from numpy.typing import ArrayLike, NDArray

from ...arrays import Array
from ..rendering import Renderer, RenderQuality
from .myoarm import CHEST, MyoArm, lean, myoarm_spec

COLORS = "YlOrRd"
CAMERA = "arm"
EYE, TARGET = np.array([0.85, 0.2, 1.25]), np.array([0.24, -0.13, 0.0])
"""Camera and the place it looks at, forward, up and right of the shoulder [m]."""
WIDTH = 0.0055  # [m], of a muscle at rest
SWELLING = 0.006  # [m], by which a fully active one is thicker


def color_of(active: ArrayLike) -> Array:
    """Returns the colors of muscles, shape (..., 4), from pale at 0 to dark red at 1."""
    return np.asarray(colormaps[COLORS](0.15 + 0.85 * np.asarray(active)))


def width_of(active: ArrayLike) -> Array:
    """Returns how thick muscles are drawn [m]: the radius of each."""
    return WIDTH + SWELLING * np.asarray(active)


class MusclePanel:
    """MyoArm beside a motion.

    Args:
        angle: Our joint angles [rad], shape (samples, 4).
        activation: Activations, shape (samples, muscles), as `MyoArm.muscles` orders them.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
        quality: Quality of the pictures.
    """

    def __init__(
        self,
        angle: Array,
        activation: Array,
        *,
        width: int,
        height: int,
        quality: RenderQuality = "fast",
    ) -> None:
        self._arm = MyoArm.load()
        self._theirs = self._arm.angles(angle)
        self._activation = activation
        self._size = width, height
        self._most = max(float(activation.max()), 1e-3)
        self._model = self._drawn()
        self._data = mujoco.MjData(self._model)
        self._tendons = [self._model.actuator(name).trnid[0] for name in self._arm.muscles]
        self._renderer = Renderer(camera=CAMERA, width=width, height=height, quality=quality)

    def picture(self, sample: int) -> NDArray[np.uint8]:
        """Returns the picture of a sample, shape (height, width, 3)."""
        model, data = self._model, self._data
        share = self._activation[sample] / self._most
        model.tendon_rgba[self._tendons] = color_of(share)
        model.tendon_width[self._tendons] = width_of(share)
        data.qpos[:] = self._arm.coupled @ self._theirs[sample]
        mujoco.mj_fwdPosition(model, data)
        return self._renderer.picture(model, data)

    def close(self) -> None:
        """Frees what OpenGL holds."""
        self._renderer.close()

    def _drawn(self) -> mujoco.MjModel:
        """Compiles MyoArm with a camera and light beside it."""
        arm, still = self._arm, mujoco.MjData(self._arm.model)
        mujoco.mj_kinematics(arm.model, still)
        axes = still.body(CHEST).xmat.reshape(3, 3) @ arm.trunk
        shoulder = still.body("humerus_r").xpos
        spec = myoarm_spec()
        for part in [*spec.worldbody.geoms]:  # the room around it
            spec.delete(part)
        back = EYE - TARGET
        right = np.cross([0.0, 1.0, 0.0], back)
        up = np.cross(back, right)
        spec.worldbody.add_camera(
            name=CAMERA, pos=shoulder + axes @ EYE, xyaxes=[*(axes @ right), *(axes @ up)], fovy=33
        )
        whole = spec.visual.global_
        whole.offwidth, whole.offheight = self._size
        spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.45] * 3, [0.5] * 3
        return lean(spec)
