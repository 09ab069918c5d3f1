"""Effort and fatigue of the wearer against published equations and numbers."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.person import fatigue
from activesuit.envs.person.effort import (
    effort_metrics,
    log_dimensionless_jerk,
    spectral_arc_length,
)
from activesuit.envs.person.fatigue import PROVENANCE, endurance_time, loaded, tired
from helpers import assert_refused
from numba import vectorize

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


REGIONS = ("shoulder", "shoulder", "elbow", "grip")  # of `JOINTS`
LOADS = [0.1, 0.2, 0.3, 0.5, 0.7]
VALUE = {quantity.name: quantity.value for quantity in PROVENANCE}
COLUMNS = ("fatigue_rate", "recovery_rate", "rest_multiplier")
RATES = np.array([[VALUE[f"fatigue.{region}.{c}"] for region in REGIONS] for c in COLUMNS])
RESTED = np.zeros((2, 4))
step = vectorize(tired.py_func)


def fatigue_step(fatigued, load, dt):
    """Returns the fatigued part of every muscle group, shape (..., 2, 4)."""
    return step(fatigued, load, *fatigue.RATES, dt)


def original_3cc_r(load, dt):
    """The fatigued parts at all joints, by Euler steps of the published equations."""
    tiring, recovery, multiplier = RATES
    active, resting, fatigued, history = np.zeros(4), np.ones(4), np.zeros(4), []
    for target in load:
        missing = target - active
        drive = 10 * np.where(missing > 0, np.minimum(missing, resting), missing)
        back = recovery * np.where(target <= 0.01, multiplier, 1) * fatigued
        tires = tiring * active
        active = active + dt * (drive - tires)
        resting = resting + dt * (back - drive)
        fatigued = fatigued + dt * (tires - back)
        history.append(fatigued)
    return np.array(history)


@pytest.mark.parametrize(
    ("joint", "seconds"),
    [
        ("shoulder_flexion", [1057, 274, 144, 57.6, 24.0]),
        ("elbow_flexion", [2794, 565, 293, 116, 48.1]),
    ],
)
def test_endurance_times_at_five_loads(joint, seconds):
    np.testing.assert_allclose(endurance_time(LOADS, joint), seconds, rtol=3e-3)


def test_endurance_is_infinite_for_what_recovery_sustains():
    for joint, tiring, recovery in zip(JOINTS, *RATES[:2], strict=True):
        bearable = recovery / (tiring + recovery)
        assert endurance_time([0, bearable / 2], joint).tolist() == [np.inf, np.inf]
        assert np.isfinite(endurance_time(bearable * 1.01, joint))
        assert endurance_time(1, joint) == 0


def test_a_simulated_hold_ends_at_the_endurance_time():
    dt, loads = 1.0, LOADS[:3]
    load = np.broadcast_to(np.reshape(loads, (-1, 1, 1)), (len(loads), 2, 4))
    expected = np.stack([endurance_time(loads, joint) for joint in JOINTS], axis=-1)
    endured, fatigued = np.zeros(load.shape), np.zeros(load.shape)
    for _ in range(int(expected.max() / dt) + 2):
        fatigued = fatigue_step(fatigued, load, dt)
        endured += dt * (1 - fatigued >= load)
    for direction in (0, 1):
        np.testing.assert_allclose(endured[:, direction], expected, rtol=0.01)


def test_it_is_the_original_model_without_the_controllers_lag():
    dt = 0.02
    time = np.arange(0, 300, dt)
    load = np.where(time % 20 < 10, 0.5 + 0.4 * np.sin(time / 40), 0.0)
    load[time > 200] = 0.15
    fatigued, history = RESTED, []
    for target in load:
        fatigued = fatigue_step(fatigued, np.full((2, 4), target), dt)
        history.append(fatigued[1])
    original = original_3cc_r(load, dt)
    largest = original.max(axis=0)
    assert (largest > 0.25).all()
    # A lag of 0.1 s keeps that much of the strongest flow from one compartment to another.
    tiring, recovery, multiplier = RATES
    lag = 0.1 * (tiring * load.max() + multiplier * recovery * largest)
    assert (np.abs(history - original).max(axis=0) < lag).all()


def test_a_step_is_exact_for_any_length():
    rng = np.random.default_rng(0)
    load, start = rng.uniform(0, 1.2, (100, 2, 4)), rng.uniform(0, 1, (100, 2, 4))
    load[:20] = 0
    load[20:40], start[20:40] = 0.03, 0.999
    fine = start
    for _ in range(2000):
        fine = fatigue_step(fine, load, 0.1)
    coarse = fatigue_step(start, load, 200.0)
    assert 0 <= coarse.min() <= coarse.max() <= 1
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-12)
    ceiling = 1 - load
    assert ((start < ceiling) & (coarse > ceiling)).sum() > 50  # gave up on the way
    assert ((start > ceiling) & (coarse < ceiling)).sum() > 50  # recovered on the way


def test_what_a_lasting_maximum_leaves_and_recovery_is_faster_only_at_rest():
    start = np.full((2, 4), 0.4)
    tiring, recovery, multiplier = RATES
    left = 1 - fatigue_step(RESTED, np.ones((2, 4)), 1e5)[0]
    np.testing.assert_allclose(left, recovery / (tiring + recovery), rtol=1e-12)
    rested = fatigue_step(start, RESTED, 30.0)
    np.testing.assert_allclose(rested[0], 0.4 * np.exp(-30 * multiplier * recovery), rtol=1e-12)
    working = fatigue_step(start, np.full((2, 4), 0.02), 30.0)
    assert (working > 0.4 * np.exp(-30 * recovery)).all()


def test_load_is_the_share_of_strength():
    found = [loaded(*pair) for pair in ((10.0, 40.0), (-10.0, 40.0), (0.0, 0.0), (3.0, 0.0))]
    assert found == [0.25, 0.0, 0.0, 1.0]


def test_mistakes_are_named():
    rows = [
        (0.3, "elbow", "unknown joint 'elbow'.*elbow_flexion"),
        (30, "elbow_flexion", "load is 30.*from 0 to 1"),
        ([0.1, np.nan], "elbow_flexion", "load is .*nan.*from 0 to 1"),
    ]
    assert_refused(endurance_time, rows)
    rows = [
        (np.ones((5, 4)), np.ones((4, 4)), DT, r"shape \(5, 4\) and rate \(4, 4\).*same shape"),
        (np.full((9, 4), np.nan), np.ones((9, 4)), DT, "not finite"),
        (np.ones((9, 4)), np.ones((9, 4)), 0.0, "dt is 0.0.*above 0"),
    ]
    assert_refused(effort_metrics, rows)
