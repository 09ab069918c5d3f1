"""The band over kinds of model: who is a member, how wide it is, and the models drawn of it."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import Suit
from activesuit.errors import InputError
from activesuit.hysteresis import Clipped
from activesuit.identification import Curve, first_order_motions, nested_motion, select
from activesuit.identification.fits.registry import FITS
from activesuit.identification.judging.ensemble import NEARLY, ensemble, excess
from activesuit.identification.judging.noise import estimate_noise, slow_noise
from helpers import along, assert_refused, sweep

START, END, NOISE = 0.52, 1.57, 0.1
TURNS = (0.73, 0.94, 1.15, 1.36, 1.57)


UNSEEN = sweep(0.52, 1.4, 0.8, 1.2, 0.9, samples=50)


def measured(model, *, nested=False):
    motions = first_order_motions(TURNS, start_angle=START, angle_step=0.015)
    if nested:
        points = np.array(nested_motion(START, END).points)
        motions["nested"] = np.interp(np.arange(0, 10.001, 0.025), np.arange(11), points)
    rng = np.random.default_rng(0)
    curves = []
    for name, angle in motions.items():
        noise = NOISE * rng.standard_normal(angle.size)
        curves.append(Curve(angle, model.response(angle) + noise, name))
    return curves


def covered(found, truth):
    """The share of a curve's own torque inside the band, and the band."""
    low, high = found.band(truth)
    return np.mean((low <= truth.torque) & (truth.torque <= high)), low, high


@pytest.fixture(scope="module")
def found(elbow):
    return select(measured(elbow, nested=True))


@pytest.mark.slow
def test_members_are_the_candidates_that_predict_nearly_as_well(found):
    members = {one.name: one for one in found.ensemble.members}
    least = min(one.error for one in members.values())
    for one in found.candidates:
        if one.name in members:
            assert members[one.name].model == one.model
            assert members[one.name].error <= NEARLY * least
    assert len(members) > 1
    assert found.fit.model_name in members
    assert sum(one.weight for one in members.values()) == pytest.approx(1)
    limits = [one.error**2 - least**2 + found.ensemble.excess**2 for one in members.values()]
    shares = [one.weight * limit**2 for one, limit in zip(members.values(), limits, strict=True)]
    assert shares == pytest.approx([shares[0]] * len(shares))


def test_the_band_holds_a_truth_in_the_class_and_is_narrow(found, elbow):
    truth = Curve(UNSEEN, elbow.response(UNSEEN), "unseen")
    inside, low, high = covered(found, truth)
    assert inside >= 0.9
    assert np.mean(high - low) / 2 < 1.5 * NOISE
    wide = found.band(truth, level=0.99)
    assert (wide[0] < low).all()
    assert (wide[1] > high).all()


def test_the_band_is_about_the_weighted_mean(found):
    curve = Curve(UNSEEN, 0 * UNSEEN, "unseen")
    low, high = found.band(curve)
    members = found.ensemble.members
    mean = sum(one.weight * one.model.response(UNSEEN, one.initial_torque) for one in members)
    np.testing.assert_allclose((low + high) / 2, mean, atol=1e-12)
    assert ((high - low) / 2 >= 1.644 * found.ensemble.excess).all()
    wider = found.ensemble.measured_band(curve)
    half = (wider[1] - wider[0]) / 2
    noise = 1.6449 * found.ensemble.noise.deviation
    np.testing.assert_allclose(half, np.hypot((high - low) / 2, noise), rtol=1e-3)


def test_first_order_curves_alone_give_a_band_along_first_order_curves_only(elbow):
    found = select(measured(elbow))
    assert not found.ensemble.tested
    assert found.ensemble.nested == ()
    members = {one.name for one in found.ensemble.members}
    for one in found.candidates:
        error = np.sqrt(np.mean(one.prediction_errors**2))
        assert (one.name in members) == (error <= NEARLY * found.ensemble.members[0].error)
    assert covered(found, along(elbow, 0.52, 1.2, 0.52, samples=50))[0] >= 0.9
    with pytest.raises(InputError, match="there is no band; measure also the"):
        found.band(Curve(UNSEEN, 0 * UNSEEN, "unseen"))


def test_excess_is_what_noise_does_not_explain():
    rng = np.random.default_rng(0)
    white = 0.1 * rng.standard_normal(400)
    noise = estimate_noise(np.ones((400, 1)), white, [400])
    assert excess(white, noise) < 0.06
    assert excess(3 * white, noise) == pytest.approx(np.sqrt(8) * 0.1, rel=0.1)
    slow = 0.1 * slow_noise(400, 0.9, rng)
    # Slow noise has few independent samples: less is known about what is left.
    known = estimate_noise(np.ones((400, 1)), slow, [400])
    assert excess(slow, known) > 1.3 * excess(white, noise)
    assert excess(np.zeros(400), noise) == 0


def test_drawn_models_are_of_all_kinds_by_weight(found, elbow):
    models = found.uncertainty(samples=9, seed=3).samples
    kinds = [(one.model if isinstance(one, Clipped) else one).name for one in models]
    counts = {one.name: 0 for one in found.ensemble.members} | {k: kinds.count(k) for k in kinds}
    assert len(models) == 9
    for one in found.ensemble.members:
        assert abs(counts[one.name] - 9 * one.weight) < 1
    assert all(one.certificate().certified for one in models)
    assert models == found.uncertainty(samples=9, seed=3).samples
    suit = Suit.from_fits({"elbow_flexion": found.fit}, samples={"elbow_flexion": models})
    assert len({type(one) for one in suit.joints["elbow_flexion"].samples}) > 1


def test_bad_input(found):
    curve, endless = found.fit.curves[0], replace(found, ensemble=None)
    rows = [
        (found, curve.angle, 0.9, r"curve is .*: give a Curve"),
        (endless, curve, 0.9, "every model meets its pole on the curves: there is no"),
        (found, curve, 0, "level is 0: give a share between 0 and 1"),
        (found, curve, 1, "level is 1: give a share between 0 and 1"),
        (found, curve, 90, "level is 90: give a share between 0 and 1"),
    ]
    assert_refused(lambda selection, *given: selection.band(*given), rows)
    assert endless.uncertainty(samples=0).names


@pytest.mark.slow
def test_a_candidate_that_cannot_predict_nested_loops_is_no_member(elbow, monkeypatch):
    fit_bouc_wen = FITS["bouc-wen"]

    def needs_all(curves, rng):
        if not any(curve.name == "nested" for curve in curves):
            raise InputError("nothing fits: measure again")
        return fit_bouc_wen(curves, rng=rng)

    curves = measured(elbow, nested=True)
    assert "bouc-wen" in {one.name for one in select(curves).ensemble.members}
    monkeypatch.setitem(FITS, "bouc-wen", needs_all)
    found = select([replace(one) for one in curves])
    assert "bouc-wen" not in {one.name for one in found.ensemble.members}


def test_candidates_that_meet_their_pole_make_no_ensemble(found):
    poles = [replace(one, prediction_nrmse=np.inf) for one in found.candidates]
    options = {"seed": 0, "options": {}}
    assert ensemble(poles, found.fit.curves, found.ensemble.noise, **options) is None
    assert ensemble(found.candidates, found.fit.curves, found.ensemble.noise, **options) is not None
