"""Corrections: the offset of the torque sensor, softening, and the mean of repeated cycles."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import SuitJoint
from activesuit.hysteresis import Viscoelastic
from activesuit.identification import (
    Corrections,
    Curve,
    Curves,
    averaged_cycles,
    fit_curves,
    select,
)
from activesuit.identification.corrections.cycles import cycles_of
from activesuit.identification.corrections.softening import Count
from activesuit.identification.figures import compared, loops_plot
from helpers import along, assert_refused, family, sweep

TARE = Corrections(tare="fit")
OFFSET, NOISE = 1.3, 0.05


def offset_family(model, offset=OFFSET, noise=NOISE):
    curves = family(model, noise=noise, seed=2, samples=200)
    return [replace(one, torque=one.torque + offset) for one in curves]


@pytest.mark.parametrize(
    "tare", ["fit", *(pytest.param(one, marks=pytest.mark.slow) for one in (OFFSET, "zero"))]
)
def test_the_offset_is_taken_off(elbow, tare):
    fit = fit_curves(offset_family(elbow), corrections=Corrections(tare=tare))
    assert fit.tare == pytest.approx(OFFSET, abs=0.15 if tare == "zero" else 0.03)
    assert fit.judgement.causes == () or tare == "zero"
    assert fit.nrmse * 7 < 1.6 * NOISE
    np.testing.assert_allclose(fit.curves[0].torque, offset_family(elbow)[0].torque - fit.tare)
    assert fit.nrmse < fit_curves(offset_family(elbow)).nrmse / 2


def test_a_fitted_offset_of_nothing_is_nothing(elbow):
    assert abs(fit_curves(offset_family(elbow, 0.0), corrections=TARE).tare) < 0.03


@pytest.mark.slow
def test_auto_takes_the_offset_of_jiles_atherton_where_no_other_model_is_as_good(elbow):
    fit = select(offset_family(elbow, noise=NOISE / 20), corrections=TARE).fit
    assert fit.tare == pytest.approx(OFFSET, abs=0.003)
    assert fit.model_name == "jiles-atherton"


@pytest.mark.slow
def test_auto_takes_no_offset_that_a_model_as_good_leaves_open(elbow):
    tried = []
    found = select(offset_family(elbow), corrections=TARE, on_candidate=tried.append)
    assert found.fit.tare == 0
    assert found.fit.remarks[0].code == "open"
    assert found.fit.remarks[0].values["tare"] == pytest.approx(OFFSET, abs=0.03)
    plain = select(offset_family(elbow))
    assert found.fit.model == plain.fit.model
    assert found.fit.remarks[1:] == plain.fit.remarks
    assert sorted(one.name for one in tried) == sorted(2 * [one.name for one in plain.candidates])
    assert plain.uncertainty().offset_open == (plain.fit.model_name,)


@pytest.mark.slow
def test_the_deviation_of_the_offset_is_that_of_its_estimates(elbow):
    found = []
    for offset in np.linspace(-1, 1, 8):
        fit = fit_curves(offset_family(elbow, offset), corrections=TARE)
        term = fit.uncertainty().offset
        assert abs(term.value) < 0.1 * term.deviation + 1e-3 * 7  # the fit has taken it off
        found.append(term.deviation)
        assert abs(fit.tare - offset) < 4 * term.deviation + 1e-3 * 7
    assert np.std(found) < 0.2 * np.mean(found)


def test_a_spring_with_a_rest_angle_leaves_the_offset_open(elbow):
    found = fit_curves(offset_family(elbow), model="bouc-wen").uncertainty()
    assert found.offset is None
    assert found.left_open[0] == "an offset of the torque sensor, if it was not zeroed"
    assert found.offset_open == ("bouc-wen",)
    assert fit_curves(offset_family(elbow, 0.0)).uncertainty().offset_open == ()
    assert "the curves have no times" in found.left_open[1]


def test_the_figure_shows_the_curves_that_were_fitted(elbow):
    angle = sweep(0.52, 1.57, 0.52, samples=60)
    curves = [Curve(angle, elbow.response(angle) + 1.3, "A")]
    fit = fit_curves(curves, corrections=Corrections(tare=1.3))
    plot = loops_plot("elbow", {"certified": compared(fit.curves, fit)}, fit.tare)
    loops, residuals = plot.panels  # nothing was kept out of the fit, so there is no panel for it
    measured, modeled = loops.marks
    np.testing.assert_allclose(measured.y, modeled.y, atol=0.01)
    assert max(np.abs(one.y).max() for one in residuals.marks) < 0.01
    assert "1.3 N·m of the sensor" in loops.y


SOFTENING = Corrections(softening="fit")
TURNS = (0.52, *(1.57, 0.52) * 4, *(1.2, 0.7) * 4)


def gone(angle):
    """Returns the cycles up to each sample of a motion over its own range."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))]) / (2 * np.ptp(angle))


