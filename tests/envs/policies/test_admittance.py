"""Admittance: levers of the cuffs, and the mass that is rendered."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import Exo, compose
from activesuit.envs.model.cuffs import CUFF_SITES
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from shown import asked, made

CUFFS = {"coupling": "cuffs", "gravity": "microgravity", "suit": "none"}
EXO = Exo(
    shoulder=replace(Exo().shoulder, coulomb=0.0, viscous=0.0),
    elbow=replace(Exo().elbow, coulomb=0.0, viscous=0.0),
)
BENT = np.array([0, 0, np.pi / 2, 0])


def test_torque_of_cuffs_is_the_virtual_work_of_their_forces():
    policy, env = made("admittance", **CUFFS)
    model = compose(env.config, drawn=False)
    data, step = mujoco.MjData(model), 1e-6
    rng = np.random.default_rng(3)
    pose, force = rng.uniform(0, 1, 4), rng.normal(size=(3, 3)) * 20
    chain = [
        model.joint(f"exo_{joint}").qposadr[0]
        for joint in ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
    ]
    sites = [model.site(name).id for name in CUFF_SITES.values()]

    def places(angle):
        data.qpos[chain] = angle
        mujoco.mj_kinematics(model, data)
        return data.site_xpos[sites].copy(), data.site_xmat[sites].reshape(-1, 3, 3).copy()

    axes = places(pose)[1]
    on_exo = -np.einsum("sij,sj->si", axes, force)
    expected = []
    for joint in (1, 2):
        away = step * np.eye(4)[joint]
        moved = (places(pose + away)[0] - places(pose - away)[0]) / (2 * step)
        expected.append((on_exo * moved).sum())
    found = policy.cuff_torque({"angle": pose[None], "cuff_force": force.reshape(1, 9)})
    np.testing.assert_allclose(found[0], expected, atol=1e-6)


@pytest.mark.parametrize("mass", [0.5, 1.0, 2.0])
def test_it_renders_the_virtual_mass(mass):
    # A constant push on the exoskeleton's inertia, whose motors lag by 0.016 s. In the end it
    # accelerates as the virtual mass does, since the inner loop lags by a constant velocity.
    name = f"admittance:mass={mass},damping=0"
    policy, env = made(name, exo=EXO, **CUFFS)
    inertia = Plant.of(env.episodes).believed().exo_inertia().nominal()
    np.testing.assert_allclose(policy.virtual_mass, mass * inertia)
    force = np.array([0, 0, 0, 4.0, 0, 0, 0, 0, 0])
    push = policy.cuff_torque({"angle": BENT[None], "cuff_force": force[None]})[0]
    assert np.abs(push[1]) > 0.3
    rate, motor, rates = np.zeros(2), np.zeros(2), []
    for _ in range(100):
        torque = asked(policy, env, angle=BENT, rate=[0, *rate, 0], cuff_force=force)
        for _ in range(5):
            motor = motor + 0.002 / 0.016 * (torque - motor)
            rate = rate + 0.002 * (push + motor) / inertia
        rates.append(rate)
    acceleration = (rates[-1] - rates[-21]) / 0.2
    np.testing.assert_allclose(acceleration, push / policy.virtual_mass, rtol=0.02, atol=1e-3)


def test_a_share_of_the_suit_is_pressed():
    _, env = made("admittance", **{**CUFFS, "suit": "mock-suit"})
    own, whole = (
        asked(make_policy(f"admittance:rho={rho}", env), env, angle=BENT) for rho in (0, 1)
    )
    suit = asked(make_policy("feedforward", env), env, angle=BENT)
    gain = 0.01 * 10 / 1.0  # what the inner loop adds in the first period, in which nothing moves
    np.testing.assert_allclose(whole - own, (1 + gain) * suit, rtol=1e-4)


@pytest.mark.parametrize(
    ("option", "message"),
    [("rho=2", "use a number from 0 to 1"), ("mass=0.1", "use a number from 0.5 to 5")],
)
def test_options_out_of_range(option, message):
    _, env = made("admittance", **CUFFS)
    with pytest.raises(InputError, match=message):
        make_policy(f"admittance:{option}", env)


def test_it_needs_cuffs():
    with pytest.raises(InputError, match="use coupling='cuffs'"):
        made("admittance")
