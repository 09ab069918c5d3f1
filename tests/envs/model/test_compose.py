"""Every configuration compiles, weighs what it must, wears its suit and survives noise."""

from itertools import product

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, SCENE, load_suit, suit_names
from activesuit.envs.model import GRAVITY, ArmConfig, arm_spec, bare_arm, compose
from activesuit.envs.model.compose import resisting_joints
from activesuit.envs.model.config import COUPLINGS, SIDES
from activesuit.envs.person import Person, isometric_strength, range_of_motion, segments
from arms import PEOPLE, posed
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
    data = posed(model, [0, np.pi / 2, *np.zeros(model.nq - 2)])
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
    upper_arm, forearm, hand = segments(person).values()
    elbow = 9.81 * (forearm.mass * forearm.center + hand.mass * (forearm.length + hand.center))
    below = (forearm.mass + hand.mass) * upper_arm.length
    shoulder = elbow + 9.81 * (upper_arm.mass * upper_arm.center + below)
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
        data = posed(model, [0, flexion, 0, 0])
        torque.append(data.qfrc_bias.copy())
        hips, torso = data.body("legs").xpos, data.body("torso").xpos
        assert np.linalg.norm(torso - hips) == pytest.approx(0.54)
        assert np.sign(torso[0] - hips[0]) == np.sign(tilt[0])
    np.testing.assert_allclose(torque[1], torque[0], atol=1e-9)


def test_a_suit_file_with_a_new_content_is_read_again(tmp_path):
    suit, path = load_suit("mock-suit"), tmp_path / "suit.json"
    suit.save(path)
    assert compose(ArmConfig(suit=path)).nplugin == len(suit.joints)
    elbow = {"elbow_flexion": suit.joints["elbow_flexion"]}
    suit.model_copy(update={"joints": elbow}).save(path)
    assert compose(ArmConfig(suit=path)).nplugin == 1


EMU = load_suit("emu-like")


@pytest.mark.parametrize("pressure", [40.0, 0.0])
def test_a_config_scales_the_suit_to_its_pressure(pressure):
    proportional = without_volume_shares(EMU)
    assert resisting_joints(ArmConfig(suit=proportional)) == proportional.joints
    for suit in (EMU, proportional):
        scaled = suit.at_pressure(pressure).joints
        data = posed(model := compose(ArmConfig(suit=suit, pressure=pressure)), 0.7)
        assert model.nplugin == len(scaled)
        for joint, entry in scaled.items():
            torque = -data.sensor(f"{joint}_suit_torque").data[0]
            assert torque == pytest.approx(entry.response([0.7])[0], abs=1e-12)
    used = ArmConfig(suit=proportional, pressure=pressure, preconditioned=True)
    assert resisting_joints(used) == proportional.at_pressure(pressure).preconditioned().joints


def test_the_pressure_of_the_papers_suit_is_not_known():
    assert_refused(compose, [(ArmConfig(pressure=40.0), "does not tell at which its torque")])


def test_a_preconditioned_suit_begins_in_its_steady_cycle():
    fresh, used = (ArmConfig(preconditioned=used) for used in (False, True))
    angles = [0.4, 0.6, 0.8, 0.3]
    data = posed(model := compose(used), angles)
    for joint, angle in zip(JOINTS, angles, strict=True):
        torque = -data.sensor(f"{joint}_suit_torque").data[0]
        entry = resisting_joints(used)[joint]
        assert torque == entry.response([angle])[0]
        loop = entry.steady_cycle()
        assert torque == pytest.approx(np.interp(angle, loop.angle, loop.rising), rel=1e-3)
        assert abs(torque - resisting_joints(fresh)[joint].response([angle])[0]) > 0.05
    mujoco.mj_resetData(model, data)
    assert compose(fresh).npluginstate == model.npluginstate


FIGURES = {
    "small": Person.percentile("female", 5),
    "long and thin": Person(stature=2.1, mass=60.0),
    "short and strong": Person(stature=1.4, mass=90.0, sex="female", strength=95.0),
}
PREVIOUS = {"forearm": "upper_arm", "hand": "forearm"}


