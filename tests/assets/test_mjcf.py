"""The plain MJCF: complete, stable, and with the masses it claims."""

import mujoco
import numpy as np
import pytest
from activesuit.assets import FOLDER, JOINTS, SCENE
from activesuit.envs.model import ArmConfig, bare_arm
from activesuit.envs.person.strength import PROVENANCE
from activesuit.tools.provenance import drawn_quantities
from scipy.stats import qmc


@pytest.fixture(scope="module")
def scene():
    return mujoco.MjModel.from_xml_path(str(SCENE))


def test_the_device_alone_compiles():
    model = mujoco.MjModel.from_xml_path(str(FOLDER / "mjcf" / "arm.xml"))
    assert model.nv == 4
    assert model.nplugin == 0


def test_everything_that_matters_is_named(scene):
    assert tuple(scene.joint(i).name for i in range(scene.njnt)) == JOINTS
    assert all(scene.actuator(i).name for i in range(scene.nactuator))
    assert all(scene.sensor(i).name for i in range(scene.nsensor))
    cameras = "front side overview elbow cuffs follow".split()
    assert sorted(scene.camera(i).name for i in range(scene.ncam)) == sorted(cameras)
    assert scene.jnt_limited.all()
    assert (scene.dof_armature > 0).all()


@pytest.mark.parametrize("name", ["home", "reach"])
def test_keyframes_lie_in_the_ranges_and_hold_controls(scene, name):
    key = scene.key(name)
    low, high = scene.jnt_range.T
    assert (key.qpos >= low).all()
    assert (key.qpos <= high).all()
    wanted = [key.ctrl[scene.actuator_ctrladr[scene.actuator(f"human_{j}").id]] for j in JOINTS]
    np.testing.assert_array_equal(wanted, key.qpos)


def gravity_torque(model, **angles):
    data = mujoco.MjData(model)
    for joint, angle in angles.items():
        data.joint(joint).qpos[0] = angle
    mujoco.mj_forward(model, data)
    return [data.joint(joint).qfrc_bias[0] for joint in ("shoulder_flexion", "elbow_flexion")]


@pytest.mark.parametrize(
    ("gravity", "shoulder", "elbow"),
    [("earth", 11.82, 3.25), ("mars", 4.47, 1.23), ("moon", 1.95, 0.54), ("microgravity", 0, 0)],
)
def test_gravity_torque(scene, gravity, shoulder, elbow):
    # de Leva 1996, 1.78 m, 80 kg, arm horizontal: closed form.
    torque = gravity_torque(bare_arm(ArmConfig(gravity=gravity)), shoulder_flexion=np.pi / 2)
    np.testing.assert_allclose(torque, [shoulder, elbow], atol=0.006)
    torque = gravity_torque(scene, shoulder_flexion=np.pi / 2)  # README.md of the files
    np.testing.assert_allclose(torque, [34.8, 9.0], atol=0.05)


def test_every_number_is_the_models(scene):
    drawn = {quantity.name: quantity.value for quantity in drawn_quantities()}
    assert drawn["torso.shoulder_height"] == scene.body("torso").pos[2]
    assert drawn["suit.hand.mass"] == scene.body("suit_hand").mass[0]
    passive = {quantity.name: quantity.value for quantity in PROVENANCE}
    for i, joint in enumerate(JOINTS):
        ends = [drawn[f"suit.range.{joint}.{end}"] for end in ("low", "high")]
        np.testing.assert_array_equal(ends, scene.joint(joint).range)
        wearer = scene.actuator(f"human_{joint}")
        assert drawn[f"wearer.{joint}.stiffness"] == -wearer.biasprm[1]
        assert scene.dof_damping[i] == passive[f"passive.{joint}.viscosity"]
        assert scene.jnt_stiffness[i] == passive.get(f"passive.{joint}.stiffness", 0)
        assert scene.qpos_spring[i] == passive.get(f"passive.{joint}.rest", 0)


def test_sensors_read_what_they_say(scene):
    data = mujoco.MjData(scene)
    mujoco.mj_resetDataKeyframe(scene, data, scene.key("reach").id)
    data.ctrl[scene.actuator_ctrladr[scene.actuator("assist_elbow_flexion").id]] = 12.5
    data.act[:] = 12.5
    mujoco.mj_forward(scene, data)
    assert data.sensor("assist_torque_elbow_flexion").data[0] == pytest.approx(12.5)
    assert data.sensor("encoder_elbow_flexion").data[0] == pytest.approx(0.6)
    np.testing.assert_allclose(
        data.sensor("hand_position").data, data.site("hand_grip").xpos, atol=1e-12
    )


@pytest.mark.parametrize("key", ["home", "reach"])
@pytest.mark.parametrize("noisy", [False, True])
def test_ten_seconds_without_a_warning(scene, key, noisy):
    data = mujoco.MjData(scene)
    mujoco.mj_resetDataKeyframe(scene, data, scene.key(key).id)
    # joint range, 6 rad/s and full torque for the wearer
    low, high = scene.actuator_ctrlrange.T.copy()
    for joint in JOINTS:
        actuator = scene.actuator(f"human_{joint}").id
        own = slice(first := scene.actuator_ctrladr[actuator], first + 3)
        ends = scene.joint(joint).range, (-6, 6), scene.actuator_forcerange[actuator]
        low[own], high[own] = np.transpose(ends)
    for share in qmc.Halton(scene.nu, rng=np.random.default_rng(0)).random(100):
        if noisy:
            data.ctrl[:] = low + share * (high - low)
        mujoco.mj_step(scene, data, 50)
    assert not data.warning.number.any()
    assert np.isfinite(data.qpos).all()
    over = np.maximum(scene.jnt_range[:, 0] - data.qpos, data.qpos - scene.jnt_range[:, 1])
    assert over.max() < 0.15
