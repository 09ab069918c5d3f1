"""Random changes of the best known plan."""

import numpy as np
import pytest
from activesuit.benchmarks import bound
from activesuit.benchmarks.bound import attack, attack_table, changed
from activesuit.envs.benchmark.suites import Setting
from helpers import short_benchmark

pytestmark = pytest.mark.slow

DT = 0.01


@pytest.fixture
def plan():
    time = DT * np.arange(300)
    return 0.3 * np.sin(time + np.arange(4)[:, None])[..., None] * np.ones(2)


def sizes(found, plan):
    return np.sqrt(np.mean((found - plan) ** 2, axis=(1, 2)) / np.mean(plan**2, axis=(1, 2)))


def test_changes_are_small_and_large_smooth_and_within_the_peaks(plan):
    rng = np.random.default_rng(0)
    found = [changed(plan, DT, rng) for _ in range(50)]
    moved = np.array([sizes(one, plan) for one in found])
    assert moved.min() < 0.01
    assert 0.1 < moved.max() < 0.4
    assert (np.ptp(moved, axis=1) > 0).all()  # each motion has a change of its own
    assert all(np.abs(one).max() <= 1 for one in found)
    roughness = [np.abs(np.diff(one, 2, axis=1)).max() for one in found]
    assert np.median(roughness) < 0.05 * np.sqrt(np.mean(plan**2))
    same = [changed(plan, DT, np.random.default_rng(7)) for _ in range(2)]
    np.testing.assert_array_equal(*same)


def test_no_change_of_the_plan_helps_by_a_hundredth(monkeypatch):
    monkeypatch.setattr(bound, "MOTIONS", 8)
    advanced = []
    with short_benchmark(3.0):
        setting = Setting("ArmTracking", "nominal", "emu-like")
        found = attack(setting, 4, lambda: advanced.append(1))
    assert 8 * len(advanced) == found.changes == 32
    assert 0 <= found.gain < 0.01
    assert found.relief > 1
    assert 0 <= found.last_pass < 0.02
    header, (row,) = attack_table([found])
    assert len(header) == len(row)


def test_a_better_plan_would_be_found(monkeypatch):
    """A plan of half the torque is worse than some that are a little stronger."""
    monkeypatch.setattr(bound, "MOTIONS", 8)
    weak = bound.clairvoyant

    def halved(wearers, seeds, **options):
        plan = weak(wearers, seeds, **options)
        return type(plan)(0.5 * plan.commands)

    monkeypatch.setattr(bound, "clairvoyant", halved)
    monkeypatch.setattr(bound, "LARGEST", 1.0)
    with short_benchmark(3.0):
        found = attack(Setting("ArmTracking", "nominal", "emu-like"), 8, lambda: None)
    assert found.gain > 0.01
    assert found.better > 0
