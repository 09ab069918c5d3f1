"""`ActiveSuit/MuscleElbow-v0`: an elbow in a suit with a motor, whose wearer is muscles.

MyoArm's upper arm hangs, its forearm is in the middle of its rotation, and its fingers are locked;
only the elbow turns. The wearer is computed muscle control (Thelen, Anderson and Delp 2003): in
each control period the acceleration that leads back to the intention is turned into torque, the
torque into activations of least sum of squares, and the activations into excitations. Antagonists
give the co-contraction `contraction`. Stiffness and damping that act without delay come from the
muscles' force-length-velocity curves alone, since feedback acts late.
"""

from collections import deque
from functools import lru_cache
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS, load_suit
from ...checks import number, within
from ...errors import InputError, unknown_name
from ...hysteresis.engine import attach
from ..model.config import GRAVITY, NO_SUIT, place_of
from ..tasks import TASKS
from .analysis import antagonists
from .myoarm import lean, myoarm_spec, quiet
from .sharing import Cost, share

JOINT, OURS = "elbow_flexion_r", "elbow_flexion"
DT, SUBSTEPS = 0.01, 5
PEAK = 25.0  # [N·m], peak torque of the motor, as of the elbow motor of `envs.model`
MOTOR_LAG = 1 / (2 * np.pi * 10)  # [s], lag of the motor, as in `envs.model`
STIFFNESS, DAMPING = 25.0, 10.0  # [1/s², 1/s], feedback of the wearer on acceleration; assumed
LATE = 5  # [control periods], delay of feedback: 50 ms, as a reflex through the cortex; assumed
MOST_CONTRACTION = 15.0  # N·m
USUAL_CONTRACTION = 3.0  # N·m, as that of the wearer's model
SOFTNESS = 1e-4  # N²·m²
CROSSING = 1e-3  # [m], least moment arm of a muscle of the elbow
EFFORT, ERROR, CHANGE = 0.1, 0.1, 0.25  # activation, rad, share of the peak: a half of the reward


