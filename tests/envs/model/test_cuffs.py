"""The exoskeleton: its joints and cuffs against the rigid one, its motors and its masses."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, SCENE
from activesuit.envs.model import ASSISTED, ArmConfig, Exo, arm_spec, compose
from activesuit.envs.model.bushing import Bushing, replace_bushing
from activesuit.envs.model.cuffs import CUFFS, couple
from activesuit.envs.model.motors import heated
from arms import mass_matrix, posed
from helpers import assert_refused


def rigid_spec():
    return mujoco.MjSpec.from_file(str(SCENE))


def cuffed(misalignment=(0, 0, 0)):
    spec = rigid_spec()
    couple(spec, misalignment)
    spec.option.timestep = 0.001
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def cuff_forces(data):
    return np.array([data.sensor(f"cuff_{segment}_force").data for segment in CUFFS])


@pytest.mark.parametrize("seed", range(2))
def test_moving_as_one_it_is_the_rigid_mechanism(seed):
    rigid = rigid_spec().compile()
    model, data = cuffed()
    rng = np.random.default_rng(seed)
    one = posed(rigid, rng.uniform(*rigid.jnt_range.T), rng.standard_normal(4))
    data.qpos[:], data.qvel[:] = np.tile(one.qpos, 2), np.tile(one.qvel, 2)
    mujoco.mj_forward(model, data)
    both = np.vstack([np.eye(4), np.eye(4)])
    inertia = [mass_matrix(rigid, one), mass_matrix(model, data)]
    np.testing.assert_allclose(both.T @ inertia[1] @ both, inertia[0], atol=5e-6)
    np.testing.assert_allclose(both.T @ data.qfrc_bias, one.qfrc_bias, atol=5e-5)
    np.testing.assert_allclose(both.T @ data.qfrc_passive, one.qfrc_passive, atol=1e-9)
    np.testing.assert_allclose(both.T @ model.dof_frictionloss, rigid.dof_frictionloss)
    limits = both.T @ model.jnt_actfrcrange
    np.testing.assert_allclose(limits, rigid.jnt_actfrcrange, atol=1e-9)
    np.testing.assert_allclose(cuff_forces(data), 0, atol=1e-9)


def test_the_torque_of_a_motor_reaches_the_wearer_through_the_cuffs():
    model, data = cuffed()
    model.opt.gravity[:] = 0
    model.dof_frictionloss[:] = 0
    motor = model.actuator("assist_shoulder_flexion").id
    control = model.actuator_ctrladr[motor]
    data.ctrl[control] = 0.2 * model.actuator_ctrlrange[control, 1]
    mujoco.mj_step(model, data, nstep=20_000)
    assist = data.actuator_force[motor]
    wearer = data.sensor("human_torque_shoulder_flexion").data[0]
    passive = model.jnt_stiffness[:4] * (data.qpos[:4] - model.qpos_spring[:4])
    assert abs(assist) > 1
    assert wearer == pytest.approx(passive[1] - assist, rel=1e-4)
    assert np.linalg.norm(cuff_forces(data), axis=1).min() > 1
    slack = data.qpos[5] - data.qpos[1]
    assert 0 < slack < math.radians(5)


@pytest.mark.parametrize("axis", range(3))
def test_a_misalignment_loads_the_cuffs_only_away_from_where_they_were_strapped_on(axis):
    shift = np.zeros(3)
    shift[axis] = 0.02
    model, data = cuffed(shift)
    data.qpos[:] = 0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(cuff_forces(data), 0, atol=1e-9)
    apart = data.xpos[model.body("exo_shoulder_support").id] - data.xpos[model.body("shoulder").id]
    np.testing.assert_allclose(apart, shift * [1, -1, 1], atol=1e-12)
    data.qpos[[1, 5]] = 1.2
    mujoco.mj_forward(model, data)
    loaded = np.linalg.norm(cuff_forces(data), axis=1).min() > 5
    assert loaded == (axis != 1)  # a shift along the axis of flexion does not matter to it


def test_hard_cuffs_approach_the_rigid_exoskeleton():
    rigid = rigid_spec().compile()
    rigid.opt.timestep = 1e-4
    rigid.dof_frictionloss[:] = 0  # each model would stick at an angle of its own
    one = mujoco.MjData(rigid)
    mujoco.mj_resetDataKeyframe(rigid, one, 0)
    one.ctrl[3] = 0.8
    mujoco.mj_step(rigid, one, nstep=5000)
    apart = []
    for hardness in (1, 100):
        model, data = cuffed()
        model.opt.timestep = 1e-4
        model.dof_frictionloss[:] = 0
        for segment, cuff in CUFFS.items():
            names = ("stiffness", "rotational_stiffness", "damping", "rotational_damping")
            scales = (hardness, hardness, math.sqrt(hardness), math.sqrt(hardness))
            hard = {n: np.multiply(getattr(cuff, n), s) for n, s in zip(names, scales, strict=True)}
            replace_bushing(model, data.plugin_state, f"cuff_{segment}", Bushing(**hard))
        data.ctrl[3] = 0.8
        mujoco.mj_step(model, data, nstep=5000)
        apart.append(np.abs(data.qpos[:4] - one.qpos).max())
    assert apart[1] < 0.1 * apart[0]


def test_sensors_on_the_exoskeleton_go_with_it():
    spec, site = rigid_spec(), mujoco.mjtObj.mjOBJ_SITE
    for name, at in (("ring", "attachment_ring"), ("cuff", "wrist_center")):
        sensor = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_FRAMEPOS)
        sensor.objtype, sensor.objname = site, at
    sensor.reftype, sensor.refname = site, "cuff_forearm"
    rigid = posed(spec.compile())
    couple(spec)
    data = posed(spec.compile())
    for name in ("ring", "cuff"):
        np.testing.assert_allclose(data.sensor(name).data, rigid.sensor(name).data, atol=1e-12)


def test_only_a_rigid_exoskeleton_can_be_coupled():
    spec = rigid_spec()
    couple(spec)
    message = "not the arm of arm.xml with its rigid exoskeleton"
    assert_refused(couple, [(model, message) for model in (spec, mujoco.MjSpec())])


def test_links_of_another_length_move_the_axes_and_load_the_cuffs_only_when_bent():
    lengths = {"upper_arm_length": 0.31, "forearm_length": 0.25}
    place = {"coupling": "cuffs", "suit": "none", "gravity": "microgravity"}
    usual, model = compose(ArmConfig(**place)), compose(ArmConfig(**place, exo=lengths))
    data = posed(model)
    axes = [data.joint(f"exo_{joint}").xanchor[2] for joint in JOINTS[1:]]
    np.testing.assert_allclose(-np.diff(axes), list(lengths.values()), atol=1e-12)
    np.testing.assert_allclose(model.body("exo_forearm").mass, usual.body("exo_forearm").mass)
    forces = [data.sensor(f"cuff_{segment}_force").data for segment in CUFFS]
    np.testing.assert_allclose(forces, 0.0, atol=1e-9)
    for name in ("elbow_flexion", "exo_elbow_flexion"):
        data.joint(name).qpos[0] = 1.0
    mujoco.mj_forward(model, data)
    assert np.linalg.norm(data.sensor("cuff_forearm_force").data) > 10


def test_other_lengths_need_cuffs_and_sense():
    rows = [
        ("rigid", {"upper_arm_length": 0.3}, "upper_arm_length is 0.3, but coupling is 'rigid'"),
        ("cuffs", {"forearm_length": 3}, "forearm_length is 3.*0.15 to 0.5 m"),
    ]
    assert_refused(lambda coupling, exo: ArmConfig(coupling=coupling, exo=exo), rows)


MOTORS = Exo().motors


def driven(joint, speed=0.0):
    """The default model with `joint` kept at a speed by an enormous inertia."""
    spec = arm_spec(ArmConfig(suit="none", gravity="microgravity"))
    spec.joint(joint).armature = 1e9
    model = spec.compile()
    data = mujoco.MjData(model)
    data.joint(joint).qvel[0] = speed
    return model, data


@pytest.mark.parametrize(("joint", "turn"), [("shoulder_flexion", 1), ("elbow_flexion", -1)])
@pytest.mark.parametrize("share", [-1.2, 0.0, 0.7])
def test_net_torque_falls_linearly_from_the_peak_to_zero_at_no_load_speed(joint, turn, share):
    motor = MOTORS[joint]
    speed = share * turn * motor.no_load_speed
    model, data = driven(joint, speed)
    actuator = model.actuator(f"assist_{joint}").id
    data.ctrl[model.actuator_ctrladr[actuator]] = 2 * turn * motor.peak_torque
    for _ in range(100):  # 0.2 s, 12 time constants of the torque loop
        data.qpos[:] = 0.5
        mujoco.mj_step(model, data)
    net = data.actuator_force[actuator] - motor.viscous * speed
    # Beyond the peak the torque loop limits the torque, and what turns backward is braked at it.
    available = motor.peak_torque * (1 - share)
    limit = motor.peak_torque - motor.viscous * abs(speed) * np.sign(share)
    assert turn * net == pytest.approx(min(available, limit), abs=1e-3)


@pytest.mark.parametrize("joint", ASSISTED)
def test_torque_follows_a_step_with_the_bandwidth(joint):
    motor = MOTORS[joint]
    model, data = driven(joint)
    actuator = model.actuator(f"assist_{joint}").id
    data.ctrl[model.actuator_ctrladr[actuator]] = command = 0.4 * motor.peak_torque
    torque = []
    for _ in range(50):
        mujoco.mj_step(model, data)
        torque.append(data.actuator_force[actuator])
    time = model.opt.timestep * np.arange(1, 51)
    expected = command * (1 - np.exp(-2 * np.pi * motor.bandwidth * time))
    np.testing.assert_allclose(torque, expected, rtol=1e-9)


def test_inertia_and_friction_are_the_motors():
    strong = replace(Exo().elbow, armature=0.05, coulomb=3.2, viscous=0.4)
    exo = Exo(elbow=strong)
    inertia, rest = [], []
    for config in (ArmConfig(suit="none"), ArmConfig(suit="none", exo=exo)):
        model = compose(config)
        data = posed(model, rate=1.0)
        inertia.append(mass_matrix(model, data))
        rest.append((model.dof_frictionloss.copy(), data.qfrc_passive.copy()))
    elbow = np.array([0, 0, 1, 0])
    np.testing.assert_allclose(inertia[1] - inertia[0], 0.03 * np.diag(elbow), atol=1e-12)
    np.testing.assert_allclose(rest[1][0] - rest[0][0], 1.2 * elbow, atol=1e-12)
    np.testing.assert_allclose(rest[1][1] - rest[0][1], -0.3 * elbow, atol=1e-12)


def test_masses_are_the_configured_ones():
    links = {"upper_arm_link": 1.3, "forearm_link": 0.8, "cuff": 0.2, "ring": 0.5}
    exo = {"shoulder": {"mass": 1.1}, "elbow": {"mass": 0.7}, **links}
    model = compose(ArmConfig(exo=exo))
    masses = {name: model.body(f"exo_{name}").mass[0] for name in ("upper_arm", "forearm", "hand")}
    assert masses == pytest.approx({"upper_arm": 2.2, "forearm": 1.0, "hand": 0.5})
    assert model.body("exo_shoulder_support").mass[0] == pytest.approx(1.1)


def test_heat_is_the_running_mean_square():
    for torque, time_constant in ((10.0, 60.0), (-4.0, 30.0)):
        many = 0.0
        for _ in range(1000):
            many = heated(many, torque, time_constant, 0.01)
        assert many == pytest.approx(heated(0.0, torque, time_constant, 10.0), rel=1e-10)
        forever = heated(many, torque, 60.0, 1e5)
        assert np.sqrt(forever) == pytest.approx(abs(torque), rel=1e-12)
