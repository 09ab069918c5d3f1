"""The work envelope: statics against MuJoCo, closed forms, limits, and bad input."""

from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, load_suit
from activesuit.envs.envelope import SUSTAINED, Holding, work_envelope
from activesuit.envs.model import GRAVITY, ArmConfig, compose
from activesuit.errors import InputError
from helpers import without_volume_shares

COARSE = 0.05  # m
PROPORTIONAL = without_volume_shares(load_suit("emu-like"))
CONFIGS = {
    "right": ArmConfig(payload={"mass": 2}, tilt=(0.3, -0.2)),
    "left": ArmConfig(payload={"mass": 2}, tilt=(0.3, -0.2), side="left"),
    "small": ArmConfig(wearer={"sex": "female", "stature": 1.55, "mass": 50}),
}


def envelope(condition="suited", branch="loading", suit="emu-like", gravity="microgravity", **more):
    config = ArmConfig(suit=suit, gravity=gravity, **more)
    return work_envelope(config, condition, branch, spacing=COARSE)


def kept(one):
    """The cells that are held, as a set."""
    return set(map(tuple, one.cells[one.effort <= SUSTAINED].tolist()))


def postures(holding, count=40):
    low, high = holding.range.T
    return np.random.default_rng(3).uniform(low, high, (count, len(JOINTS)))


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_weight_and_position_are_those_of_the_engine(config):
    holding = Holding.of(config, "assisted", "loading")
    light = Holding.of(replace(config, gravity="microgravity"), "assisted", "loading")
    angle = postures(holding)
    model = compose(config)
    data, torque = mujoco.MjData(model), np.zeros(model.nv)
    joints = [model.joint(joint).id for joint in JOINTS]
    weight = holding.torques(angle) - light.torques(angle)
    for posture, place, expected in zip(angle, holding.positions(angle), weight, strict=True):
        data.qpos[model.jnt_qposadr[joints]] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_rne(model, data, 0, torque)
        assert torque[model.jnt_dofadr[joints]] == pytest.approx(expected, abs=1e-9)
        away = data.site("hand_grip").xpos - data.body("shoulder").xpos
        axes = data.body("torso").xmat.reshape(3, 3)
        assert away @ axes == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_the_suit_resists_as_its_models_do(branch):
    config = ArmConfig(suit="emu-like", gravity="microgravity")
    holding = Holding.of(config, "suited", branch)
    bare = replace(holding, resistance=np.zeros_like(holding.resistance))
    angle = postures(holding, 5)
    torque = holding.torques(angle) - bare.torques(angle)
    model = compose(config)
    for i, (joint, entry) in enumerate(load_suit("emu-like").joints.items()):
        ends = holding.range[i] if branch == "loading" else holding.range[i][::-1]
        assert joint == JOINTS[i]
        for posture, found in zip(angle[:, i], torque[:, i], strict=True):
            path = [entry.start_angle, *np.tile(ends[::-1], 9), ends[0], posture]
            passive = model.jnt_stiffness[model.joint(joint).id] * (
                posture - model.qpos_spring[model.joint(joint).qposadr[0]]
            )
            resists = entry.model.response(path, entry.start_torque)[-1]
            assert found == pytest.approx(resists + passive, abs=0.05)


def test_an_arm_of_free_hinges_reaches_a_ball_without_a_hole():
    holding = Holding.of(ArmConfig(suit="none", gravity="microgravity"), "unsuited", "loading")
    free = replace(holding, range=np.tile([-np.pi, np.pi], (4, 1)))
    reach, hole = free.reach, free.lengths[0] - free.lengths[1] - free.grip[0]
    assert hole < 0
    line = (np.arange(-12, 12) + 0.5) * reach / 12
    points = np.array(np.meshgrid(line, line, line)).reshape(3, -1).T.copy()
    effort, posture, _ = free.easiest(points, np.linspace(-np.pi, np.pi, 65))
    inside = np.isfinite(effort)
    assert (inside == (np.linalg.norm(points, axis=1) <= reach)).all()
    assert free.positions(posture)[inside] == pytest.approx(points[inside], abs=1e-9)
    volume = inside.sum() * (reach / 12) ** 3
    assert volume == pytest.approx(4 / 3 * np.pi * reach**3, rel=5e-3)


@pytest.mark.parametrize("side", ["right", "left"])
def test_no_posture_is_easier_than_the_one_found(side):
    config = ArmConfig(suit="mock-suit", gravity="moon", side=side)
    holding = Holding.of(config, "assisted", "unloading")
    angle = postures(holding)
    torque = holding.torques(angle)
    motor = np.clip(torque, -holding.motor, holding.motor)
    table = [np.linspace(*ends, holding.resistance.shape[1]) for ends in holding.range]
    for posture, left, place in zip(angle, torque - motor, holding.positions(angle), strict=True):
        strength = [
            np.interp(posture[i], table[i], holding.strength[int(left[i] > 0), i])
            for i in range(len(JOINTS))
        ]
        own = max(left / strength)
        effort, found, examined = holding.easiest(place[None], posture[3:])
        assert examined >= 1
        assert effort[0] <= own + 1e-9
        assert holding.positions(found)[0] == pytest.approx(place, abs=1e-9)


