"""The left arm moves, weighs and looks like the right arm's mirror image."""

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, compose, mirror
from activesuit.envs.person import Person
from activesuit.envs.rendering import QUALITIES

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
        inertia = [np.zeros((right.nv, right.nv)) for _ in range(2)]
        for model, data, full in zip((right, left), (one, other), inertia, strict=True):
            mujoco.mj_fullM(model, data, full)
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
    heads = []
    for model in (right, left):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        heads.append(data.body("torso").xpos.copy())
    np.testing.assert_allclose(heads[0], heads[1], atol=1e-12)
    assert heads[0][1] < -0.1  # the wearer's right


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
    spec = mujoco.MjSpec.from_string(xml)
    models = [spec.copy().compile()]
    mirror(spec)
    models.append(spec.compile())
    corners = []
    for model in models:
        data = mujoco.MjData(model)
        data.qpos[:] = 0.6
        mujoco.mj_forward(model, data)
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
    spec = mujoco.MjSpec.from_string(xml)
    models = [spec.copy().compile()]
    mirror(spec)
    models.append(spec.compile())
    one, other = (mujoco.MjData(model) for model in models)
    for model, data in zip(models, (one, other), strict=True):
        data.qpos[:] = data.qvel[:] = 0.3, -0.5, 0.7
        mujoco.mj_forward(model, data)
    np.testing.assert_allclose(other.xipos, one.xipos * POLAR, atol=1e-12)
    np.testing.assert_allclose(other.qacc, one.qacc, rtol=1e-9)


@pytest.mark.render
@pytest.mark.slow
def test_cameras_show_the_mirrored_picture():
    cameras = ("front", "side", "overview", "cuffs", "elbow", "follow")
    sides = []
    for model in pair({}):
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
        mujoco.mj_forward(model, data)
        pictures = []
        QUALITIES["fast"].ask(model)
        with mujoco.Renderer(model, 120, 160) as renderer:
            for camera in cameras:
                renderer.update_scene(data, camera=camera)
                pictures.append(renderer.render().astype(float))
        sides.append(pictures)
    for camera, right, left in zip(cameras, *sides, strict=True):
        assert right.std() > 10, camera
        # Shadows and edges fall on pixels that have no exact counterpart.
        assert np.abs(right - left[:, ::-1]).mean() < 2, camera
        assert np.abs(right - left).mean() > 5, camera
