"""The drawn arm made to measure: the file is the default person's, and others get their own."""

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, SCENE
from activesuit.envs.model import ArmConfig, bare_arm, compose
from activesuit.envs.person import Person, isometric_strength, range_of_motion, segments

PEOPLE = {
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
    for field in ("jnt_range", "jnt_stiffness", "jnt_actfrcrange", "qpos_spring", "key_qpos"):
        wanted = getattr(drawn, field)
        np.testing.assert_allclose(getattr(fitted, field), wanted, atol=0.05, err_msg=field)
    for field in ("dof_armature", "dof_damping", "dof_frictionloss", "actuator_forcerange"):
        wanted = getattr(drawn, field)
        np.testing.assert_allclose(getattr(fitted, field), wanted, atol=0.05, err_msg=field)
    for field in ("actuator_armature", "actuator_damping"):
        np.testing.assert_array_equal(getattr(fitted, field), getattr(drawn, field), field)


@pytest.mark.parametrize("person", PEOPLE.values(), ids=PEOPLE)
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


@pytest.mark.parametrize("person", PEOPLE.values(), ids=PEOPLE)
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
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        visual = (model.geom_group == 2) & (model.geom_bodyid > 0)
        figures.append(data.geom_xpos[visual])
    np.testing.assert_allclose(figures[1], ratio * figures[0], atol=1e-9)


def test_without_a_suit_the_joints_move_as_far_as_the_persons():
    model = compose(ArmConfig(suit="none"))
    for joint in JOINTS:
        np.testing.assert_array_equal(model.joint(joint).range, range_of_motion(joint))
    names = {model.body(i).name for i in range(model.nbody)}
    assert not any(name.startswith("suit_") for name in names)
    assert model.nplugin == 0
