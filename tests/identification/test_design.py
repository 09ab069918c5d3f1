"""The next record to measure: nested reversals of all depths, each branch at its own rate."""

import numpy as np
import pytest
from activesuit.hysteresis import Preisach
from activesuit.identification import (
    Curve,
    Motion,
    first_order_motions,
    fit_preisach,
    motion_coverage,
    nested_motion,
)
from activesuit.identification.design import BRANCHES, SHORTEST
from helpers import assert_refused

LOW, HIGH = 0.52, 1.57


def test_reversals_come_nearer_from_both_ends():
    points = 4.5 * (np.array(nested_motion(-1, 1).points) + 1)
    np.testing.assert_allclose(points, [0, 9, 1, 8, 2, 7, 3, 6, 4, 5, 0], atol=1e-12)
    np.testing.assert_allclose(np.abs(np.diff(points))[:BRANCHES], np.arange(9, 0, -1))


def test_every_depth_is_remembered():
    found = nested_motion(LOW, HIGH)
    cover = motion_coverage([Motion(found.time, found.angle)])
    assert cover.nesting == BRANCHES
    assert cover.range == pytest.approx((LOW, HIGH))
    assert cover.reversals == len(found.points) - 2


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


def test_it_shows_what_first_order_curves_do_not():
    # Three first-order curves leave most weights of this truth open, and with them inner loops.
    rng = np.random.default_rng(0)
    truth = Preisach(
        levels=np.linspace(LOW, HIGH, 9),
        density=[rng.uniform(0, 1.0, i + 1) for i in range(8)],
        elastic=rng.uniform(5, 9, 8),
    )
    motions = {
        **first_order_motions((0.9, 1.25, HIGH), start_angle=LOW, angle_step=0.02),
        "record": nested_motion(LOW, HIGH).angle[::5],
    }
    curves = [
        Curve(x, truth.response(x) + 0.02 * rng.standard_normal(x.size), name)
        for name, x in motions.items()
    ]
    angle = np.interp(np.arange(0, 6, 0.02), range(7), [LOW, 1.5, 0.8, 1.3, 0.9, 1.2, 0.6])
    few, more = (fit_preisach(some).response(angle) for some in (curves[:-1], curves))
    right = truth.response(angle)
    assert np.std(more - right) < 0.7 * np.std(few - right)


def test_mistakes():
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
