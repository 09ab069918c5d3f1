"""Static optimization against SciPy, activation dynamics, and torque about axes of MyoArm."""

import math
from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.muscles.mapping import OWN, constraint_torques
from activesuit.envs.muscles.sharing import Cost, share
from activesuit.envs.simulation.inverse_dynamics import STIFFNESS, Chain, arm_torques
from scipy.optimize import LinearConstraint, minimize

MUSCLES, AXES, EQUAL = 12, 5, 3
RNG = np.random.default_rng(1)
LEVERS = RNG.normal(0, 20, (20, AXES, MUSCLES))
LEVERS[:, EQUAL:] = np.maximum(LEVERS[:, EQUAL:], 0)
TARGETS = np.einsum("nkm,nm->nk", LEVERS, RNG.uniform(0, 0.4, (20, MUSCLES)))
SOFT = 0.01
COSTS = {
    "squares": Cost(np.zeros(MUSCLES), 1.0, 0.0, SOFT),
    "cubes": Cost(np.zeros(MUSCLES), 0.05, 1.0, SOFT),
    "volume": Cost(RNG.uniform(0.2, 2, MUSCLES), 0.05, 0.0, SOFT),
}


def shared(
    cost, *, levers=LEVERS, wanted=TARGETS, least=0.0, dt=math.inf, equal=EQUAL, before=np.nan
):
    samples, _, muscles = levers.shape
    force, before = np.ones((samples, muscles)), np.broadcast_to(before, muscles).copy()
    return share(levers, force, wanted, equal, least, before, dt, cost)


def value(cost, a, reserve):
    muscle = cost.linear * a + cost.square * a**2 / 2 + cost.cubic * a**3 / 3
    return muscle.sum() + np.square(reserve).sum() / (2 * cost.softness)


@pytest.mark.parametrize("name", COSTS)
@pytest.mark.parametrize("least", [0.0, 0.05])
def test_scipy_finds_nothing_better(name, least):
    cost = COSTS[name]
    activation, reserve, missed = shared(cost, least=least)
    assert missed.max() < 1e-6
    for i in range(4):
        lever = np.hstack([LEVERS[i], np.eye(AXES)])
        found = minimize(
            lambda z: value(cost, z[:MUSCLES], z[MUSCLES:]),
            np.full(MUSCLES + AXES, 0.2),
            method="SLSQP",
            bounds=[(least, 1)] * MUSCLES + [(None, None)] * AXES,
            constraints=[
                LinearConstraint(lever[:EQUAL], TARGETS[i, :EQUAL], TARGETS[i, :EQUAL]),
                LinearConstraint(lever[EQUAL:], TARGETS[i, EQUAL:], np.inf),
            ],
            options={"maxiter": 2000, "ftol": 1e-14},
        )
        ours = value(cost, activation[i], reserve[i])
        assert ours <= found.fun + 1e-7
        assert ours == pytest.approx(found.fun, rel=1e-3)


def test_equations_hold_with_the_reserve():
    activation, reserve, _ = shared(COSTS["squares"])
    given = np.einsum("nkm,nm->nk", LEVERS, activation) + reserve - TARGETS
    assert np.abs(given[:, :EQUAL]).max() < 1e-6
    assert given[:, EQUAL:].min() > -1e-6
    assert given[:, EQUAL:].max() > 1  # more than was asked for, where that costs nothing
    assert np.abs(reserve).max() < 0.01 * np.abs(TARGETS).max()


def test_what_muscles_cannot_give_is_left_to_the_reserve():
    activation, reserve, missed = shared(COSTS["squares"], wanted=50 * TARGETS)
    assert activation.max() == 1 and missed.max() < 1e-6
    assert np.abs(reserve).max() > 100


def test_activation_takes_time():
    levers = np.repeat(LEVERS[:1], 12, axis=0)
    wanted = np.repeat(0.0 * TARGETS[:1], 12, axis=0)
    wanted[3:8] = 3 * TARGETS[0]
    free, late = (
        shared(COSTS["squares"], levers=levers, wanted=wanted, dt=dt)[0] for dt in (math.inf, 0.01)
    )
    assert np.abs(free[5] - free[7]).max() < 1e-6
    assert late[3].max() < free[3].max() and late[9].max() > free[9].max() + 0.02
    for before, now in pairwise(late):
        rate = 0.5 + 1.5 * before
        assert (now <= 1 - (1 - before) * np.exp(-0.01 / (0.01 * rate)) + 1e-12).all()
        assert (now >= before * np.exp(-0.01 * rate / 0.04) - 1e-12).all()


def test_a_motion_goes_on_from_the_activation_before():
    levers = np.repeat(LEVERS[:1], 12, axis=0)
    wanted = np.repeat(3 * TARGETS[:1], 12, axis=0)
    wanted[5:] = 0
    same = {"levers": levers, "wanted": wanted, "dt": 0.01}
    whole = shared(COSTS["squares"], **same)[0]
    same |= {"levers": levers[5:], "wanted": wanted[5:]}
    part = shared(COSTS["squares"], **same, before=whole[4])[0]
    np.testing.assert_allclose(part, whole[5:], atol=1e-6)
    assert shared(COSTS["squares"], **same)[0][0].max() < part[0].max() - 0.05


DRAWN = np.random.default_rng(2)
ANGLE = DRAWN.uniform([0.1, -0.4, 0.1, -0.7], [1.3, 2.0, 2.0, 0.7], (30, 4))
RATE, ACCELERATION = DRAWN.normal(size=(2, 30, 4))


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
