"""Weight, inertia and levers of an arm that a controller believes in, as functions of its angles.

All are sums of products of sines and cosines of joint angles, so that they are exact and fast.
"""

# pyright: reportCallIssue=false

import copy
import math
from collections.abc import Callable
from typing import Self

import mujoco
import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED
from ..model.cuffs import CUFF_SITES


class Trigonometric:
    """A function of joint angles that is a polynomial of a degree in their sines and cosines.

    Levers between joints that turn about fixed axes are of degree 1, masses of degree 2. The
    coefficients follow from as many evenly spaced poses as there are products, without error.

    Args:
        function: Function from angles of the joints on which it depends [rad], shape (joints,), to
            numbers, any shape.
        degree: Highest degree of the sine and cosine of one joint.
        first: Number of the first joint in `JOINTS` on which the function depends.

    Attributes:
        coefficients: Coefficients of the products, shape (products, numbers). The products of the
            first joints come first, and joint j multiplies them by 1, sin(k angle), cos(k angle).
    """

    def __init__(self, function: Callable[[Array], Array], degree: int, first: int = 0) -> None:
        turns = np.arange(2 * degree + 1) * math.tau / (2 * degree + 1)
        joints = len(JOINTS) - first
        poses = np.array(np.meshgrid(*[turns] * joints)).reshape(joints, -1).T
        values = np.array([function(pose) for pose in poses])
        products = np.empty((len(poses), len(poses)))
        for pose, row in zip(poses, products, strict=True):
            _multiply(pose, degree, -1, row)
        self.coefficients = np.linalg.solve(products, values.reshape(len(poses), -1))
        self._degree, self._first, self._shape = degree, first, values.shape[1:]

    def __sub__(self, other: Self) -> Self:
        """Returns the difference of two models."""
        rest = copy.copy(self)
        rest.coefficients = self.coefficients - other.coefficients
        return rest

    def __call__(self, angle: Array) -> Array:
        """Returns the values, shape (n, ...), at angles of the four joints [rad], shape (n, 4)."""
        return self.slope(angle, self._first - 1)

    def slope(self, angle: Array, joint: int) -> Array:
        """Returns the derivative with respect to the angle of a joint.

        For a joint before the first joint of the function, these are the values themselves.
        """
        found = np.zeros((len(angle), self.coefficients.shape[1]))
        given = np.ascontiguousarray(angle[:, self._first :])
        _sum(given, self._degree, joint - self._first, self.coefficients, found)
        return found.reshape(len(angle), *self._shape)


@njit(cache=True)
def _sum(angle, degree, slope, coefficients, found) -> None:
    products = np.empty(coefficients.shape[0])
    for row in range(angle.shape[0]):
        _multiply(angle[row], degree, slope, products)
        for i in range(products.size):
            for j in range(found.shape[1]):
                found[row, j] += products[i] * coefficients[i, j]


@njit(cache=True)
def _multiply(angle, degree, slope, products) -> None:
    """Fills in the products of 1, sines and cosines of multiples of each joint's angle."""
    products[0], count = 1.0, 1
    for j in range(angle.size):
        for k in range(1, degree + 1):
            s, c = math.sin(k * angle[j]), math.cos(k * angle[j])
            if j == slope:
                s, c = k * c, -k * s
            for i in range(count):
                products[(2 * k - 1) * count + i] = s * products[i]
                products[2 * k * count + i] = c * products[i]
        if j == slope:
            products[:count] = 0.0
        count *= 2 * degree + 1


ASSISTED_PLACES = [JOINTS.index(joint) for joint in ASSISTED]


class BelievedWeight(Trigonometric):
    """The static torque at the assisted joints that supports an arm, suit, exoskeleton and load.

    As a function of the four angles it gives torques [N·m], shape (n, 2).

    Args:
        model: Model of the believed arm; with cuffs, the exoskeleton's joints are taken at the
            same angles as the arm's.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        places = chains(model)
        data, torque = mujoco.MjData(model), np.zeros(model.nv)

        def static_torque(pose: Array) -> Array:
            for chain in places:
                data.qpos[chain] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_rne(model, data, 0, torque)
            return np.sum([torque[chain] for chain in places], axis=0)[ASSISTED_PLACES]

        super().__init__(static_torque, 1)


def chains(model: mujoco.MjModel) -> list[NDArray[np.int64]]:
    """Returns the addresses of the four joints: the arm's, and with cuffs the exoskeleton's too."""
    names: list[tuple[str, ...]] = [JOINTS]
    if any(model.joint(i).name == f"exo_{JOINTS[0]}" for i in range(model.njnt)):
        names.append(tuple(f"exo_{joint}" for joint in JOINTS))
    return [
        np.array([model.joint(joint).qposadr[0] for joint in chain], np.int64) for chain in names
    ]


BENT = (0.0, 0.0, np.pi / 2, 0.0)  # rad, hanging upper arm and level forearm


class BelievedInertia(Trigonometric):
    """The mass matrix of an arm with suit, exoskeleton, load and tools, at any pose.

    As a function of the four angles it gives matrices [kg·m²], shape (n, 4, 4), which depend only
    on the joints below the first joint.

    Args: model: Model of the believed arm; where cuffs hold the exoskeleton, its joints are taken
    at the same angles as the arm's.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        data, places = mujoco.MjData(model), chains(model)
        full = np.empty((model.nv, model.nv))

        def at(pose: Array) -> Array:
            for chain in places:
                data.qpos[chain[1:]] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_makeM(model, data)
            mujoco.mj_fullM(model, data, full)
            return np.sum([full[chain[:, None], chain] for chain in places], axis=0)

        super().__init__(at, 2, first=1)

    def nominal(self) -> Array:
        """Returns the inertia of each assisted joint with a bent elbow [kg·m²], shape (2,)."""
        matrix = self(np.array([BENT]))[0]
        return matrix[ASSISTED_PLACES, ASSISTED_PLACES]

    def momentum(self, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Returns the generalized momentum of the assisted joints, and its rate due to motion.

        Angles [rad] and rates [rad/s] of the four joints have the shape (n, 4), momentum [N·m·s]
        and rate [N·m] the shape (n, 2). The momentum p = M q' changes by the torques on the arm and
        by C'q', which is half the derivative of q'M q' with respect to the angle of the joint.
        """
        momentum = (self(angle)[:, ASSISTED_PLACES] * rate[:, None]).sum(-1)
        squares = (rate[:, :, None] * rate[:, None]).reshape(len(rate), -1)
        gyration = np.empty_like(momentum)
        for i, joint in enumerate(ASSISTED_PLACES):
            slope = self.slope(angle, joint).reshape(squares.shape)
            gyration[:, i] = (slope * squares).sum(-1) / 2
        return momentum, gyration


class CuffLevers(Trigonometric):
    """Motion of the three cuffs of an exoskeleton per angle of its joints.

    As a function of the four angles it gives motions per angle [m/rad] in the axes of the cuffs'
    sites, shape (n, 9, 4). The forces that sensors tell on the limb are in these axes; on the
    exoskeleton they act the other way, so that their torque on a joint is less the sum of the
    products.

    Args:
        model: Model of an arm with its exoskeleton on cuffs.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        # The motion due to a joint, in its frame, depends on the joints below alone.
        super().__init__(_levers(model), 1, first=1)


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