def test_the_file_is_the_default_configuration_to_its_printed_digits():
    drawn, fitted = mujoco.MjModel.from_xml_path(str(SCENE)), compose(ArmConfig())
    names = [fitted.body(i).name for i in range(fitted.nbody)]
    rows = [drawn.body(name).id for name in names]
    for field, digits in (("pos", 4), ("ipos", 4), ("mass", 3), ("inertia", 5)):
        values = [getattr(model, f"body_{field}") for model in (drawn, fitted)]
        np.testing.assert_allclose(values[1], values[0][rows], atol=0.5 * 10**-digits, rtol=1e-9)
    joints = ("jnt_range", "jnt_stiffness", "jnt_actfrcrange", "qpos_spring", "key_qpos")
    motors = ("dof_armature", "dof_damping", "dof_frictionloss", "actuator_forcerange")
    for field in (*joints, *motors):
        wanted = getattr(drawn, field)
        np.testing.assert_allclose(getattr(fitted, field), wanted, atol=0.05, err_msg=field)
    for field in ("actuator_armature", "actuator_damping"):
        np.testing.assert_array_equal(getattr(fitted, field), getattr(drawn, field), field)


@pytest.mark.parametrize("person", FIGURES.values(), ids=FIGURES)
@pytest.mark.parametrize("model_of", [bare_arm, compose])
def test_segments_are_the_persons(person, model_of):
    model = model_of(ArmConfig(wearer=person))
    own = segments(person)
    for name, segment in own.items():
        body = model.body(name)
        assert body.mass[0] == segment.mass
        np.testing.assert_array_equal(body.ipos, [0, 0, -segment.center])
        np.testing.assert_allclose(sorted(body.inertia), sorted(segment.inertia), rtol=1e-9)
        if name in PREVIOUS:
            np.testing.assert_array_equal(body.pos, [0, 0, -own[PREVIOUS[name]].length])


@pytest.mark.parametrize("person", FIGURES.values(), ids=FIGURES)
def test_limits_are_wearer_and_motor(person):
    config = ArmConfig(wearer=person)
    model = compose(config)
    low, high = isometric_strength(person)
    for joint, limits in zip(JOINTS, zip(-low, high, strict=True), strict=True):
        motor = config.exo.motors.get(joint)
        peak = motor.peak_torque if motor else 0.0
        np.testing.assert_allclose(model.actuator(f"human_{joint}").forcerange, limits)
        both = [limits[0] - peak, limits[1] + peak]
        np.testing.assert_allclose(model.jnt_actfrcrange[model.joint(joint).id], both)


def test_parts_stay_on_the_limbs_of_a_person_with_other_proportions():
    # A woman's forearm is shorter for her stature than that of the man who is drawn.
    person = Person(stature=1.78, mass=80.0, sex="female")
    ratio = segments(person)["forearm"].length / segments(Person())["forearm"].length
    assert ratio < 0.99
    drawn, fitted = compose(ArmConfig()), compose(ArmConfig(wearer=person))
    expected = drawn.site("cuff_forearm").pos * [1, 1, ratio]
    np.testing.assert_allclose(fitted.site("cuff_forearm").pos, expected, atol=1e-12)
    # The motor of the elbow is on the link of the upper arm, at the axis that it turns.
    at_elbow = fitted.site("motor_elbow").pos[2]
    assert at_elbow == pytest.approx(fitted.body("forearm").pos[2], abs=1e-4)
    link = [model.geom("exo_forearm_link").size for model in (drawn, fitted)]
    np.testing.assert_allclose(link[1], link[0] * [1, 1, ratio], atol=1e-12)
    assert fitted.body("exo_forearm").mass == drawn.body("exo_forearm").mass


def test_a_similar_person_gets_a_similar_figure():
    # Same sex: all lengths have one ratio; the suit's masses that of its area.
    ratio = 1.2 / 1.0
    drawn = compose(ArmConfig(wearer=Person(stature=1.5)))
    larger = compose(ArmConfig(wearer=Person(stature=1.5 * ratio)))
    for name in ("torso", "shoulder", "forearm", "exo_base"):
        np.testing.assert_allclose(larger.body(name).pos, ratio * drawn.body(name).pos, atol=1e-12)
    for name in ("suit_upper_arm", "suit_forearm", "suit_hand"):
        a, b = drawn.body(name), larger.body(name)
        np.testing.assert_allclose(b.mass, ratio**2 * a.mass)
        np.testing.assert_allclose(b.inertia, ratio**4 * a.inertia)
    figures = []
    for model in (drawn, larger):
        visual = (model.geom_group == 2) & (model.geom_bodyid > 0)
        figures.append(posed(model).geom_xpos[visual])
    np.testing.assert_allclose(figures[1], ratio * figures[0], atol=1e-9)


def test_without_a_suit_the_joints_move_as_far_as_the_persons():
    model = compose(ArmConfig(suit="none"))
    for joint in JOINTS:
        np.testing.assert_array_equal(model.joint(joint).range, range_of_motion(joint))
    names = {model.body(i).name for i in range(model.nbody)}
    assert not any(name.startswith("suit_") for name in names)
    assert model.nplugin == 0
