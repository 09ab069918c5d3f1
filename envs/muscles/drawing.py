"""The muscles of an arm that moves: MyoArm is drawn beside the arm, colored by activation."""

from collections import deque
from itertools import pairwise

import mujoco
import numpy as np
from matplotlib import colormaps
from numpy.typing import ArrayLike

from ...arrays import Array
from ...assets import JOINTS
from ..evaluation.rollout import strength_left
from ..rendering import Capsule
from ..simulation.measurements import COLUMNS, TIME
from ..simulation.simulation import Simulation
from .analysis import CONVENTIONS, STANDARD, Moments, check_wearer, demand_of, share_among_muscles
from .myoarm import BODIES, CHEST, MyoArm

COLORS = "YlOrRd"
WIDTH = 0.0055  # [m], of a muscle at rest
SWELLING = 0.006  # [m], by which a fully active one is thicker
MOMENTS = 3  # fewest control periods that accelerations need
FORWARD_OUTWARD_UP = [0, 2, 1]  # columns of `MyoArm.trunk`
BESIDE = np.array([0.0, 0.55, 0.0])  # [m], MyoArm's shoulder from the wearer's shoulder
BONE, BONE_COLOR = 0.011, np.array([0.9, 0.87, 0.78, 1.0])  # [m], radius
SHOULDER, ELBOW = (JOINTS.index(name) for name in ("shoulder_flexion", "elbow_flexion"))
PULLEY = -2  # `wrap_obj` where the path of a tendon is interrupted


def color_of(active: ArrayLike) -> Array:
    """Returns the colors of muscles, shape (..., 4), from pale at 0 to dark red at 1."""
    return np.asarray(colormaps[COLORS](0.15 + 0.85 * np.asarray(active)))


def width_of(active: ArrayLike) -> Array:
    """Returns the radius with which each muscle is drawn [m]."""
    return WIDTH + SWELLING * np.asarray(active)


class LiveMuscles:
    """MyoArm's muscles on the first arm of a simulation.

    Call the object in each control period, since activation cannot change at once. Accelerations
    are those of the last two periods. MyoArm stands beside the wearer's arm, on the outer side, in
    the same posture, with an upper arm as long as the wearer's.
    """

    def __init__(self, simulation: Simulation) -> None:
        check_wearer(simulation)
        self._simulation, self._arm = simulation, MyoArm.load()
        self._data = mujoco.MjData(self._arm.model)
        self._tendons = [self._arm.model.actuator(name).trnid[0] for name in self._arm.muscles]
        self._upper_arm = float(np.linalg.norm(self._arm.places(np.zeros((1, 4)))[0, 1]))
        self._rows: deque[Array] = deque(maxlen=MOMENTS)
        self._activation: Array | None = None

    def __call__(self) -> list[Capsule]:
        """Returns the present bones and muscles; nothing before the third control period."""
        activation = self.activation()
        if activation is None:
            return []
        points, bones = self._placed()
        found = [Capsule(*ends, BONE, BONE_COLOR) for ends in pairwise(bones)]
        data, parts = self._data, self._data.wrap_obj.ravel()
        drawn = zip(self._tendons, width_of(activation), color_of(activation), strict=True)
        for tendon, radius, color in drawn:
            first = int(data.ten_wrapadr[tendon])
            for i in range(first, first + int(data.ten_wrapnum[tendon]) - 1):
                if PULLEY not in parts[i : i + 2]:
                    found.append(Capsule(points[i], points[i + 1], float(radius), color))
        return found

    def activation(self) -> Array | None:
        """Returns the present activations, shape (muscles,); None before the third period."""
        now = self._simulation.state.sensors.measured[0].copy()
        if now[TIME] == 0:
            self._rows.clear()
            self._activation = None
        elif not self._rows or now[TIME] > self._rows[-1][TIME]:
            self._rows.append(now)
            if len(self._rows) == MOMENTS:
                self._activation = self._shared()
        return self._activation

    def _shared(self) -> Array:
        """Returns the activations that give the torque of the last period."""
        measured = np.array(self._rows)
        names, state = ("angle", "rate", "human_torque", "effort"), self._simulation.state
        angle, rate, torque, effort = (measured[:, COLUMNS[name]] for name in names)
        strength = strength_left(state.muscles.strength[0], angle, None)
        worn = self._simulation.dressed(0)
        moments = Moments(measured[:, TIME], angle, rate, torque, effort, strength, None, worn)
        demand = demand_of(moments, self._arm, threads=1).last()
        convention = CONVENTIONS[STANDARD]
        found = share_among_muscles(self._arm, demand, convention, before=self._activation)
        return found.activation[0]

    def _placed(self) -> tuple[Array, Array]:
        """Returns the points of all tendons, and the ends of the bones, in the world [m]."""
        arm, data = self._arm, self._data
        angle = self._rows[-1][None, COLUMNS["angle"]]
        data.qpos[:] = arm.coupled @ arm.angles(angle)[0]
        mujoco.mj_kinematics(arm.model, data)
        mujoco.mj_comPos(arm.model, data)
        mujoco.mj_tendon(arm.model, data)
        bones = np.array([data.body(name).xpos for name in BODIES])
        axes = data.body(CHEST).xmat.reshape(3, 3) @ arm.trunk[:, FORWARD_OUTWARD_UP]
        wearer = self._simulation.arm_of(int(self._simulation.state.conditions.wearer[0]))
        shoulder, elbow = wearer.levers[[SHOULDER, ELBOW]]
        axes = axes * (shoulder - elbow) / self._upper_arm
        points, ends = (
            wearer.from_shoulder((places - bones[0]) @ axes + BESIDE)
            for places in (data.wrap_xpos.reshape(-1, 3), bones)
        )
        return points, ends
