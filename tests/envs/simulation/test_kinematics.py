"""Intended motions, postures, places of the hand and the torques of both, against MuJoCo."""

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, bare_arm, compose
from activesuit.envs.person import Person
from activesuit.envs.simulation.inverse_dynamics import Chain, arm_torques
from activesuit.envs.simulation.kinematics import Arm, through_places
from activesuit.envs.tasks.motions import minimum_jerk, random_moves
from helpers import assert_refused


def test_minimum_jerk_has_its_known_peaks():
    s = np.linspace(0, 1, 100_001)
    position, rate, acceleration = minimum_jerk(s)
    assert (position[0], position[-1]) == (0, 1)
    assert rate.max() == pytest.approx(1.875)
    assert acceleration.max() == pytest.approx(10 / np.sqrt(3))
    np.testing.assert_allclose(np.gradient(position, s)[1:-1], rate[1:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(rate, s)[1:-1], acceleration[1:-1], atol=1e-4)


@pytest.mark.parametrize("seed", range(2))
def test_moves_stay_in_the_span_and_are_smooth(seed):
    dt = 0.01
    angle, rate, acceleration = random_moves(
        np.random.default_rng(seed), 0.5, 1.5, 1001, dt, (1.2, 2.4), (0.0, 0.5)
    )
    assert 0.5 <= angle.min() < angle.max() - 0.25 and angle.max() <= 1.5
    np.testing.assert_allclose(np.gradient(angle, dt), rate, atol=0.03)
    assert np.abs(np.diff(angle)).max() < 1.0 * 1.875 / 1.2 * dt * 1.01
    assert np.isfinite(acceleration).all()


@pytest.mark.parametrize(
    "options",
    [
        {"side": "left", "tilt": (0.4, -0.3)},
        {"wearer": {"sex": "female", "stature": 1.5, "mass": 48.0}, "gravity": "moon"},
    ],
)
def test_the_kernel_agrees_with_mujoco(options):
    arm = bare_arm(ArmConfig(**options))
    rng, data = np.random.default_rng(0), mujoco.MjData(arm)
    low, high = arm.jnt_range.T
    angle = rng.uniform(low + 0.01, high - 0.01, (200, 4))
    rate, acceleration = rng.uniform(-6, 6, (200, 4)), rng.uniform(-60, 60, (200, 4))
    expected = np.empty((200, 4))
    for i in range(200):
        data.qpos[:], data.qvel[:], data.qacc[:] = angle[i], rate[i], acceleration[i]
        mujoco.mj_inverse(arm, data)
        expected[i] = data.qfrc_inverse
    found = arm_torques(Chain.of(arm), angle, rate, acceleration)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-11)
    assert np.abs(expected).max() > 5


ARMS = {
    "tilted": {"tilt": (0.5, -0.2)},
    "left, tilted, small": {
        "side": "left",
        "tilt": (-0.3, 0.4),
        "wearer": Person(sex="female", stature=1.52, mass=50.0),
    },
}
START = np.array([0.1, 0.6, 1.2, 0.0])


@pytest.fixture(params=ARMS.values(), ids=ARMS)
def made(request):
    """The bare arm of a configuration, and its whole model."""
    config = ArmConfig(**request.param)
    model = compose(config, drawn=False)
    return Arm.of(bare_arm(config), model.site("hand_grip").pos), model


def angles(model, count=20):
    low, high = model.jnt_range[:4].T
    return np.random.default_rng(2).uniform(low, high, (count, 4))


def in_mujoco(model, posture):
    data = mujoco.MjData(model)
    data.qpos[:4] = posture
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def to_torso(model, data, vector):
    """Turns a vector of the world into forward, outward and up."""
    outward = np.sign(model.body("shoulder").pos[1])
    return (vector @ data.body("torso").xmat.reshape(3, 3)) * [1, outward, 1]


