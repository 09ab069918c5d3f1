"""The suit's torque on the composed arm, at its own and at another pressure."""

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, Suit, load_suit
from activesuit.envs.model import ArmConfig, arm_spec, compose
from activesuit.envs.model.compose import resisting_joints
from activesuit.envs.model.suit import attach_suit
from activesuit.errors import InputError
from helpers import without_volume_shares

PROPORTIONAL = without_volume_shares(load_suit("emu-like"))


def suit_torque(pressure):
    """Along a motion that only the test makes: the joints are too heavy for any force [N·m]."""
    spec = arm_spec(ArmConfig(suit="none"))
    for joint in spec.joints:
        joint.armature = 1e12
    attach_suit(spec, PROPORTIONAL.at_pressure(pressure))
    model = spec.compile()
    data = mujoco.MjData(model)
    torque = []
    for phase in np.linspace(0, 4 * np.pi, 200):
        data.qpos[:] = 0.6 - 0.5 * np.cos(phase) * np.linspace(1, 0.8, 4)
        mujoco.mj_forward(model, data)
        torque.append([data.sensor(f"{joint}_suit_torque").data[0] for joint in JOINTS])
        mujoco.mj_step(model, data)
    return np.array(torque)


def test_torque_is_proportional_to_pressure():
    at_reference = suit_torque(29.6)
    assert np.ptp(at_reference, axis=0).min() > 1
    np.testing.assert_allclose(suit_torque(40.0), 40 / 29.6 * at_reference, atol=1e-9)


def test_without_pressure_nothing_resists():
    spec = arm_spec(ArmConfig(suit="none"))
    attach_suit(spec, PROPORTIONAL.at_pressure(0.0))
    assert spec.compile().nplugin == 0


@pytest.mark.parametrize("pressure", [40.0, 0.0])
def test_a_config_scales_the_suit_to_its_pressure(pressure):
    scaled = resisting_joints(ArmConfig(suit=PROPORTIONAL, pressure=pressure))
    assert resisting_joints(ArmConfig(suit=PROPORTIONAL)) == PROPORTIONAL.joints
    assert scaled == PROPORTIONAL.at_pressure(pressure).joints
    assert compose(ArmConfig(suit=PROPORTIONAL, pressure=pressure)).nplugin == len(scaled)


@pytest.mark.parametrize("suit", ["mock-suit"])
def test_the_pressure_of_the_papers_suit_is_not_known(suit):
    config = ArmConfig(suit=suit, pressure=40.0, allow_uncertified=True)
    with pytest.raises(InputError, match="does not tell at which its torque"):
        compose(config)


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


def test_a_suit_is_preconditioned_at_its_pressure():
    config = ArmConfig(suit=PROPORTIONAL, pressure=40.0, preconditioned=True)
    assert resisting_joints(config) == PROPORTIONAL.at_pressure(40).preconditioned().joints


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
