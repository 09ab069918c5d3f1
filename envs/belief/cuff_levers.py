"""Levers of the cuffs: how the sites of the exoskeleton move where cuff forces are measured."""

import mujoco
import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model.cuffs import CUFF_SITES
from .trigonometric import Trigonometric


class CuffLevers:
    """Motion of the three cuffs of an exoskeleton per angle of its joints.

    Args:
        model: Model of an arm with its exoskeleton on cuffs.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        # What a joint moves, seen from there, does not depend on that joint nor on those above it.
        self._levers = Trigonometric(_levers(model), len(JOINTS) - 1, 1)

    def __call__(self, angle: Array) -> Array:
        """Returns motions per angle [m/rad] in the axes of the cuffs' sites, shape (n, 9, 4).

        The forces that sensors tell on the limb are in these axes; on the exoskeleton they act the
        other way, so that their torque on a joint is less the sum of the products.

        Args:
            angle: Angles of the exoskeleton's joints [rad], shape (n, 4).
        """
        return self._levers(angle[:, 1:])


def _levers(model: mujoco.MjModel):
    """Returns a function from the angles below the first joint to levers [m], shape (9, 4)."""
    data, jacobian = mujoco.MjData(model), np.empty((3, model.nv))
    sites = [model.site(name).id for name in CUFF_SITES.values()]
    places = [model.joint(f"exo_{joint}").qposadr[0] for joint in JOINTS]
    moved = [model.joint(f"exo_{joint}").dofadr[0] for joint in JOINTS]

    def at(pose: Array) -> Array:
        data.qpos[places[1:]] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        found = []
        for site in sites:
            mujoco.mj_jacSite(model, data, jacobian, None, site)
            found.append(data.site_xmat[site].reshape(3, 3).T @ jacobian[:, moved])
        return np.concatenate(found)

    return at