class MuscleElbow(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """An elbow that muscles move in a suit, with a motor.

    The action is the motor's torque over its peak of 25 N·m, shape (1,). The observation has angle
    [rad], rate [rad/s], the motor's torque over its peak and the last action, shape (4,). The
    motion is that of `ActiveSuit/ElbowFlexion-v0`. The reward is 1 / (1 + (a / 0.1)² +
    (e / 0.1 rad)² + (d / 0.25)²) with the root mean square activation a of the elbow's muscles, the
    tracking error e and the change d of the action.

    Args:
        suit: Name of a suit or path of a suit file, or "none".
        gravity: Name of the place whose gravity acts.
        contraction: Least torque of the antagonists [N·m], 0 to 15.
        push: Torque of a push [N·m], for 0.1 s from 1 s on; 0 for none.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        *,
        suit: str = "mock-suit",
        gravity: str = "earth",
        contraction: float = USUAL_CONTRACTION,
        push: float = 0.0,
    ) -> None:
        place = place_of("gravity", gravity)
        if place not in GRAVITY:
            raise unknown_name("gravity", gravity, GRAVITY)
        within("contraction", contraction, 0, MOST_CONTRACTION, " N·m")
        self.contraction, self.push = contraction, number("push", push, "N·m")
        self.model = _elbow(suit, GRAVITY[place])
        self.data = mujoco.MjData(self.model)
        self.muscles = tuple(self.model.actuator(i).name for i in range(self.model.nu))
        self._cost = Cost(np.zeros(self.model.nu), 1.0, 0.0, SOFTNESS)
        self._crossing = np.abs(self._arms(0.9)[0]) > CROSSING
        self.action_space = Box(-1, 1, (1,), np.float32)
        self.observation_space = Box(-np.inf, np.inf, (4,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode, whose motion the seed chooses."""
        super().reset(seed=seed, options=options)
        task = TASKS["ElbowFlexion"]
        self._samples = round(task.duration / DT)
        motion = task.motion(self.np_random, self._samples, DT)
        self._intention = np.stack([part[:, JOINTS.index(OURS)] for part in motion], axis=1)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[0] = self._intention[0, 0]
        self._step, self._motor, self._action = 0, 0.0, 0.0
        self._seen: deque[tuple[float, float]] = deque([(0.0, 0.0)] * LATE, maxlen=LATE)
        mujoco.mj_forward(self.model, self.data)
        self.data.act[:] = self._wanted_activation(self._intention[0])[0]
        return self._observation(), self._info(0.0)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Moves the elbow for a control period of 10 ms."""
        given = float(np.clip(action, -1, 1)[0])
        change, self._action = given - self._action, given
        self._motor += (1 - np.exp(-DT / MOTOR_LAG)) * (PEAK * given - self._motor)
        self._step += 1
        now = self._intention[min(self._step, self._samples - 1)]
        activation, reserve = self._wanted_activation(now)
        self.data.ctrl[:] = self._excitation(activation)
        pushed = self.push if 1.0 <= self.data.time < 1.1 else 0.0
        self.data.qfrc_applied[0] = self._motor + pushed
        mujoco.mj_step(self.model, self.data, SUBSTEPS)
        mujoco.mj_forward(self.model, self.data)
        error = now[0] - self.data.qpos[0]
        self._seen.append((error, now[1] - self.data.qvel[0]))
        active = float(np.sqrt(np.mean(self.data.act[self._crossing] ** 2)))
        squares = (active / EFFORT) ** 2 + (error / ERROR) ** 2 + (change / CHANGE) ** 2
        truncated = self._step >= self._samples - 1
        return self._observation(), 1 / (1 + squares), False, truncated, self._info(reserve)

    def stiffness(self) -> float:
        """Returns the stiffness of the muscles at their present activation [N·m/rad]."""

        def torque(angle: float) -> float:
            arms, full, slack = self._arms(angle)
            return float(arms @ (full * self.data.act + slack))

        angle, step = float(self.data.qpos[0]), 1e-4
        return (torque(angle - step) - torque(angle + step)) / (2 * step)

    @property
    def inertia(self) -> float:
        """Inertia of forearm and hand about the elbow [kg·m²]."""
        found = np.zeros((1, 1))
        mujoco.mj_fullM(self.model, self.data, found)
        return float(found[0, 0])

    def _arms(self, angle: float, *, moving: bool = False) -> tuple[Array, Array, Array]:
        """Returns moment arms [m], force at full activation and passive force [N]."""
        data = mujoco.MjData(self.model)
        data.qpos[0] = angle
        mujoco.mj_fwdPosition(self.model, data)
        dense = np.zeros((self.model.nu, 1))
        mujoco.mju_sparse2dense(
            dense, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
        )
        forces = []
        for activation in (0.0, 1.0):
            data.act[:] = activation
            data.actuator_velocity[:] = dense[:, 0] * self.data.qvel[0] if moving else 0.0
            mujoco.mj_fwdActuation(self.model, data)
            forces.append(-data.actuator_force.copy())
        return -dense[:, 0], forces[1] - forces[0], forces[0]

    def _wanted_activation(self, now: Array) -> tuple[Array, float]:
        """Returns the activations that lead to the intention, and the reserve torque [N·m]."""
        error, slip = self._seen[0]
        acceleration = now[2] + STIFFNESS * error + DAMPING * slip
        known = self.data.qfrc_passive[0] + self._motor  # the wearer has learned both
        torque = self.inertia * acceleration + self.data.qfrc_bias[0] - known
        arms, full, slack = self._arms(float(self.data.qpos[0]), moving=True)
        wanted = np.array([[torque - arms @ slack, self.contraction]])
        against = antagonists(arms[None, None], wanted[:, :1])
        rows, free = np.concatenate([arms[None, None], against], axis=1), np.full(full.size, np.nan)
        activation, reserve, _ = share(rows, full[None], wanted, 1, 0.0, free, np.inf, self._cost)
        return activation[0], float(reserve[0, 0])

    def _excitation(self, activation: Array) -> Array:
        """Returns the excitations after which the muscles have given activations a period later."""
        now = self.data.act
        rate = 0.5 + 1.5 * now
        lag = np.where(activation > now, 0.01 * rate, 0.04 / rate)
        return np.clip(now + (activation - now) / (1 - np.exp(-DT / lag)), 0, 1)

    def _observation(self) -> NDArray[np.float32]:
        angle, rate = self.data.qpos[0], self.data.qvel[0]
        return np.array([angle, rate, self._motor / PEAK, self._action], np.float32)

    def _info(self, reserve: float) -> dict[str, Any]:
        target = self._intention[min(self._step, self._samples - 1), 0]
        return {
            "target_angle": float(target),
            "activation": dict(zip(self.muscles, self.data.act.tolist(), strict=True)),
            "human_torque": float(self.data.qfrc_actuator[0]),
            "assist_torque": self._motor,
            "reserve_torque": reserve,
        }


def _elbow(suit: str, gravity: float) -> mujoco.MjModel:
    """Compiles MyoArm's elbow in a suit."""
    spec = _locked().copy()
    spec.option.gravity, spec.option.timestep = [0, 0, -gravity], DT / SUBSTEPS
    if suit != NO_SUIT:
        worn = load_suit(suit)
        if OURS not in worn.joints:
            raise InputError(f"the suit {suit!r} has no joint {OURS!r}: choose another suit")
        with quiet():
            attach(spec, JOINT, worn.joints[OURS].model)
    return lean(spec)


@lru_cache(maxsize=1)
def _locked() -> mujoco.MjSpec:
    """Returns MyoArm with all joints locked but the elbow."""
    spec = myoarm_spec()
    for part in [*spec.equalities, *(joint for joint in spec.joints if joint.name != JOINT)]:
        spec.delete(part)
    return spec
