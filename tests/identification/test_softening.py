"""The change of a torque over the cycles of a measurement: found, removed, and saved in suits."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import SuitJoint
from activesuit.identification import Corrections, Curve, Curves, identify, select
from activesuit.identification.softening import Count
from helpers import sweep

FIT = Corrections(softening="fit")
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
    plain = identify([record(elbow, first)])
    assert ("softening", "fit") in [remark.option for remark in plain.remarks]
    fit = identify([record(elbow, first)], corrections=FIT)
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
    fit = identify([record(elbow)], corrections=FIT)
    joint = SuitJoint.from_fit(fit)
    new, used = joint.after(0).response([1.57])[0], joint.after(np.inf).response([1.57])[0]
    assert new / used == pytest.approx(1.2, abs=0.01)
    assert SuitJoint.from_fit(identify([record(elbow, 1.0)])).softening is None


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
    fit = identify(parts, corrections=FIT, initial_torque="measured")
    count = Count(Curves(parts))
    factor = fit.softening.factor(count(parts[1]))
    np.testing.assert_allclose(fit.curves[1].torque * factor, parts[1].torque)


def test_nothing_is_found_where_nothing_changes(elbow):
    for seed in range(5):
        fit = identify([record(elbow, 1.0, seed=seed)], corrections=FIT)
        assert fit.softening is None
        said = [one.sentence for one in fit.remarks if one.option == ("softening", "none")]
        assert said == ["no change from cycle to cycle was found"]


def test_a_change_that_is_not_complete_is_reported(elbow):
    fit = identify([record(elbow, first=1.5, cycles=10.0)], corrections=FIT)
    assert not fit.softening.is_complete
    assert any("is extrapolated: measure more cycles" in str(remark) for remark in fit.remarks)


def test_two_cycles_less_a_sample_are_two(elbow):
    whole = record(elbow, first=1.4, cycles=1.0)
    short = replace(whole, angle=whole.angle[: 4 * 59], torque=whole.torque[: 4 * 59])
    assert 1.99 < gone(short.angle)[-1] < 2
    assert identify([short], corrections=FIT).softening.first > 1.1


@pytest.mark.slow
def test_a_change_beyond_the_limits_of_a_suit_is_limited(elbow):
    angle = record(elbow, noise=0.0).angle
    gone_part = gone(angle) / gone(angle)[-1]
    curve = Curve(angle, elbow.response(angle) * (4 * (1 - gone_part) + 0.05), "record")
    fit = identify([curve], corrections=FIT)
    assert fit.softening.first / fit.softening.steady == pytest.approx(9.99)
    assert SuitJoint.from_fit(fit).softening.first == fit.softening.first
    trebled = replace(curve, torque=elbow.response(angle) * (0.3 + 0.7 * gone_part))
    fit = identify([trebled], corrections=FIT)
    assert fit.softening.first == pytest.approx(0.3, abs=0.03)


@pytest.mark.slow
def test_every_kind_of_model_and_auto_take_it(elbow):
    one = identify([record(elbow)], model="bouc-wen", corrections=FIT)
    for fit in (one, select([record(elbow)], corrections=FIT).fit):
        assert fit.softening.first / fit.softening.steady == pytest.approx(1.2, abs=0.03)
