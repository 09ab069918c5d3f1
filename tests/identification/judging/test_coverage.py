"""What curves cover, what a motion needs beyond that, and the next record to measure."""

import numpy as np
import pytest
from activesuit.identification import Motion, coverage, motion_coverage, nested_motion, shortfalls
from activesuit.identification.data.motions import BRANCHES, SHORTEST
from activesuit.identification.judging.coverage import DEEP, any_motion, nesting_of
from helpers import along, assert_refused, sweep

LOW, HIGH = 0.52, 1.57


def motion(*points, rate=None, samples=50):
    angle = sweep(*points, samples=samples)
    if rate is None:
        return Motion(None, angle)
    return Motion(np.append(0, np.cumsum(np.abs(np.diff(angle)))) / rate, angle)


def first_order(rate=None):
    turns = (0.87, 1.22, HIGH)
    return motion_coverage(motion(LOW, turn, LOW, rate=rate) for turn in turns)


def record():
    found = nested_motion(LOW, HIGH)
    return motion_coverage([Motion(found.time, found.angle)])


def test_nesting_is_what_return_point_memory_remembers():
    for points, deepest in [
        ([0, 1], 0),
        ([0, 1, 0], 1),
        ([0, 1, 0, 2, 0, 3, 0], 1),  # first-order curves in one record
        ([0, 1, 0, 1, 0], 1),
        ([0, 1, -1, 1, -1], 1),
        ([0, 1, -2, 3, -4], 1),  # each swing forgets those inside
        ([0, 1, 0.5, 0.8], 2),
        ([0, 1, 0.5, 0.8, 0.5, 0.8, 0.5], 3),
        ([0, 1, 0.5, 0.8, 0.6, 1], 4),
        ([0, 1, 0.5, 0.9, 0.4, 0.8, 0.3, 0.7], 3),  # passing 0.5 forgets 0.5 and 0.9
        ([1, 0, 0.5, 0.2], 2),
    ]:
        assert nesting_of(points) == deepest
        assert motion_coverage([motion(*points)]).nesting == deepest
        assert nesting_of([-point for point in points]) == deepest


def test_first_order_curves(elbow):
    found = first_order(rate=0.1)
    assert found.range == (LOW, HIGH)
    assert (found.reversals, found.nesting, found.cycles) == (3, 1, 1)
    assert found.branches == pytest.approx((1 / 3, 2 / 3, 1.0))
    assert found.rates == pytest.approx((0.1, 0.1))
    assert first_order().rates is None
    some = [motion(LOW, HIGH, LOW, rate=0.3), motion(LOW, 1.0, LOW)]
    assert motion_coverage(some).rates == pytest.approx((0.3, 0.3))
    curve = along(elbow, LOW, HIGH, LOW, time=np.arange(399) / 25)
    assert coverage([curve]) == motion_coverage([Motion(curve.time, curve.angle)])


def test_noise_and_pauses_are_no_reversals_and_no_rates():
    rng = np.random.default_rng(0)
    clean = motion(LOW, HIGH, 0.9, 1.2, rate=0.2, samples=400)
    paused = np.append(clean.angle, np.full(100, clean.angle[-1]))
    time = np.append(clean.time, clean.time[-1] + np.arange(1, 101) / 100)
    found = motion_coverage([Motion(time, paused + 2e-4 * rng.standard_normal(paused.size))])
    assert (found.reversals, found.nesting) == (2, 2)
    assert found.rates == pytest.approx((0.2, 0.2), rel=0.1)
    stepped = motion_coverage([Motion(time, 0.01 * np.round(paused / 0.01))])
    assert (stepped.reversals, stepped.nesting) == (2, 2)


def test_a_motion_that_has_just_turned_has_no_branch_there():
    found = motion_coverage([motion(1.0, 0.995, 1.01, 0, 1, 0.975, 0.994, rate=0.2)])
    assert found.branches[0] == pytest.approx(0.025 / 1.01)  # from 1 rad on, not the last 0.006
    assert found.rates == pytest.approx((0.2, 0.2))
    assert found.cycles == 1


def test_cycles_are_whole_ones():
    ways = ([0, 1, 0, 1, 0, 1, 0], [0, 1, 0.5, 1, 0.5, 1, 0], [0, 1])
    assert [motion_coverage([motion(*way)]).cycles for way in ways] == [3, 1, 0]


def test_what_is_covered_gets_no_remark():
    assert shortfalls(first_order(), first_order()) == []
    assert shortfalls(record(), any_motion(record())) == []
    assert shortfalls(record(), first_order(rate=0.4)) == []
    rising = motion_coverage([motion(LOW, HIGH, 1.0)])
    assert all(one.kind != "coverage cycles" for one in shortfalls(rising, first_order()))


