"""Torque about the axes that our arm does not have, against MuJoCo's forces between bodies."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.muscles.mapping import OWN, constraint_torques
from activesuit.envs.simulation.inverse_dynamics import STIFFNESS, Chain, arm_torques

RNG = np.random.default_rng(2)
ANGLE = RNG.uniform([0.1, -0.4, 0.1, -0.7], [1.3, 2.0, 2.0, 0.7], (30, 4))
RATE, ACCELERATION = RNG.normal(size=(2, 30, 4))


def dressed(**options):
    options = {"coupling": "none", "payload": {"mass": 2.0}, "tilt": (0.3, 0.2), **options}
    model = compose(ArmConfig(**options), drawn=False)
    chain = Chain.of(model, dressed=True)
    chain.links[..., STIFFNESS:] = 0
    return model, chain


def test_own_axes_have_the_torque_of_inverse_dynamics():
    _, chain = dressed()
    found, _ = constraint_torques(chain, ANGLE, RATE, ACCELERATION)
    assert found[:, OWN] == pytest.approx(arm_torques(chain, ANGLE, RATE, ACCELERATION), abs=1e-12)
    assert np.abs(found[:, [2, 4, 6]]).max(axis=0).min() > 0.05


def test_moments_are_those_between_the_bodies_of_the_engine():
    model, chain = dressed()
    data = mujoco.MjData(model)
    found, axes = constraint_torques(chain, ANGLE, RATE, ACCELERATION)
    joints = [model.joint(f"{name}_flexion").id for name in ("shoulder", "elbow", "wrist")]
    for i in range(len(ANGLE)):
        data.qpos[:4], data.qvel[:4] = ANGLE[i], RATE[i]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        data.qacc[:4] = ACCELERATION[i]
        mujoco.mj_rnePostConstraint(model, data)
        torso = data.body("torso").xmat.reshape(3, 3)
        for axis, joint in ((2, joints[0]), (4, joints[1]), (6, joints[2])):
            body = model.jnt_bodyid[joint]
            moment, force = data.cfrc_int[body, :3], data.cfrc_int[body, 3:]
            center = data.subtree_com[model.body_rootid[body]]
            at_joint = moment + np.cross(center - data.xanchor[joint], force)
            forward, up, right = axes[i, axis]
            direction = torso @ [forward, -right, up]
            assert found[i, axis] == pytest.approx(at_joint @ direction, abs=1e-9)


def test_a_left_arm_is_the_mirror_image():
    right, _ = constraint_torques(dressed(tilt=(0.3, 0.0))[1], ANGLE, RATE, ACCELERATION)
    mirrored = dressed(tilt=(0.3, 0.0), side="left")[1]
    left, _ = constraint_torques(mirrored, ANGLE, RATE, ACCELERATION)
    assert left == pytest.approx(right, abs=1e-12)


def test_where_the_arm_points_forward_the_humerus_has_the_torque_of_abduction():
    # There both turn about one axis: the third axis does not bring in a torque that contradicts it.
    _, chain = dressed(tilt=(0.0, 0.0))
    level = np.tile([0.0, np.pi / 2, 0.3, 0.0], (1, 1))
    aside = replace(chain, links=chain.links.copy())
    aside.links[0, 2, 8] += 0.05  # the center of the forearm is outside the plane
    found, axes = constraint_torques(aside, level, 0 * level, 0 * level)
    humerus = np.array([-1.0, 0.0, 0.0])
    about = sum(found[0, k] * (axes[0, k] @ humerus) for k in range(3))
    assert abs(found[0, 0]) > 0.3 and about == pytest.approx(found[0, 0])