def record(model, first=1.2, cycles=2.0, noise=0.01, seed=0):
    """Returns a long record whose torque is `first` times the steady one at its beginning."""
    angle = sweep(*TURNS, samples=60)[1:]
    torque = model.response(angle) * (1 + (first - 1) * np.exp(-gone(angle) / cycles))
    errors = noise * np.abs(torque).max() * np.random.default_rng(seed).standard_normal(angle.size)
    return Curve(angle, torque + errors, "record")


@pytest.mark.parametrize("first", [1.2, 0.9])
def test_the_change_is_found_and_the_model_describes_the_rest(elbow, first):
    plain = fit_curves([record(elbow, first)])
    assert ("softening", "fit") in [remark.option for remark in plain.remarks]
    fit = fit_curves([record(elbow, first)], corrections=SOFTENING)
    found = fit.softening
    assert found.first / found.steady == pytest.approx(first, abs=0.01)
    assert found.cycles == pytest.approx(2, rel=0.25)
    assert fit.verdict.startswith("describes")
    assert not fit.judgement.causes
    assert fit.nrmse < 0.7 * plain.nrmse
    steady = fit.model.scaled(torque=found.steady)
    angle = np.linspace(0.52, 1.57)
    off = steady.response(angle) - elbow.response(angle)
    assert np.abs(off).max() < 0.01 * np.ptp(elbow.response(angle))


def test_a_suit_of_the_fit_softens(elbow):
    fit = fit_curves([record(elbow)], corrections=SOFTENING)
    joint = SuitJoint.from_fit(fit)
    new, used = joint.after(0).response([1.57])[0], joint.after(np.inf).response([1.57])[0]
    assert new / used == pytest.approx(1.2, abs=0.01)
    assert SuitJoint.from_fit(fit_curves([record(elbow, 1.0)])).softening is None


def test_curves_in_their_order_count_on(elbow):
    whole = record(elbow)
    half = whole.angle.size // 2
    parts = [
        replace(whole, angle=whole.angle[here], torque=whole.torque[here], name=name)
        for name, here in (("A", slice(half + 1)), ("B", slice(half, None)))
    ]
    count, one = Count(Curves(parts)), Count(Curves([whole]))
    assert count.total == pytest.approx(one.total, abs=0.01)
    assert count(parts[1])[0] == pytest.approx(count(parts[0])[-1])


def test_a_curve_that_tests_the_model_is_freed_from_the_change_too(elbow):
    whole = record(elbow, noise=0.001)
    parts = []
    for name, turns in (("fit", slice(0, 12 * 59 + 1)), ("predict", slice(12 * 59, None))):
        parts.append(Curve(whole.angle[turns], whole.torque[turns], name, name))
    fit = fit_curves(parts, corrections=SOFTENING, initial_torque="measured")
    count = Count(Curves(parts))
    factor = fit.softening.factor(count(parts[1]))
    np.testing.assert_allclose(fit.curves[1].torque * factor, parts[1].torque)


def test_nothing_is_found_where_nothing_changes(elbow):
    for seed in range(5):
        fit = fit_curves([record(elbow, 1.0, seed=seed)], corrections=SOFTENING)
        assert fit.softening is None
        assert "softening none" in [one.kind for one in fit.remarks]


def test_a_change_that_is_not_complete_is_reported(elbow):
    fit = fit_curves([record(elbow, first=1.5, cycles=10.0)], corrections=SOFTENING)
    assert not fit.softening.is_complete
    assert "softening incomplete" in [one.kind for one in fit.remarks]