def test_each_difference_that_matters_gets_one_remark():
    curves, fast = first_order(rate=0.1), motion(LOW, HIGH, LOW, rate=1.0)
    slow = first_order()
    rising = motion_coverage([motion(LOW, HIGH)])
    for measured, needed, kind, values in [
        (curves, motion(0.1, 1.9, 0.1), "coverage range", {"low": 0.1, "most": HIGH}),
        (curves, motion(LOW, HIGH, 0.9, 1.4, 0.97), "coverage nesting", {"deep": 3, "nesting": 1}),
        (curves, motion(LOW, HIGH, 1.47), "coverage branches", {"needed": 0.1}),
        (curves, fast, "coverage rates", {"rate": 1, "fastest": 0.1, "asked": 0.5}),
        (curves, motion(*[LOW, HIGH] * 3), "coverage cycles", {"needed": 2, "enough": 3}),
        (slow, fast, "coverage times", {"rate": 1}),
        (rising, motion(LOW, HIGH, LOW), "coverage nesting", {"nesting": 0}),
    ]:
        (found,) = shortfalls(measured, motion_coverage([needed]))
        assert found.kind == kind
        assert {name: found.values[name] for name in values} == pytest.approx(values)


def test_deeper_than_the_record_is_not_required():
    points = [LOW, HIGH]
    for i in range(1, 10):
        points += [LOW + 0.03 * i, HIGH - 0.03 * i]
    deep = motion_coverage([motion(*points)])
    assert deep.nesting > DEEP == record().nesting
    assert all(one.kind != "coverage nesting" for one in shortfalls(record(), deep))


def test_bad_motions():
    rows = [
        ([], "there is no motion: give at least one"),
        ([Motion(None, np.ones(3))], "stays at 1 rad"),
        ([Motion(None, np.array([0, np.nan]))], "angle"),
    ]
    assert_refused(motion_coverage, rows)


def test_reversals_come_nearer_from_both_ends_and_all_are_remembered():
    points = 4.5 * (np.array(nested_motion(-1, 1).points) + 1)
    np.testing.assert_allclose(points, [0, 9, 1, 8, 2, 7, 3, 6, 4, 5, 0], atol=1e-12)
    cover = record()
    assert (cover.nesting, cover.reversals) == (BRANCHES, len(points) - 2)
    assert cover.range == pytest.approx((LOW, HIGH))


def test_rates_are_kept_and_spread():
    for ends in [(LOW, HIGH), (HIGH, LOW), (-0.3, 0.1)]:
        found = nested_motion(*ends, min_rate=0.01, max_rate=0.35, sample_rate=50)
        assert found.angle[0] == found.angle[-1] == ends[0]
        assert [found.angle.min(), found.angle.max()] == pytest.approx(sorted(ends))
        assert found.time[0] == 0
        assert 0 < np.diff(found.time).min() <= np.diff(found.time).max() <= 1 / 50 + 1e-12
        rates = np.abs(np.diff(found.angle) / np.diff(found.time))
        assert rates.min() == pytest.approx(0.01)
        assert rates.max() == pytest.approx(0.35)
        assert len(set(found.rates)) == len(found.rates)
        ways = np.abs(np.diff(found.points))
        assert (ways / np.array(found.rates) >= SHORTEST - 1e-9).all()
        up = np.log(found.rates[::2]).mean() - np.log(found.rates[1::2]).mean()
        assert abs(up) < 0.7  # no direction is the fast one


def test_bad_designs():
    rows = [
        ((1.0, 1.0), {}, "from 1 to 1 rad: give two angles that differ"),
        ((0.0, 90.0), {}, "end is 90 rad, more than a full turn"),
        ((0.0, float("nan")), {}, "end is nan"),
        ((LOW, HIGH), {"min_rate": 0.0}, "min_rate is 0 rad/s: give a number above 0"),
        ((LOW, HIGH), {"max_rate": -1.0}, "max_rate is -1 rad/s"),
        ((LOW, HIGH), {"min_rate": 0.6}, "min_rate is 0.6 and max_rate 0.5 rad/s"),
        ((LOW, HIGH), {"sample_rate": 0.0}, "sample_rate is 0 Hz"),
        ((LOW, HIGH), {"sample_rate": 1e9}, "samples: give a smaller sample_rate than 1e"),
        ((LOW, HIGH), {"min_rate": 1e-5}, "s: give a larger min_rate than 1e-05"),
    ]
    assert_refused(lambda ends, options: nested_motion(*ends, **options), rows)
