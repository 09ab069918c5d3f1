"""The passivity guard."""

import sys
from types import SimpleNamespace

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.guard import RESERVE, lessen, updated_ledger

DT = 0.01


def test_no_cycle_gains_energy():
    """3,000 random policies in random cycles, against a belief that stores and dissipates."""
    rng, n, periods, cycles = np.random.default_rng(0), 3_000, 100, 6
    phase = 2 * np.pi * np.arange(periods) / periods
    size, shift = rng.uniform(0.2, 1, (n, 2)), rng.uniform(0, 2 * np.pi, (n, 2))
    stiffness, friction = rng.uniform(0, 10, (n, 2)), rng.uniform(0, 5, (n, 2))
    push = rng.normal(0, 20, (n, 2))
    ledger, gained = np.full(n, RESERVE), []
    for _ in range(cycles):
        given, lost = np.zeros(n), np.zeros(n)
        for now in phase:
            angle = size * np.sin(now + shift)
            rate = size * 2 * np.pi * np.cos(now + shift)
            needed = stiffness * angle + friction * np.sign(rate)
            wanted = push * rng.standard_normal((n, 2)) + push * np.sign(rate)
            torque, _ = lessen(wanted, needed, rate, ledger, DT)
            ledger = updated_ledger(ledger, needed, torque, rate, DT)
            given += (torque * rate).sum(axis=1) * DT
            lost += (friction * np.abs(rate)).sum(axis=1) * DT
        gained.append(given - lost)
    stored = (stiffness * size**2 / 2).sum(axis=1)
    assert (np.sum(gained, axis=0) <= RESERVE + stored + 1e-6).all()


def test_it_leaves_the_right_compensation_alone():
    arms = ArmEnv("ArmTracking").rows(2, max_episode_steps=400)
    bare, guarded = make_policy("compensation", arms), make_policy("compensation:guard=true", arms)
    without, with_it = (rollout(arms, policy, [3, 4]) for policy in (bare, guarded))
    for one, other in zip(without, with_it, strict=True):
        np.testing.assert_array_equal(one.human_torque, other.human_torque)
    assert guarded.acted.tolist() == [0, 0]


class Drive:
    """Drives the arm with its motion, which is unstable."""

    def __init__(self, plant):
        self.rate = plant.layout["rate"]

    def reset(self):
        pass

    def act(self, observation):
        return np.clip(2.0 * observation[..., self.rate][..., [1, 2]], -1, 1)


def test_it_stops_a_policy_that_drives(monkeypatch):
    monkeypatch.setitem(sys.modules, "drives", SimpleNamespace(Drive=Drive))
    arms = ArmEnv("ElbowFlexion", gravity="microgravity").rows(2, max_episode_steps=400)
    wild = rollout(arms, make_policy("drives:Drive", arms), [1, 2])
    policy = make_policy("drives:Drive:guard=true", arms)
    tame = rollout(arms, policy, [1, 2])
    assert policy.acted.min() > 20

    def work(traces):
        return sum(np.sum(t.assist_torque * t.rate[:, [1, 2]]) * DT for t in traces)

    assert work(tame) < 0.5 * work(wild)
