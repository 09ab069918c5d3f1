"""The controllers in examples/controllers: the textbook property of each."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.model import Exo
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from shown import asked
from shown import made as made_by

ROOT = Path(__file__).parent.parent
NAMES = {
    "admittance": "admittance:Admittance",
    "amplification": "amplification:ForceAmplification",
    "oscillators": "oscillators:AdaptiveOscillators",
    "proportional": "proportional:ProportionalAssist",
    "radial-basis": "radial_basis:RadialBasisTracker",
}
CUFFS = {"coupling": "cuffs", "gravity": "microgravity"}
BENT, DT = np.array([0, 0, np.pi / 2, 0]), 0.01


@pytest.fixture(autouse=True)
def _from_the_root(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)


def made(name, options="", **scene):
    return made_by(f"examples.controllers.{NAMES[name]}:{options}", **scene)


def test_admittance_renders_the_virtual_mass():
    # A constant push on the exoskeleton's inertia, whose motors lag by 0.016 s. In the end it
    # accelerates as the virtual mass does, since the inner loop lags by a constant velocity.
    parts = ("shoulder", "elbow")
    smooth = Exo(**{one: replace(getattr(Exo(), one), coulomb=0.0, viscous=0.0) for one in parts})
    policy, env = made("admittance", "mass=2,damping=0", exo=smooth, suit="none", **CUFFS)
    inertia = Plant.of(env.episodes).believed().exo_inertia().nominal()
    force = np.array([0, 0, 0, 4.0, 0, 0, 0, 0, 0])
    push = policy.policy.cuff_torque({"angle": BENT[None], "cuff_force": force[None]})[0]
    rate, motor, rates = np.zeros(2), np.zeros(2), []
    for _ in range(100):
        torque = asked(policy, env, angle=BENT, rate=[0, *rate, 0], cuff_force=force)
        for _ in range(5):
            motor = motor + 0.002 / 0.016 * (torque - motor)
            rate = rate + 0.002 * (push + motor) / inertia
        rates.append(rate)
    acceleration = (rates[-1] - rates[-21]) / 0.2
    np.testing.assert_allclose(acceleration, push / (2 * inertia), rtol=0.02, atol=1e-3)


def test_amplification_adds_the_filtered_torque_of_the_person():
    policy, env = made("amplification", "alpha=2.5,cutoff=1", gravity="microgravity")
    asked(policy, env)
    for period in range(1, 40):
        torque = asked(policy, env, interaction_torque=[0, 2, -1, 0])
        grown = 1.5 * (1 - math.exp(-math.tau * DT * period))
        np.testing.assert_allclose(torque, grown * np.array([2, -1]), rtol=1e-5)


def test_oscillators_give_a_rhythm_compensation_and_nothing_else():
    policy, env = made("oscillators")
    compensation, transparent = (make_policy(one, env) for one in ("compensation", "transparent"))
    angle, moved = np.array([0, 0.5, 1.0, 0]), np.array([0, 0.5, 0.5, 0])
    still = [asked(one, env, angle=angle) for one in (policy, transparent)]
    np.testing.assert_array_equal(*still)
    compensation.reset()
    policy.reset()
    for period in range(2500):
        turn = 2 * np.pi * 0.4 * DT * period
        parts = {"angle": angle + moved * np.sin(turn), "rate": moved * 0.8 * np.pi * np.cos(turn)}
        found, whole = (asked(one, env, **parts) for one in (policy, compensation))
    np.testing.assert_allclose(policy.policy.oscillators.frequency, 0.8 * np.pi, rtol=0.02)
    np.testing.assert_allclose(found, whole, atol=0.5)


@pytest.mark.slow
def test_more_gain_of_proportional_assist_leaves_less_effort():
    where = f"examples.controllers.{NAMES['proportional']}"
    named = {gain: f"{where}:gain={gain}" for gain in ("0", "0.5")}
    found = evaluate("ActiveSuit/ElbowFlexion-v0", named, motions=1, references=False).scores
    assert found["0.5"].effort[0] < 0.8 * found["0"].effort[0]


def test_the_radial_basis_tracker_learns_a_constant_load():
    policy, env = made("radial-basis")
    inertia, load = Plant.of(env.episodes).believed().inertia().nominal(), np.array([8.0, 3.0])
    angle, rate, target, errors = np.full(2, 0.6), np.zeros(2), np.array([0.6, 0.6]), []
    for _ in range(1500):
        parts = {"angle": [0, *angle, 0], "rate": [0, *rate, 0], "target": np.tile(target, 3)}
        torque = asked(policy, env, **parts)
        rate = rate + DT * (torque - load) / inertia
        angle = angle + DT * rate
        errors.append(np.abs(target - angle))
    assert (errors[-1] < 0.1 * np.max(errors, axis=0)).all()
    np.testing.assert_allclose(torque, load, rtol=0.1)


@pytest.mark.parametrize("name", NAMES)
def test_the_old_name_of_a_policy_is_answered_by_the_new_one(name):
    where = f"name it examples.controllers.{NAMES[name]} in a clone"
    message = f"policy '{name}' is an example since version 0.3: {where}"
    with pytest.raises(InputError, match=message):
        made_by(name)
