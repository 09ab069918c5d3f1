"""The arm that MuJoCo Warp accepts, against the one of the environments."""

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, compose, for_warp, resisting_joints
from activesuit.errors import InputError
from activesuit.hysteresis.engine import take_off

WEARER = 4  # actuators with three inputs in `compose`, and one here


def inputs(full, steps, seed=0):
    """Random inputs of the full model, and those of the same torques with one input a joint."""
    rng, low, high = np.random.default_rng(seed), *full.actuator_ctrlrange.T
    begin, end = rng.uniform(low, high, (2, full.nu)) * 0.5
    way = np.sin(np.linspace(0, 9, steps))[:, None] ** 2
    ctrl = begin + way * (end - begin)
    angle, rate, torque = np.moveaxis(ctrl[:, : 3 * WEARER].reshape(steps, WEARER, 3), 2, 0)
    stiffness, damping = -full.actuator_biasprm[:WEARER, 1:3].T
    own = stiffness * angle + damping * rate + torque
    return ctrl, np.concatenate([own, ctrl[:, 3 * WEARER :]], axis=1)


@pytest.mark.parametrize(
    "config",
    [
        ArmConfig(),
        ArmConfig(coupling="none", gravity="moon"),
        ArmConfig(suit="none", side="left", payload={"mass": 2.0}, gravity="microgravity"),
    ],
    ids=["rigid", "none", "no suit"],
)
def test_it_moves_as_the_arm_of_the_environments_without_its_hysteresis(config):
    full, bare = compose(config, drawn=False), for_warp(config)
    assert bare.nplugin == 0 == bare.nkey
    theirs, ours = mujoco.MjData(full), mujoco.MjData(bare)
    for joint in resisting_joints(config):
        take_off(full, theirs.plugin_state, joint)
    moved = 0.0
    for one, other in zip(*inputs(full, 500), strict=True):
        theirs.ctrl[:], ours.ctrl[:] = one, other
        mujoco.mj_step(full, theirs)
        mujoco.mj_step(bare, ours)
        assert (theirs.qpos == ours.qpos).all()
        assert (theirs.actuator_force == ours.actuator_force).all()
        moved = max(moved, np.abs(ours.qpos).max())
    assert moved > 0.2


def test_cuffs_are_refused_in_one_sentence():
    with pytest.raises(InputError, match="coupling is 'cuffs', whose forces are a plugin"):
        for_warp(ArmConfig(coupling="cuffs"))


@pytest.mark.slow
def test_the_suited_arm_in_mujoco_warp():
    wp = pytest.importorskip("warp", reason="needs the extra gpu: make test-all")
    mjw = pytest.importorskip("mujoco_warp", reason="needs the extra gpu: make test-all")
    from activesuit.hysteresis.warp import attach

    config, worlds = ArmConfig(), 4
    suit, full, mjm = resisting_joints(config), compose(config, drawn=False), for_warp(config)
    m, d = mjw.put_model(mjm), mjw.make_data(mjm, nworld=worlds, nconmax=8, njmax=16)
    models = {joint: entry.model for joint, entry in suit.items()}
    starts = {joint: entry.begun() for joint, entry in suit.items()}
    hysteresis = attach(m, d, mjm, models, starts=starts)
    rows = [mujoco.MjData(full) for _ in range(worlds)]
    given = [inputs(full, 1000, world) for world in range(worlds)]
    for i in range(1000):
        d.ctrl.assign(np.array([own[i] for _, own in given], dtype=np.float32))
        mjw.step(m, d)
        for data, (ctrl, _) in zip(rows, given, strict=True):
            data.ctrl[:] = ctrl[i]
            mujoco.mj_step(full, data)
        expected = [[data.sensor(f"{j}_suit_torque").data[0] for j in suit] for data in rows]
        assert np.abs(hysteresis.torque.numpy() + expected).max() <= 1e-3
    assert wp.get_device() == d.qpos.device
    assert np.abs(d.qpos.numpy() - [data.qpos for data in rows]).max() < 1e-3