def test_two_cycles_less_a_sample_are_two(elbow):
    whole = record(elbow, first=1.4, cycles=1.0)
    short = replace(whole, angle=whole.angle[: 4 * 59], torque=whole.torque[: 4 * 59])
    assert 1.99 < gone(short.angle)[-1] < 2
    assert fit_curves([short], corrections=SOFTENING).softening.first > 1.1


@pytest.mark.slow
def test_a_change_beyond_the_limits_of_a_suit_is_limited(elbow):
    angle = record(elbow, noise=0.0).angle
    gone_part = gone(angle) / gone(angle)[-1]
    curve = Curve(angle, elbow.response(angle) * (4 * (1 - gone_part) + 0.05), "record")
    fit = fit_curves([curve], corrections=SOFTENING)
    assert fit.softening.first / fit.softening.steady == pytest.approx(9.99)
    assert SuitJoint.from_fit(fit).softening.first == fit.softening.first
    trebled = replace(curve, torque=elbow.response(angle) * (0.3 + 0.7 * gone_part))
    fit = fit_curves([trebled], corrections=SOFTENING)
    assert fit.softening.first == pytest.approx(0.3, abs=0.03)


@pytest.mark.slow
def test_every_kind_of_model_and_auto_take_it(elbow):
    one = fit_curves([record(elbow)], model="bouc-wen", corrections=SOFTENING)
    for fit in (one, select([record(elbow)], corrections=SOFTENING).fit):
        assert fit.softening.first / fit.softening.steady == pytest.approx(1.2, abs=0.03)


WHITE = 0.1


def cycled(model, cycles, *, last=(), jitter=0.0):
    rng = np.random.default_rng(0)
    angle = sweep(0.52, *[1.57, 0.52] * cycles, *last, samples=120)
    time = np.linspace(0, 4 * cycles, angle.size)
    torque = model.response(angle, **{"time": time} if isinstance(model, Viscoelastic) else {})
    noisy = torque + WHITE * rng.standard_normal(angle.size)
    return Curve(angle + jitter * rng.standard_normal(angle.size), noisy, "r", time=time)


def test_the_mean_of_later_cycles_follows_the_first(elbow):
    long = cycled(elbow, 9)
    (short,) = averaged_cycles([long])
    assert cycles_of(long) == 8
    first = 2 * 119 + 1
    np.testing.assert_array_equal(short.torque[:first], long.torque[:first])
    assert short.angle.size == 2 * first - 1
    assert (short.angle.min(), short.angle.max()) == pytest.approx((0.52, 1.57))
    assert np.all(np.diff(short.time) > 0)
    assert short.time[-1] == pytest.approx(2 * long.time[-1] / 9, rel=0.01)
    left = short.torque - elbow.response(short.angle)
    assert np.std(left[first:]) == pytest.approx(WHITE / np.sqrt(8), rel=0.2)
    assert np.std(left[:first]) == pytest.approx(WHITE, rel=0.2)


def test_the_rate_is_kept(elbow):
    short = averaged_cycles([cycled(Viscoelastic(model=elbow, damping=0.5), 6)])
    fit = fit_curves(short, corrections=Corrections(rate="viscous"))
    assert fit.model.damping == pytest.approx(0.5, rel=0.3)


def test_a_branch_that_is_not_whole_is_dropped(elbow):
    whole, cut = (averaged_cycles([cycled(elbow, 4, last=last)])[0] for last in ((), (1.1,)))
    assert whole.angle.size == cut.angle.size


def test_what_is_no_repeated_cycle_is_refused(elbow):
    uneven = along(elbow, 0.52, 1.57, 0.52, 1.57, 0.52, 1.2, 0.52, 1.57, 0.52)
    rows = [
        (cycled(elbow, 2), "has 4 branches: an average needs at least 6"),
        (uneven, r"turns between 1\.2 and 1\.57 rad on one side"),
    ]
    assert_refused(lambda curve: averaged_cycles([curve]), rows)


def test_names_roles_and_sources_stay(elbow):
    kept = averaged_cycles([replace(cycled(elbow, 4), role="predict", weight=2.0)])
    assert (kept[0].name, kept[0].role, kept[0].weight) == ("r", "predict", 2.0)