def test_without_suit_and_gravity_all_that_is_reached_can_be_kept():
    free = envelope("unsuited", suit="none")
    assert free.volume() == free.reachable > 800
    limp = envelope("suited", suit=PROPORTIONAL, pressure=0)
    assert limp.volume() == limp.reachable
    rubbing = envelope("suited", pressure=0)  # emu-like keeps its friction
    assert rubbing.volume() < 0.2 * rubbing.reachable


def test_weight_takes_from_what_can_be_kept():
    by_weight = sorted(GRAVITY, key=lambda place: -GRAVITY[place])
    found = [envelope("unsuited", suit="none", gravity=place) for place in by_weight]
    assert by_weight[0] == "earth"
    assert found[0].volume() < found[1].volume() < found[3].volume() == found[3].reachable
    assert all(one.reachable == found[0].reachable for one in found)
    loaded = envelope("unsuited", suit="none", gravity="earth", payload={"mass": 3})
    assert loaded.volume() < 0.5 * found[0].volume()


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_pressure_takes_from_what_can_be_kept(branch):
    volumes = [
        envelope("suited", branch, PROPORTIONAL, pressure=one).volume()
        for one in (0, 5, 15, 29.6, 56.5)
    ]
    assert all(more > less for more, less in pairwise(volumes))


def test_assistance_gives_back_up_to_what_motors_can():
    for branch in ("loading", "unloading"):
        suited, assisted, unlimited = (
            kept(envelope(one, branch)) for one in ("suited", "assisted", "unlimited")
        )
        assert suited < assisted < unlimited
    on_earth = (kept(envelope(one, gravity="earth")) for one in ("assisted", "unlimited"))
    assert next(on_earth) < next(on_earth)


def test_the_branches_differ():
    loading, unloading = (envelope("suited", one) for one in ("loading", "unloading"))
    assert kept(loading) - kept(unloading)
    assert kept(unloading) - kept(loading)
    assert loading.reachable == unloading.reachable


def test_measured_angles_are_those_of_the_suit_file():
    config = ArmConfig(suit="mock-suit", gravity="microgravity")
    suit = load_suit("mock-suit")
    whole = work_envelope(config, "assisted", spacing=COARSE)
    within = work_envelope(config, "assisted", spacing=COARSE, measured=True)
    ranges = np.array([suit.joints[joint].range for joint in JOINTS])
    assert within.reachable < whole.reachable / 4
    assert (within.posture >= ranges[:, 0]).all()
    assert (within.posture <= ranges[:, 1]).all()
    holding = Holding.of(config, "suited", "loading", measured=True)
    for i, joint in enumerate(("shoulder_abduction", "shoulder_flexion")):
        rising = suit.joints[joint].steady_cycle().rising
        assert holding.resistance[i] == pytest.approx(rising)
    bare = work_envelope(config, "unsuited", spacing=COARSE, measured=True)
    assert bare.volume() == bare.reachable > 800


def test_the_left_arm_mirrors_the_right():
    right, left = (envelope("assisted", gravity="earth", side=one) for one in ("right", "left"))
    mirrored = left.position * [1, -1, 1]
    order, other = np.lexsort(mirrored.T.round(4)), np.lexsort(right.position.T.round(4))
    assert mirrored[order] == pytest.approx(right.position[other])
    assert left.effort[order] == pytest.approx(right.effort[other])
    assert right.volume() > 0


def test_the_error_of_the_lattice_is_its_size():
    config = ArmConfig(suit="mock-suit")
    fine = work_envelope(config, "assisted", spacing=0.02)
    coarse = [work_envelope(config, "assisted", spacing=one) for one in (0.035, 0.04, 0.045, 0.05)]
    off = [(one.volume() - fine.volume()) / one.volume_error() for one in coarse]
    assert 0.05 < np.sqrt(np.mean(np.square(off))) < 2.5


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ({"condition": "assist"}, "unknown condition 'assist': use one of assisted, suited"),
        ({"branch": "up"}, "unknown branch 'up': use one of loading, unloading"),
        ({"spacing": 0.001}, "spacing is 0.001: use a number from 0.004 to 0.1 m"),
        ({"spacing": "fine"}, "spacing is 'fine': use a number from 0.004 to 0.1 m"),
        ({"measured": 1}, "measured is 1: use True or False"),
        ({"wrist_angles": 1}, "wrist_angles is 1: use at least 2"),
        ({"config": ArmConfig(coupling="cuffs")}, "coupling is 'cuffs': leave it 'rigid'"),
        ({"config": ArmConfig(suit="published-2022")}, "certificate margin is -0.245"),
    ],
)
def test_bad_input(mistake, message):
    with pytest.raises(InputError, match=r"^[^\n]+$") as error:
        work_envelope(**({"config": ArmConfig()} | mistake))
    assert message in str(error.value)
