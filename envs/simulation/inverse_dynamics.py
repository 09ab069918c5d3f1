"""Torque that moves a bare arm along a motion: the recursive Newton-Euler algorithm in a kernel.

Featherstone 2008, Rigid Body Dynamics Algorithms, chapter 5.3, for a chain of four hinges, in the
frame of each link. The relaxed arm's own springs and dampers are part of the torque.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numba import njit

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError
from ...kernels import inner
from .structs import BareArm, Index, Motions

# Columns of a link: position and axis of its joint in the frame above, mass, center of mass,
# inertia about it (xx, yy, zz, xy, xz, yz) in its own axes, stiffness, rest angle and damping.
POSITION, AXIS, MASS, CENTER, INERTIA = 0, 3, 6, 7, 10
STIFFNESS, REST, DAMPING, LINK = 16, 17, 18, 19


@dataclass(frozen=True, eq=False)
class Chain:
    """Inertial parameters of bare arms, shape (arms, ...)."""

    links: Array  # parameters of every link, shape (arms, 4, 19), in the columns named above
    gravity: Array  # acceleration of free fall in the frame of the torso [m/s²], shape (arms, 3)
    down: Array  # unit vector down in that frame, shape (arms, 3)

    @classmethod
    def of(cls, arm: mujoco.MjModel, *, dressed: bool = False) -> "Chain":
        """Returns the chain of one arm, from a model such as that of `bare_arm`.

        With `dressed`, the links include suit and load; they never include an exoskeleton.
        """
        joints = [arm.joint(joint).id for joint in JOINTS]
        bodies = arm.jnt_bodyid[joints]
        turned = np.abs(arm.body_quat[bodies] - [1, 0, 0, 0]).max() > 1e-12
        if (
            turned
            or arm.jnt_pos[joints].any()
            or (arm.body_parentid[bodies[1:]] != bodies[:-1]).any()
        ):
            raise InputError("the bare arm is no chain of four hinges: compose it anew")
        links, data = np.zeros((len(JOINTS), LINK)), mujoco.MjData(arm)
        mujoco.mj_kinematics(arm, data)
        for link, joint, body in zip(links, joints, bodies, strict=True):
            link[POSITION:AXIS] = arm.body_pos[body]
            link[AXIS:MASS] = arm.jnt_axis[joint]
            link[MASS] = arm.body_mass[body]
            link[CENTER:INERTIA] = arm.body_ipos[body]
            axes = np.empty(9)
            mujoco.mju_quat2Mat(axes, arm.body_iquat[body])
            rotation = axes.reshape(3, 3)
            inertia = rotation * arm.body_inertia[body] @ rotation.T
            link[INERTIA:STIFFNESS] = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            dof = arm.jnt_dofadr[joint]
            link[STIFFNESS] = arm.jnt_stiffness[joint]
            link[REST] = arm.qpos_spring[arm.jnt_qposadr[joint]]
            link[DAMPING] = arm.dof_damping[dof]
            if dressed:
                _dress(link, arm, data, body, last=body == bodies[-1])
        torso = data.xmat[arm.body_parentid[bodies[0]]].reshape(3, 3)
        down = torso.T @ np.array([0.0, 0.0, -1.0])
        return cls(links[None], (torso.T @ arm.opt.gravity)[None], down[None])

    def rows(self, n: int) -> BareArm:
        """Returns the only arm of this chain for `n` rows, as the kernels take it."""
        return BareArm(
            links=np.repeat(self.links, n, axis=0),
            gravity=np.repeat(self.gravity, n, axis=0),
            torque=np.zeros((n, len(JOINTS))),
            scratch=np.empty((n, len(JOINTS), 8)),
        )


def _dress(link: Array, arm: mujoco.MjModel, data: mujoco.MjData, body: int, *, last: bool) -> None:
    """Adds suit and load to the inertia of a link; the arm is straight in `data`."""
    parts = [body]
    for i in range(arm.nbody):
        name = arm.body(i).name
        of_suit = name.startswith("suit_") and arm.body_weldid[i] == arm.body_weldid[body]
        if of_suit or (name == "payload" and last):
            parts.append(i)
    mass, places = arm.body_mass[parts], data.xipos[parts] - data.xpos[body]
    frame = data.xmat[body].reshape(3, 3)
    center = mass @ places / mass.sum()
    inertia = np.zeros((3, 3))
    for i, m, place in zip(parts, mass, places, strict=True):
        axes, away = data.ximat[i].reshape(3, 3), place - center
        inertia += axes * arm.body_inertia[i] @ axes.T
        inertia += m * (away @ away * np.eye(3) - np.outer(away, away))
    inertia = frame.T @ inertia @ frame
    link[MASS], link[CENTER:INERTIA] = mass.sum(), frame.T @ center
    link[INERTIA:STIFFNESS] = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


@inner(forceinline=True)
def turned(
    x: float, y: float, z: float, ux: float, uy: float, uz: float, s: float, c: float
) -> tuple[float, float, float]:
    """Returns a vector in a frame turned about u: c x + (1 - c)(u x)u - s u x x."""
    dot = (1.0 - c) * (ux * x + uy * y + uz * z)
    return (
        c * x + dot * ux - s * (uy * z - uz * y),
        c * y + dot * uy - s * (uz * x - ux * z),
        c * z + dot * uz - s * (ux * y - uy * x),
    )


@inner(forceinline=True)
def arm_torque(row: Index, sample: Index, arm: BareArm, motion: Motions) -> None:
    """Computes the torque that moves a bare arm at a sample of a motion, in `arm.torque` [N·m].

    One pass goes out along the links and one comes back, in scalars. `arm.scratch` takes sine and
    cosine of each joint, then force and moment at its origin.
    """
    links, gravity, scratch, torque = arm.links, arm.gravity, arm.scratch, arm.torque
    angle, rate, acceleration = motion.angle, motion.rate, motion.acceleration
    wx, wy, wz = 0.0, 0.0, 0.0  # rate of turning of the frame above
    bx, by, bz = 0.0, 0.0, 0.0  # its derivative
    ax, ay, az = -gravity[row, 0], -gravity[row, 1], -gravity[row, 2]
    for i in range(4):
        px, py, pz = links[row, i, 0], links[row, i, 1], links[row, i, 2]
        ux, uy, uz = links[row, i, 3], links[row, i, 4], links[row, i, 5]
        # Acceleration of the joint's origin: a + b x p + w x (w x p), in the frame above.
        cx, cy, cz = wy * pz - wz * py, wz * px - wx * pz, wx * py - wy * px
        ax = ax + by * pz - bz * py + wy * cz - wz * cy
        ay = ay + bz * px - bx * pz + wz * cx - wx * cz
        az = az + bx * py - by * px + wx * cy - wy * cx
        q, v, d = angle[row, sample, i], rate[row, sample, i], acceleration[row, sample, i]
        s, c = math.sin(q), math.cos(q)
        scratch[row, i, 0], scratch[row, i, 1] = s, c
        # Into the frame of the link, which is turned by q about u.
        ax, ay, az = turned(ax, ay, az, ux, uy, uz, s, c)
        wx, wy, wz = turned(wx, wy, wz, ux, uy, uz, s, c)
        bx, by, bz = turned(bx, by, bz, ux, uy, uz, s, c)
        bx, by, bz = (
            bx + d * ux + v * (wy * uz - wz * uy),
            by + d * uy + v * (wz * ux - wx * uz),
            bz + d * uz + v * (wx * uy - wy * ux),
        )
        wx, wy, wz = wx + v * ux, wy + v * uy, wz + v * uz
        # Newton's law for the center of mass, Euler's about it.
        m = links[row, i, 6]
        rx, ry, rz = links[row, i, 7], links[row, i, 8], links[row, i, 9]
        cx, cy, cz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx
        fx = m * (ax + by * rz - bz * ry + wy * cz - wz * cy)
        fy = m * (ay + bz * rx - bx * rz + wz * cx - wx * cz)
        fz = m * (az + bx * ry - by * rx + wx * cy - wy * cx)
        ixx, iyy, izz = links[row, i, 10], links[row, i, 11], links[row, i, 12]
        ixy, ixz, iyz = links[row, i, 13], links[row, i, 14], links[row, i, 15]
        hx = ixx * wx + ixy * wy + ixz * wz
        hy = ixy * wx + iyy * wy + iyz * wz
        hz = ixz * wx + iyz * wy + izz * wz
        scratch[row, i, 2], scratch[row, i, 3], scratch[row, i, 4] = fx, fy, fz
        scratch[row, i, 5] = ixx * bx + ixy * by + ixz * bz + wy * hz - wz * hy + ry * fz - rz * fy
        scratch[row, i, 6] = ixy * bx + iyy * by + iyz * bz + wz * hx - wx * hz + rz * fx - rx * fz
        scratch[row, i, 7] = ixz * bx + iyz * by + izz * bz + wx * hy - wy * hx + rx * fy - ry * fx
    fx, fy, fz = 0.0, 0.0, 0.0  # force and moment on the link below, in the frame of this link
    nx, ny, nz = 0.0, 0.0, 0.0
    for back in range(4):
        i = 3 - back
        fx, fy, fz = fx + scratch[row, i, 2], fy + scratch[row, i, 3], fz + scratch[row, i, 4]
        nx, ny, nz = nx + scratch[row, i, 5], ny + scratch[row, i, 6], nz + scratch[row, i, 7]
        ux, uy, uz = links[row, i, 3], links[row, i, 4], links[row, i, 5]
        away = angle[row, sample, i] - links[row, i, 17]
        passive = links[row, i, 16] * away + links[row, i, 18] * rate[row, sample, i]
        torque[row, i] = ux * nx + uy * ny + uz * nz + passive
        # Back into the frame above, and to its origin.
        s, c = scratch[row, i, 0], scratch[row, i, 1]
        fx, fy, fz = turned(fx, fy, fz, ux, uy, uz, -s, c)
        nx, ny, nz = turned(nx, ny, nz, ux, uy, uz, -s, c)
        px, py, pz = links[row, i, 0], links[row, i, 1], links[row, i, 2]
        nx, ny, nz = nx + py * fz - pz * fy, ny + pz * fx - px * fz, nz + px * fy - py * fx


def arm_torques(chain: Chain, angle: Array, rate: Array, acceleration: Array) -> Array:
    """Returns the torque that moves a bare arm along a motion [N·m], all (samples, 4)."""
    arm, found = chain.rows(1), np.empty_like(angle)
    motion = Motions(angle[None].copy(), rate[None].copy(), acceleration[None].copy())
    along(found, arm, motion)
    return found


@njit(cache=True)
def along(found: Array, arm: BareArm, motion: Motions) -> None:
    """Computes the torque of the first arm at all samples of a motion, shape (samples, 4)."""
    for sample in range(found.shape[0]):
        arm_torque(np.int64(0), sample, arm, motion)
        for j in range(4):
            found[sample, j] = arm.torque[0, j]