def test_places_are_those_of_mujoco(made):
    arm, model = made
    postures = angles(model)
    places, world = arm.places(postures), arm.in_world(postures)
    for posture, place, there in zip(postures, places, world, strict=True):
        data = in_mujoco(model, posture)
        hand, shoulder = data.site("hand_grip").xpos, data.body("shoulder").xpos
        np.testing.assert_allclose(there, hand, atol=1e-12)
        np.testing.assert_allclose(place, to_torso(model, data, hand - shoulder), atol=1e-12)
    straight = in_mujoco(model, np.zeros(4))
    down = to_torso(model, straight, model.opt.gravity)
    np.testing.assert_allclose(arm.gravity, down, atol=1e-12)
    reach = straight.site("hand_grip").xpos - straight.body("shoulder").xpos
    assert arm.length == pytest.approx(np.linalg.norm(reach), rel=1e-12)


def test_forces_are_withstood_by_minus_their_jacobian(made):
    arm, model = made
    postures = angles(model)
    forces = np.random.default_rng(3).normal(0, 30, (len(postures), 3))
    outward = np.sign(model.body("shoulder").pos[1])
    torques = arm.torque_of(postures, forces)
    for posture, force, torque in zip(postures, forces, torques, strict=True):
        data, jacobian = in_mujoco(model, posture), np.zeros((3, model.nv))
        hand = model.site("hand_grip")
        mujoco.mj_jacSite(model, data, jacobian, None, hand.id)
        turned = data.body("torso").xmat.reshape(3, 3) @ (force * [1, outward, 1])
        np.testing.assert_allclose(torque, -jacobian.T[:4] @ turned, rtol=1e-9, atol=1e-10)


def test_postures_are_the_inverse_of_places(made):
    arm, _ = made
    phase = np.linspace(0, 2 * np.pi, 60)
    circle = np.stack([0.05 * np.sin(phase), 0.05 * np.cos(phase), 0.1 * np.sin(phase)], axis=1)
    wanted = arm.places(START[None]) + circle * arm.length
    found = arm.postures(wanted, START)
    np.testing.assert_allclose(arm.places(found), wanted, atol=1e-8)
    np.testing.assert_array_equal(found[:, 3], START[3])  # the wrist keeps its angle
    assert np.abs(np.diff(found, axis=0)).max() < 0.2  # no posture jumps to another one
    # The own place of a posture needs no correction.
    np.testing.assert_array_equal(arm.postures(arm.places(START[None]), START)[0], START)


def test_a_motion_through_places_has_the_derivatives_of_its_angles(made):
    arm, _ = made
    dt, share = 0.01, np.linspace(0, 1, 101)
    along = share**3 * (10 - 15 * share + 6 * share**2)
    path = arm.places(START[None]) + np.outer(along, [0.1] * 3)
    angle, rate, acceleration = through_places(arm, path, START, dt)
    np.testing.assert_allclose(arm.places(angle), path, atol=1e-8)
    inside = slice(2, -2)
    np.testing.assert_allclose(np.gradient(angle, dt, axis=0)[inside], rate[inside], atol=5e-3)
    slope = np.gradient(rate, dt, axis=0)
    np.testing.assert_allclose(slope[inside], acceleration[inside], atol=0.05)
    assert np.abs(rate).max() > 0.1


def test_what_no_posture_reaches_is_refused():
    model = compose(ArmConfig(), drawn=False)
    arm = Arm.of(bare_arm(ArmConfig()), model.site("hand_grip").pos)
    far = np.array([[1.2, 0.0, 0.0]])
    behind, near = arm.places(np.array([[0.0, -2.4, 0.3, 0.0]])), np.array([0.0, -2.2, 0.4, 0.0])
    rows = [
        (far, START, r"\[1\.2, 0\.0, 0\.0\] m .* is out of reach: stay"),
        # Behind the back is near enough, but the shoulder does not extend so far.
        (behind, near, r"the places take \w+ from .* rad: stay between"),
    ]
    assert_refused(arm.postures, rows)
