"""Every configuration compiles, weighs what it must, wears its suit and survives noise."""

from itertools import product

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, Suit, load_suit, save_suit, suit_names
from activesuit.envs.model import GRAVITY, ArmConfig, arm_spec, bare_arm, compose
from activesuit.envs.model.compose import resisting_joints
from activesuit.envs.model.config import COUPLINGS, SIDES
from activesuit.envs.person import segments
from arms import PEOPLE
from helpers import assert_refused, without_volume_shares
from scipy.stats import qmc

FEW = [
    {},
    {"coupling": "cuffs", "side": "left", "gravity": "mars", "wearer": PEOPLE[1]},
    {"coupling": "none", "suit": "none", "wearer": PEOPLE[3]},
    {"gravity": "microgravity", "payload": {"mass": 20.0}, "wearer": PEOPLE[2]},
    {"coupling": "cuffs", "misalignment": (0.02, -0.02, 0.02), "tilt": (0.7, -0.2)},
    {"suit": "none", "gravity": "moon", "payload": {"mass": 5.0}, "side": "left"},
    {"suit": "published-2022", "exo": {"encoder_delay": 0.006}},
]
# Each suit with each coupling; gravities, sides and persons take turns.
MODELS = [
    {
        **{"suit": suit, "coupling": coupling, "wearer": PEOPLE[i % len(PEOPLE)]},
        **{"gravity": list(GRAVITY)[i % len(GRAVITY)], "side": SIDES[i % 2]},
    }
    for i, (suit, coupling) in enumerate(product([*suit_names(), "none"], COUPLINGS))
]
# Of models that break at four or eight times their step all do within 0.4 s; at sixteen times some
# take up to 10 s.
NOISES = 50  # number of noise periods, 0.1 s each
CASES = [*FEW, *(pytest.param(fields, marks=pytest.mark.slow) for fields in MODELS)]


def config_of(fields):
    return ArmConfig(allow_uncertified=True, **fields)


@pytest.mark.parametrize("fields", CASES, ids=range(len(CASES)))
def test_every_model_compiles_holds_its_keyframes_and_survives_noise(fields):
    model = compose(config_of(fields))
    assert model.nkey == 2
    for i in range(model.nkey):
        assert (model.jnt_range[:, 0] <= model.key_qpos[i]).all()
        assert (model.key_qpos[i] <= model.jnt_range[:, 1]).all()
    home = model.key("home")
    for joint in JOINTS:
        start = model.actuator_ctrladr[model.actuator(f"human_{joint}").id]
        assert home.ctrl[start] == home.qpos[model.joint(joint).qposadr[0]]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    low, high = control_limits(model)
    halton = qmc.Halton(model.nu, rng=np.random.default_rng(0)).random(NOISES)
    for noise in low + halton * (high - low):
        data.ctrl[:] = noise
        mujoco.mj_step(model, data, round(0.1 / model.opt.timestep))
    assert data.time == pytest.approx(0.1 * NOISES)
    assert not data.warning.number.any() and np.isfinite(data.qpos).all()
    over = np.maximum(model.jnt_range[:, 0] - data.qpos, data.qpos - model.jnt_range[:, 1])
    assert over.max() < 0.3


def control_limits(model):
    """Joint range, 6 rad/s and full torque for the wearer; full torque for the motors."""
    limits = []
    for i in range(model.nactuator):
        name = model.actuator(i).name
        if name.startswith("human_"):
            limits += [model.joint(name.removeprefix("human_")).range, (-6, 6)]
        limits.append(model.actuator_forcerange[i])
    return np.array(limits).T


def gravity_torque(model, joints=("shoulder_flexion", "elbow_flexion")):
    """Gravity torque of the horizontal arm [N·m]."""
    data = mujoco.MjData(model)
    data.joint("shoulder_flexion").qpos[0] = np.pi / 2
    mujoco.mj_forward(model, data)
    return [data.joint(joint).qfrc_bias[0] for joint in joints]


def test_gravity_torque_of_the_bare_arm():
    # de Leva 1996, 1.78 m, 80 kg: closed form, worked by hand.
    table = {"earth": [11.82, 3.25], "mars": [4.47, 1.23], "moon": [1.95, 0.54]}
    for gravity, wanted in {**table, "microgravity": [0, 0]}.items():
        for side in SIDES:
            torque = gravity_torque(bare_arm(ArmConfig(gravity=gravity, side=side)))
            np.testing.assert_allclose(torque, wanted, atol=0.005)


@pytest.mark.parametrize("person", PEOPLE[1:3])
def test_an_arm_without_suit_and_exoskeleton_weighs_what_the_bare_arm_does(person):
    config = ArmConfig(suit="none", coupling="none", wearer=person)
    arm = segments(person)
    elbow = 9.81 * (
        arm["forearm"].mass * arm["forearm"].center
        + arm["hand"].mass * (arm["forearm"].length + arm["hand"].center)
    )
    shoulder = elbow + 9.81 * (
        arm["upper_arm"].mass * arm["upper_arm"].center
        + (arm["forearm"].mass + arm["hand"].mass) * arm["upper_arm"].length
    )
    for model in (compose(config), bare_arm(config)):
        np.testing.assert_allclose(gravity_torque(model), [shoulder, elbow], rtol=1e-12)


