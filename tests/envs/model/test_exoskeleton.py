"""Motors, encoders and masses of the exoskeleton."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ASSISTED, ArmConfig, Exo, arm_spec, compose
from activesuit.envs.model.motors import heated

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
        data = mujoco.MjData(model)
        data.qvel[:] = 1.0
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        inertia.append(full)
        rest.append((model.dof_frictionloss.copy(), data.qfrc_passive.copy()))
    elbow = np.array([0, 0, 1, 0])
    np.testing.assert_allclose(inertia[1] - inertia[0], 0.03 * np.diag(elbow), atol=1e-12)
    np.testing.assert_allclose(rest[1][0] - rest[0][0], 1.2 * elbow, atol=1e-12)
    np.testing.assert_allclose(rest[1][1] - rest[0][1], -0.3 * elbow, atol=1e-12)


def test_masses_are_the_configured_ones():
    exo = Exo(
        shoulder=replace(Exo().shoulder, mass=1.1),
        elbow=replace(Exo().elbow, mass=0.7),
        upper_arm_link=1.3,
        forearm_link=0.8,
        cuff=0.2,
        ring=0.5,
    )
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
