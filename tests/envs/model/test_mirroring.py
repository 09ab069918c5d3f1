"""The left arm moves, weighs and looks like the right arm's mirror image."""

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, compose, mirror
from activesuit.envs.person import Person
from arms import mass_matrix, posed

CONFIGS = {
    "cuffs": {"coupling": "cuffs", "misalignment": (0.01, 0.02, -0.015)},
    "none": {"coupling": "none", "suit": "none"},
    "loaded": {"payload": {"mass": 3.0, "inertia": (0.01, 0.02, 0.015)}, "tilt": (0.4, 0.0)},
    "small": {"wearer": Person.percentile("female", 5)},
}
POLAR = np.array([1.0, -1.0, 1.0])


def pair(fields):
    return [compose(ArmConfig(side=side, **fields)) for side in ("right", "left")]


def state(model, rng):
    data = mujoco.MjData(model)
    low, high = np.maximum(model.jnt_range[:, 0], 0.0), np.minimum(model.jnt_range[:, 1], 1.2)
    data.qpos[:] = rng.uniform(low, high)
    data.qvel[:] = rng.normal(0, 1, model.nv)
    data.ctrl[:] = rng.uniform(-1, 1, model.nu)
    mujoco.mj_forward(model, data)
    return data


def readings(model, data):
    """By sensor, but for forces and torques of cuffs, components of which change their sign."""
    names = [model.sensor(i).name for i in range(model.nsensor)]
    kept = (name for name in names if not name.startswith("cuff_") or name.endswith("energy"))
    return {name: data.sensor(name).data.copy() for name in kept}


@pytest.mark.parametrize("fields", CONFIGS.values(), ids=CONFIGS)
def test_the_dynamics_are_identical(fields):
    right, left = pair(fields)
    for seed in range(5):
        one, other = (state(model, np.random.default_rng(seed)) for model in (right, left))
        inertia = [mass_matrix(right, one), mass_matrix(left, other)]
        np.testing.assert_allclose(inertia[1], inertia[0], rtol=1e-12, atol=1e-14)
        for name in ("qfrc_bias", "qfrc_passive", "qfrc_actuator", "qacc", "sensordata"):
            values = [getattr(data, name).copy() for data in (one, other)]
            if name == "sensordata":
                values = [readings(model, data) for model, data in ((right, one), (left, other))]
                values[1]["hand_position"] *= POLAR
                values = [np.concatenate(list(value.values())) for value in values]
            np.testing.assert_allclose(values[1], values[0], rtol=1e-9, atol=1e-9, err_msg=name)
        for i in range(right.nbody):
            name = right.body(i).name
            places = other.body(name).xipos, one.body(name).xipos * POLAR
            np.testing.assert_allclose(*places, atol=1e-12, err_msg=name)


def test_roll_leans_to_the_same_side_for_both_arms():
    right, left = pair({"tilt": (0.0, 0.3)})
    heads = [posed(model).body("torso").xpos for model in (right, left)]
    np.testing.assert_allclose(heads[0], heads[1], atol=1e-12)
    assert heads[0][1] < -0.1  # the wearer's right


def both_sides(xml):
    spec = mujoco.MjSpec.from_string(xml)
    right = spec.copy().compile()
    mirror(spec)
    return right, spec.compile()


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("quat", "0.8 0.3 -0.2 0.4"),
        ("euler", "0.3 -0.5 0.7"),
        ("axisangle", "0.3 0.4 0.5 0.9"),
        ("zaxis", "0.3 0.4 0.5"),
        ("xyaxes", "0.9 0.3 0.1 -0.2 0.7 0.3"),
    ],
)
def test_every_way_to_give_an_orientation_is_reflected(kind, words):
    xml = f"""<mujoco><compiler angle="radian"/><worldbody><body {kind}="{words}">
      <joint axis=".2 .3 .9"/><geom type="box" size=".1 .2 .3" pos=".1 .2 .3"/>
      </body></worldbody></mujoco>"""
    models = both_sides(xml)
    corners = []
    for model in models:
        data = posed(model, 0.6)
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        box = data.geom_xpos[0] + (signs * model.geom_size[0]) @ data.geom_xmat[0].reshape(3, 3).T
        corners.append({tuple(np.round(corner, 9) + 0.0) for corner in box})
    assert corners[1] == {(x, -y + 0.0, z) for x, y, z in corners[0]}


def test_frames_slides_and_turned_inertias_are_reflected():
    xml = """<mujoco><compiler angle="radian"/><worldbody><frame pos="0 .3 0" euler=".2 .1 .3">
      <body pos=".1 .2 .3"><joint axis=".1 1 .2" type="slide"/><joint axis="0 1 .2"/>
      <inertial pos="0 .1 0" mass="1" diaginertia=".1 .12 .15" euler=".3 .2 .1"/>
      <frame pos="0 .1 0" zaxis="1 2 3"><body pos=".1 .1 .1"><joint axis="1 0 .3"/>
      <geom type="box" size=".1 .2 .3" pos=".1 .2 .1"/></body></frame></body>
      </frame></worldbody></mujoco>"""
    models = both_sides(xml)
    posture = [0.3, -0.5, 0.7]
    one, other = (posed(model, posture, posture) for model in models)
    np.testing.assert_allclose(other.xipos, one.xipos * POLAR, atol=1e-12)
    np.testing.assert_allclose(other.qacc, one.qacc, rtol=1e-9)


def test_cameras_and_shapes_are_at_mirrored_places():
    one, other = (posed(model, model.key("home").qpos) for model in pair({}))
    np.testing.assert_allclose(other.cam_xpos, one.cam_xpos * POLAR, atol=1e-9)
    np.testing.assert_allclose(other.geom_xpos, one.geom_xpos * POLAR, atol=1e-8)
    axes = [data.cam_xmat.reshape(-1, 3, 3) for data in (one, other)]
    ahead = np.array([-1.0, 1.0, 1.0])  # the picture's own axis from left to right turns around
    np.testing.assert_allclose(axes[1], axes[0] * POLAR[:, None] * ahead, atol=1e-9)
    assert len(axes[0]) >= 6
