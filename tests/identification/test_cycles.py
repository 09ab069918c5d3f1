"""The mean of the cycles of a record."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import Viscoelastic
from activesuit.identification import Corrections, Curve, averaged_cycles, identify
from activesuit.identification.cycles import cycles_of
from helpers import along, assert_refused, sweep

NOISE = 0.1


def record(model, cycles, *, last=(), jitter=0.0):
    rng = np.random.default_rng(0)
    angle = sweep(0.52, *[1.57, 0.52] * cycles, *last, samples=120)
    time = np.linspace(0, 4 * cycles, angle.size)
    torque = model.response(angle, **{"time": time} if isinstance(model, Viscoelastic) else {})
    noisy = torque + NOISE * rng.standard_normal(angle.size)
    return Curve(angle + jitter * rng.standard_normal(angle.size), noisy, "r", time=time)


def test_the_mean_of_later_cycles_follows_the_first(elbow):
    long = record(elbow, 9)
    (short,) = averaged_cycles([long])
    assert cycles_of(long) == 8
    first = 2 * 119 + 1
    np.testing.assert_array_equal(short.torque[:first], long.torque[:first])
    assert short.angle.size == 2 * first - 1
    assert (short.angle.min(), short.angle.max()) == pytest.approx((0.52, 1.57))
    assert np.all(np.diff(short.time) > 0)
    assert short.time[-1] == pytest.approx(2 * long.time[-1] / 9, rel=0.01)
    left = short.torque - elbow.response(short.angle)
    assert np.std(left[first:]) == pytest.approx(NOISE / np.sqrt(8), rel=0.2)
    assert np.std(left[:first]) == pytest.approx(NOISE, rel=0.2)


def test_a_fit_to_the_mean_is_that_of_the_record(elbow):
    short = averaged_cycles([record(elbow, 12, jitter=1e-3)])
    fit = identify(short)
    unseen = sweep(0.52, 1.2, 0.7, 1.4, 0.52)
    assert fit.model.response(unseen) == pytest.approx(elbow.response(unseen), abs=0.08)


def test_the_rate_is_kept(elbow):
    short = averaged_cycles([record(Viscoelastic(model=elbow, damping=0.5), 6)])
    fit = identify(short, corrections=Corrections(rate="viscous"))
    assert fit.model.damping == pytest.approx(0.5, rel=0.3)


def test_a_branch_that_is_not_whole_is_dropped(elbow):
    whole, cut = (averaged_cycles([record(elbow, 4, last=last)])[0] for last in ((), (1.1,)))
    assert whole.angle.size == cut.angle.size


def test_what_is_no_repeated_cycle_is_refused(elbow):
    rows = [
        (record(elbow, 2), "has 4 branches: an average needs at least 6"),
        (
            along(elbow, 0.52, 1.57, 0.52, 1.57, 0.52, 1.2, 0.52, 1.57, 0.52),
            r"turns between 1\.2 and 1\.57 rad on one side",
        ),
    ]
    assert_refused(lambda curve: averaged_cycles([curve]), rows)


def test_names_roles_and_sources_stay(elbow):
    kept = averaged_cycles([replace(record(elbow, 4), role="predict", weight=2.0)])
    assert (kept[0].name, kept[0].role, kept[0].weight) == ("r", "predict", 2.0)
