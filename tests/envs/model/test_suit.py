"""The suit's torque on the composed arm, at its own and at another pressure."""

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, Suit, load_suit
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.model.compose import resisting_joints
from helpers import assert_refused, without_volume_shares

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
