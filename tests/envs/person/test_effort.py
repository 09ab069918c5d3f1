import numpy as np
import pytest
from activesuit.envs.person.effort import (
    effort_metrics,
    log_dimensionless_jerk,
    spectral_arc_length,
)
from helpers import assert_refused

DT = 0.01
TIME = np.arange(0, 2, DT)


def minimum_jerk_rate(samples):
    s = np.linspace(0, 1, samples)
    return 30 * s**2 * (1 - s) ** 2


def test_a_cycle_of_a_sine():
    phase = 2 * np.pi * TIME / 2
    torque = np.stack([8 * np.sin(phase), 8 * np.sin(phase)], axis=-1)
    rate = np.stack([3 * np.sin(phase), 3 * np.cos(phase)], axis=-1)
    metrics = effort_metrics(torque, rate, DT)
    np.testing.assert_allclose(metrics.rms, 8 / np.sqrt(2), rtol=1e-12)
    np.testing.assert_allclose(metrics.peak, 8, rtol=1e-12)
    np.testing.assert_allclose(metrics.impulse, 8 * 2 / np.pi * 2, rtol=1e-3)
    np.testing.assert_allclose(metrics.positive_work, [24, 24 / np.pi], rtol=1e-3)
    np.testing.assert_allclose(metrics.negative_work, [0, 24 / np.pi], rtol=1e-3, atol=1e-9)


def test_costs_of_raising_holding_and_lowering():
    torque = np.full((100, 3), 10.0)
    rate = np.full((100, 3), 0.5) * [1, 0, -1]
    metrics = effort_metrics(torque, rate, DT)
    np.testing.assert_allclose(metrics.work_cost, [5 / 0.25, 0, 5 / 1.2])
    np.testing.assert_allclose(metrics.torque_cost, 10**1.36)
    # Lowering costs much less than raising: the published isometric model says about a quarter.
    assert 0.15 < metrics.work_cost[2] / metrics.work_cost[0] < 0.3


def test_costs_of_consecutive_records_add_up():
    rng = np.random.default_rng(0)
    torque, rate = rng.normal(size=(2, 300, 4))
    whole = effort_metrics(torque, rate, DT)
    parts = [effort_metrics(torque[cut], rate[cut], DT) for cut in (slice(117), slice(117, None))]
    for name in ("impulse", "positive_work", "negative_work", "torque_cost", "work_cost"):
        added = getattr(parts[0], name) + getattr(parts[1], name)
        np.testing.assert_allclose(added, getattr(whole, name), rtol=1e-12)


def test_many_records_at_once_are_those_one_by_one():
    rng = np.random.default_rng(1)
    torque, rate = rng.normal(size=(2, 5, 3, 120, 4))
    together = effort_metrics(torque, rate, DT).to_dict()
    assert np.shape(together["rms"]) == (5, 3, 4)
    alone = effort_metrics(torque[4, 1], rate[4, 1], DT).to_dict()
    for name, value in alone.items():
        np.testing.assert_allclose(value, together[name][4][1], rtol=1e-12)


def test_smoothness_of_the_authors_example():
    # The example in the documentation of the authors' own implementation.
    time = np.arange(-1, 1, 0.01)
    assert spectral_arc_length(np.exp(-5 * time**2), 0.01) == pytest.approx(-1.41403, abs=5e-6)


@pytest.mark.parametrize(("amplitude", "duration"), [(1, 1), (0.2, 4)])
def test_jerk_of_a_minimum_jerk_movement(amplitude, duration):
    rate = amplitude / duration * minimum_jerk_rate(4001)
    # 720 A² / D⁵ is the integral of its squared jerk, 1.875 A / D its peak speed.
    expected = -np.log(720 / 1.875**2)
    assert log_dimensionless_jerk(rate, duration / 4000) == pytest.approx(expected, abs=2e-3)


def test_submovements_and_tremor_are_less_smooth():
    one = minimum_jerk_rate(200)
    two = np.concatenate([minimum_jerk_rate(100)] * 2)
    trembling = one + 0.2 * np.sin(2 * np.pi * 9 * np.arange(200) * DT)
    for worse in (two, trembling):
        assert spectral_arc_length(np.abs(worse), DT) < spectral_arc_length(one, DT) - 0.1
        assert log_dimensionless_jerk(worse, DT) < log_dimensionless_jerk(one, DT) - 1
    np.testing.assert_allclose(spectral_arc_length(7 * one, DT), spectral_arc_length(one, DT))


def test_no_movement_has_no_smoothness():
    metrics = effort_metrics(np.ones((20, 1)), np.zeros((20, 1)), DT)
    assert np.isnan([metrics.spectral_arc_length, metrics.log_dimensionless_jerk]).all()
    assert metrics.impulse == pytest.approx(0.2)


def test_mistakes_are_named():
    rows = [
        (np.ones((5, 4)), np.ones((4, 4)), DT, r"shape \(5, 4\) and rate \(4, 4\).*same shape"),
        (np.full((9, 4), np.nan), np.ones((9, 4)), DT, "not finite"),
        (np.ones((9, 4)), np.ones((9, 4)), 0.0, "dt is 0.0.*above 0"),
    ]
    assert_refused(effort_metrics, rows)