@pytest.mark.parametrize("fields", FEW[1:4], ids=range(3))
def test_a_saved_specification_is_the_same_model(fields):
    spec = arm_spec(config_of(fields))
    model = spec.compile()
    again = mujoco.MjModel.from_xml_string(spec.to_xml())
    for name in ("body_mass", "body_inertia", "dof_M0", "actuator_forcerange", "jnt_range"):
        np.testing.assert_allclose(getattr(again, name), getattr(model, name), rtol=1e-4)
    np.testing.assert_allclose(gravity_torque(again), gravity_torque(model), rtol=1e-4)


@pytest.mark.parametrize("gravity", ["microgravity", "moon"])
def test_in_microgravity_feet_are_restrained_and_elsewhere_there_is_a_floor(gravity):
    model = compose(ArmConfig(gravity=gravity))
    bodies = {model.body(i).name for i in range(model.nbody)}
    geoms = {model.geom(i).name for i in range(model.ngeom)}
    assert ("foot_restraint" in bodies, "floor" in geoms) == (gravity != "moon", gravity == "moon")


@pytest.mark.parametrize("pitch", [-0.3, np.pi / 2])
def test_a_leaning_torso_turns_the_arm_in_the_gravity_field(pitch):
    # A horizontal arm of the upright wearer is at flexion 90 degrees plus the pitch.
    torque = []
    for tilt, flexion in (((0.0, 0.0), np.pi / 2), ((pitch, 0.0), np.pi / 2 + pitch)):
        model = bare_arm(ArmConfig(tilt=tilt))
        data = mujoco.MjData(model)
        data.joint("shoulder_flexion").qpos[0] = flexion
        mujoco.mj_forward(model, data)
        torque.append(data.qfrc_bias.copy())
        hips, torso = data.body("legs").xpos, data.body("torso").xpos
        assert np.linalg.norm(torso - hips) == pytest.approx(0.54)
        assert np.sign(torso[0] - hips[0]) == np.sign(tilt[0])
    np.testing.assert_allclose(torque[1], torque[0], atol=1e-9)


def test_a_suit_file_with_a_new_content_is_read_again(tmp_path):
    suit, path = load_suit("mock-suit"), tmp_path / "suit.json"
    save_suit(suit, path)
    assert compose(ArmConfig(suit=path)).nplugin == len(suit.joints)
    elbow = {"elbow_flexion": suit.joints["elbow_flexion"]}
    save_suit(suit.model_copy(update={"joints": elbow}), path)
    assert compose(ArmConfig(suit=path)).nplugin == 1


PROPORTIONAL = without_volume_shares(load_suit("emu-like"))


@pytest.mark.parametrize("pressure", [40.0, 0.0])
def test_a_config_scales_the_suit_to_its_pressure(pressure):
    scaled = resisting_joints(ArmConfig(suit=PROPORTIONAL, pressure=pressure))
    assert resisting_joints(ArmConfig(suit=PROPORTIONAL)) == PROPORTIONAL.joints
    assert scaled == PROPORTIONAL.at_pressure(pressure).joints
    assert compose(ArmConfig(suit=PROPORTIONAL, pressure=pressure)).nplugin == len(scaled)
    used = ArmConfig(suit=PROPORTIONAL, pressure=pressure, preconditioned=True)
    assert resisting_joints(used) == PROPORTIONAL.at_pressure(pressure).preconditioned().joints


def test_the_pressure_of_the_papers_suit_is_not_known():
    assert_refused(compose, [(ArmConfig(pressure=40.0), "does not tell at which its torque")])


def test_a_preconditioned_suit_begins_in_its_steady_cycle():
    fresh, used = (ArmConfig(preconditioned=used) for used in (False, True))
    data = mujoco.MjData(model := compose(used))
    data.qpos[:] = angles = [0.4, 0.6, 0.8, 0.3]
    mujoco.mj_forward(model, data)
    for joint, angle in zip(JOINTS, angles, strict=True):
        torque = -data.sensor(f"{joint}_suit_torque").data[0]
        entry = resisting_joints(used)[joint]
        assert torque == entry.response([angle])[0]
        loop = entry.steady_cycle()
        assert torque == pytest.approx(np.interp(angle, loop.angle, loop.rising), rel=1e-3)
        assert abs(torque - resisting_joints(fresh)[joint].response([angle])[0]) > 0.05
    mujoco.mj_resetData(model, data)
    assert compose(fresh).npluginstate == model.npluginstate


def test_a_volume_share_reaches_the_physics():
    elbow = load_suit("emu-like").joints["elbow_flexion"]
    gas = elbow.model_copy(update={"volume_share": 0.8})
    suit = Suit(name="s", description="", pressure_kpa=29.6, joints={"elbow_flexion": gas})
    for pressure in (0.0, 40.0):
        model = compose(ArmConfig(suit=suit, pressure=pressure))
        data = mujoco.MjData(model)
        data.qpos[2] = 1.3
        mujoco.mj_forward(model, data)
        expected = suit.at_pressure(pressure).joints["elbow_flexion"].response([1.3])[0]
        torque = -data.sensor("elbow_flexion_suit_torque").data[0]
        assert torque == pytest.approx(expected, abs=1e-12)
        assert (torque > elbow.response([1.3])[0]) == (pressure > 29.6)
