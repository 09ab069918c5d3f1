"""The torques that hold an arm in a posture, and the strength of the wearer beside them."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import mujoco
import numpy as np

from ...arrays import Array
from ...assets import JOINTS, load_suit
from ...errors import InputError
from ...hysteresis import steady_cycle
from ..model import ASSISTED, ArmConfig, Exo, compose, resisting_joints
from ..model.config import NO_SUIT
from ..person import isometric_strength, strength_limits
from .kernels import Statics, easiest_postures, holding_torque

Condition = Literal["unsuited", "suited", "assisted", "unlimited"]
Branch = Literal["loading", "unloading"]
SAMPLES = 201  # angles of a joint at which its torques are tabulated, as many as a steady cycle has


@dataclass(frozen=True, eq=False, kw_only=True)
class Holding:
    """An arm at rest; positions are in the frame of the torso.

    Attributes:
        range: Range of every joint [rad], shape (4, 2).
        resistance: Torque that keeps each joint in place without gravity, of suit and relaxed
            arm, at equal distances over its range [N·m], shape (4, 201).
        strength: Least and greatest torque that the wearer can give at the same angles [N·m], shape
            (2, 4, 201).
        motor: Torque of each joint up to which a motor takes over [N·m], shape (4,).
        mass: Mass of each link with what it wears and carries [kg], shape (4,).
        center: Its center in the frame of the link [m], shape (4, 3).
        lengths: Lengths of the upper arm and of the forearm [m], shape (2,).
        grip: Distance of the grip from the wrist [m], and its direction with the wrist straight,
            from down towards forward [rad], shape (2,).
        gravity: Acceleration of free fall [m/s²], shape (3,).
        outward: 1 where abduction turns about the axis forward (left arm), -1 where backward.
    """

    range: Array
    resistance: Array
    strength: Array
    motor: Array
    mass: Array
    center: Array
    lengths: Array
    grip: Array
    gravity: Array
    outward: float

    @classmethod
    def of(
        cls, config: ArmConfig, condition: Condition, branch: Branch, *, measured: bool = False
    ) -> "Holding":
        """Returns the arm of a configuration under a condition, as `work_envelope` explains them.

        Raises:
            InputError: See `work_envelope`.
            PoleError: A steady cycle meets the pole of an uncertified model.
        """
        variant = _variant(config, condition)
        model = compose(variant, drawn=False)
        joints = [model.joint(joint).id for joint in JOINTS]
        span = model.jnt_range[joints]
        if measured and variant.suit != NO_SUIT:
            for name, entry in load_suit(variant.suit).joints.items():
                span[JOINTS.index(name)] = np.clip(entry.range, *span[JOINTS.index(name)])
        angle = np.linspace(span[:, 0], span[:, 1], SAMPLES)
        stiffness, rest = model.jnt_stiffness[joints], model.qpos_spring[model.jnt_qposadr[joints]]
        resistance = stiffness * (angle - rest)
        for name, entry in resisting_joints(variant).items():
            joint = JOINTS.index(name)
            low, high = span[joint]
            cycle = steady_cycle(
                entry.model,
                (low, high),
                start_angle=entry.start_angle,
                start_torque=entry.start_torque,
            )
            resistance[:, joint] += cycle.rising if branch == "loading" else cycle.falling
        strength = strength_limits(isometric_strength(variant.wearer), angle, np.zeros_like(angle))
        motor = np.zeros(len(JOINTS))
        if condition in ("assisted", "unlimited"):
            for joint, one in variant.exo.motors.items():
                motor[JOINTS.index(joint)] = one.continuous_torque
        if condition == "unlimited":
            motor[[JOINTS.index(joint) for joint in ASSISTED]] = np.inf
        return cls(
            range=span,
            resistance=np.ascontiguousarray(resistance.T),
            strength=np.ascontiguousarray(np.swapaxes(strength, 1, 2)),
            motor=motor,
            **_geometry(model, joints),
        )

    @property
    def reach(self) -> float:
        """Distance of the grip from the shoulder with the arm straight [m], which none exceeds."""
        return float(self.lengths.sum() + self.grip[0])

    def torques(self, angle: Array) -> Array:
        """Returns the torques that hold the arm still, without motors [N·m], shape (n, 4).

        Args:
            angle: Joint angles within their ranges [rad], shape (n, 4).
        """
        found = np.empty_like(angle)
        arm = self._statics
        for one, torque in zip(angle, found, strict=True):
            holding_torque(one, arm, torque)
        return found

    def positions(self, angle: Array) -> Array:
        """Returns the positions of the grip from the shoulder [m], shape (n, 3).

        Args:
            angle: Joint angles [rad], shape (n, 4).
        """
        direction = np.cumsum(angle[:, 1:], axis=1)
        direction[:, -1] += self.grip[1]
        length = np.append(self.lengths, self.grip[0])
        forward, down = np.sin(direction) @ length, np.cos(direction) @ length
        plane = self.outward * angle[:, 0]
        return np.stack([forward, down * np.sin(plane), -down * np.cos(plane)], axis=1)

    def easiest(self, position: Array, wrist: Array) -> tuple[Array, Array, int]:
        """Finds the postures that take the least share of strength at positions of the grip.

        Args:
            position: Positions from the shoulder [m], shape (n, 3).
            wrist: Angles of the wrist that are tried [rad], shape (w,).

        Returns:
            effort: Share of isometric strength that the posture takes, at the joint where it is
                largest; NaN where the hand cannot be [1], shape (n,).
            posture: The posture [rad], shape (n, 4).
            examined: How many postures were examined.
        """
        effort, posture = np.empty(len(position)), np.zeros((len(position), len(JOINTS)))
        scratch = np.empty((2, len(JOINTS)))
        examined = easiest_postures(position, wrist, self._statics, scratch, effort, posture)
        return effort, posture, examined

    @property
    def _statics(self) -> Statics:
        low, high = np.ascontiguousarray(self.range.T)
        return Statics(
            gravity=self.gravity,
            outward=self.outward,
            lengths=self.lengths,
            grip=self.grip,
            mass=self.mass,
            center=self.center,
            low=low,
            high=high,
            step=(high - low) / (SAMPLES - 1),
            resistance=self.resistance,
            weakest=self.strength[0],
            strongest=self.strength[1],
            motor=self.motor,
        )


def _variant(config: ArmConfig, condition: Condition) -> ArmConfig:
    if config.coupling != "rigid":
        raise InputError(
            f"coupling is {config.coupling!r}: leave it 'rigid'; the conditions say whether there "
            "is an exoskeleton"
        )
    if condition in ("assisted", "unlimited"):
        return replace(config, preconditioned=False)
    bare = replace(config, preconditioned=False, coupling="none", exo=Exo())
    return bare if condition == "suited" else replace(bare, suit=NO_SUIT, pressure=None)


def _geometry(model: mujoco.MjModel, joints: list[int]) -> dict[str, Any]:
    """Returns masses and lengths of the arm, with all bodies that a link carries put together."""
    data, links = mujoco.MjData(model), model.jnt_bodyid[joints]
    mujoco.mj_kinematics(model, data)  # the arm hangs straight down
    torso = data.xmat[model.body_parentid[links[0]]].reshape(3, 3)
    mass, center = np.zeros(len(links)), np.zeros((len(links), 3))
    for i, link in enumerate(links):
        parts = np.flatnonzero(model.body_weldid == link)
        mass[i] = model.body_mass[parts].sum()
        center[i] = model.body_mass[parts] @ (data.xipos[parts] - data.xpos[link]) / mass[i]
    grip = torso.T @ (data.site("hand_grip").xpos - data.xpos[links[3]])
    between = (data.xpos[links[1:]] - data.xpos[links[:-1]]) @ torso
    axes = data.xaxis[joints] @ torso
    flat = np.abs([*between[:, :2].ravel(), *between[0], grip[1], *(axes[1:] - [0, -1, 0]).ravel()])
    if flat.max() > 1e-9 or abs(abs(axes[0, 0]) - 1) > 1e-9:
        raise InputError("the arm is no chain in a plane that abduction turns: compose it anew")
    return {
        "mass": mass,
        "center": center @ torso,
        "lengths": -between[1:, 2],
        "grip": np.array([np.hypot(grip[0], grip[2]), np.arctan2(grip[0], -grip[2])]),
        "gravity": torso.T @ model.opt.gravity,
        "outward": float(axes[0, 0]),
    }
