"""The choice among models: four truths, and what is said about it."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import Asymmetric, BoucWen, PrandtlIshlinskii, Preisach
from activesuit.identification import Curve, Motion, select
from activesuit.identification import selection as auto
from activesuit.identification.fits import registry as own_fits
from activesuit.identification.fits.certified import common_torque
from activesuit.identification.fits.registry import FITS
from activesuit.identification.judging.ensemble import agreement
from activesuit.identification.judging.sentences import DESCRIBES, NOT_BEYOND
from helpers import along, assert_refused, family, interrupt, is_safe, peak, prediction_error, sweep

START = 0.52
THREE, SIX = (0.87, 1.22, 1.57), (0.7, 0.87, 1.05, 1.22, 1.4, 1.57)
UNSEEN = (0.78, 1.0, 1.13, 1.3, 1.48)
NAMES = set(FITS)


def known_preisach():
    rng = np.random.default_rng(1)
    density = [rng.uniform(0, 0.3, i + 1) for i in range(8)]
    levels = np.linspace(0.4, 1.6, 9)
    return Preisach(levels=levels, density=density, elastic=rng.uniform(10, 15, 8))


@pytest.fixture(scope="module")
def truths(elbow):
    numbers = {"elastic": 2.0, "hysteretic": 15.0, "beta": 20.0, "gamma": 8.0, "n": 1.5}
    stops = {"thresholds": [0.05, 0.1, 0.2, 0.35], "weights": [20.0, 8.0, 4.0, 5.0]}
    return {
        "jiles-atherton": elbow,
        "bouc-wen": BoucWen(**numbers, rest_angle=START),
        "prandtl-ishlinskii": PrandtlIshlinskii(stiffness=2.0, **stops, rest_angle=START),
        "preisach": known_preisach(),
        "asymmetric preisach": Asymmetric(model=known_preisach(), polynomial=[0.0, 1.5, -2.0, 1.5]),
    }


def held_out(one, truth, share):
    begin = one.initial_torque
    return prediction_error(one.model, truth, UNSEEN, begin=begin, share=share, seed=100)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "turns", "seed", "noise"),
    [
        ("jiles-atherton", THREE, 0, 0.01),
        ("bouc-wen", THREE, 1, 0.01),
        ("prandtl-ishlinskii", THREE, 2, 0.01),
        ("preisach", SIX, 2, 0.01),
        ("asymmetric preisach", SIX, 0, 0.02),  # of no kind that is tried
    ],
)
def test_the_truth_or_one_as_good_is_found_under_noise(truths, name, turns, seed, noise):
    truth = truths[name]
    selection = select(family(truth, turns, share=noise, seed=seed), seed=seed)
    fit = selection.fit
    found = held_out(fit, truth, noise)
    assert found <= 1.5 * noise
    table = {candidate.name: candidate for candidate in selection.candidates}
    assert set(table) == NAMES
    best = held_out(table[name], truth, noise) if name in table else noise * 1.3 / 1.1
    assert fit.model_name == name or found <= 1.1 * best
    assert is_safe(fit.model)


def test_the_choice_follows_its_rule_and_says_so(truths):
    found = select(family(truths["jiles-atherton"], THREE, share=0.01))
    fit = found.fit
    scores = [candidate.prediction_nrmse for candidate in found.candidates]
    assert scores == sorted(scores)
    good = [one for one in found.candidates if one.prediction_nrmse <= 1.1 * scores[0]]
    assert len(good) > 1
    simplest = min(good, key=lambda one: one.parameters)
    assert fit.model_name == simplest.name == "jiles-atherton"
    assert fit.model == simplest.model
    assert fit.nrmse == pytest.approx(simplest.fit_nrmse)
    assert [trial.model for trial in fit.trials] == [fit.model]
    assert "jiles-atherton predicts data left out of its fit" in found.why
    counts = {one.name: one.parameters for one in found.candidates}
    one_state = {"jiles-atherton": 5, "bouc-wen": 6, "dahl": 6, "duhem": 7, "asymmetric": 9}
    many = {"prandtl-ishlinskii": 22, "hinged-stops": 23, "preisach": 230}
    assert counts == one_state | many


def test_a_simpler_model_within_a_tenth_is_preferred(monkeypatch):
    truth = PrandtlIshlinskii(stiffness=9.0, thresholds=[1.0], weights=[0.0], rest_angle=START)
    curves = [Curve(c.angle, c.torque + 0.1, c.name) for c in family(truth, THREE)]
    # Their errors grow with the stiffness; the bent one has four parameters more.
    models = {
        "bent": Asymmetric(model=truth, polynomial=[0.0, 0.0, 0.0, 0.0]),
        "simple": truth.scaled(torque=0.999),
        "far": truth.scaled(torque=0.5),
    }
    fits = {name: lambda curves, model=model: model for name, model in models.items()}
    for module in (auto, own_fits):
        monkeypatch.setattr(module, "FITS", fits)
    monkeypatch.setattr(own_fits, "common_torque", lambda model, curves: 0.0)
    found = select(curves)
    assert [one.name for one in found.candidates] == ["bent", "simple", "far"]
    assert found.fit.model_name == "simple"
    assert "within 10 % of the best (bent," in found.why
    assert "fewer parameters (3 instead of 7)" in found.why


def test_a_candidate_that_fails_is_listed(truths, monkeypatch):
    def unusable(curves, rng=None):
        raise InputError("nothing fits: measure again")

    monkeypatch.setitem(FITS, "bouc-wen", unusable)
    curves = family(truths["jiles-atherton"], THREE, share=0.01)
    last = select(curves).candidates[-1]
    assert (last.name, last.reason, last.model) == ("bouc-wen", "nothing fits: measure again", None)
    for name in NAMES:
        monkeypatch.setitem(FITS, name, unusable)
    with pytest.raises(InputError, match=r"no model could be fitted .*duhem: nothing fits"):
        select(curves)


def test_the_first_torque_is_known_better_than_its_sample(truths):
    truth = truths["preisach"]
    families = [family(truth, THREE, share=0.01, seed=seed, first=0.4) for seed in range(20)]
    assert np.std([common_torque(truth, one) for one in families]) < 0.2 * 0.01 * peak(truth)


def test_a_model_never_begins_outside_its_certificate(elbow):
    torque = common_torque(elbow, [along(elbow, START, 1.2, START, first=8.0)])
    assert torque < 8
    assert elbow.start_is_certified(elbow.start(START, torque))
    assert not elbow.start_is_certified(elbow.start(START, torque + 0.02))


@pytest.mark.slow
def test_a_seed_fixes_the_result_and_neither_workers_nor_other_roles_count(truths):
    curves = family(truths["bouc-wen"], THREE, share=0.01)
    wrong = Curve(curves[0].angle, -curves[0].torque, "wrong", "predict")
    one = select(curves, seed=5)
    two = select([*curves, wrong], seed=5, workers=1)
    assert two.candidates == one.candidates
    assert two.fit.prediction_errors["wrong"] > 1
    assert replace(two.fit, prediction_errors={}) == one.fit


def test_curves_that_begin_with_some_torque(truths):
    # Only when asked to does Jiles-Atherton begin elsewhere than at zero.
    curves = family(truths["jiles-atherton"], THREE, share=0.005, first=0.6)
    scores = {}
    for option in (None, "identified"):
        tried = select(curves, initial_torque=option).candidates
        scores[option] = {one.name: one.prediction_nrmse for one in tried}
    assert scores["identified"]["jiles-atherton"] < 0.5 * scores[None]["jiles-atherton"]
    assert scores["identified"]["bouc-wen"] == scores[None]["bouc-wen"]


def test_bad_input(truths):
    curves = family(truths["bouc-wen"], THREE)
    rows = [
        (curves[:1], {}, r"there is one curve with role 'fit'.*or 2 curves"),
        (curves, {"seed": -1}, "seed is -1"),
        (curves, {"initial_torque": "measured"}, r"initial_torque is 'measured'.*identify it"),
    ]
    assert_refused(lambda given, options: select(given, **options), rows)


def test_ctrl_c_keeps_the_models_tried(truths, monkeypatch):
    curves = family(truths["jiles-atherton"], THREE, share=0.01)
    whole = select(curves)
    assert not whole.fit.interrupted
    monkeypatch.setitem(FITS, "bouc-wen", interrupt)
    found = select(curves, workers=1)
    assert found.fit.interrupted
    assert {one.name for one in found.candidates} < set(NAMES)
    assert found.fit.model == whole.fit.model  # the first that is tried
    assert "interrupted after" in found.why
    monkeypatch.setitem(FITS, "jiles-atherton", interrupt)
    with pytest.raises(KeyboardInterrupt):
        select(curves, workers=1)


def test_outliers_stop_no_fit(truths):
    """Where a pole or a model that cannot begin as measured is met on the way."""
    rng, spoiled = np.random.default_rng(0), []
    for curve in family(truths["jiles-atherton"], THREE, share=0.01):
        torque = curve.torque.copy()
        torque[rng.integers(0, torque.size, 5)] += 50 * rng.choice([-1, 1], 5)
        torque[0] = -25
        spoiled.append(replace(curve, torque=torque))
    found = select(spoiled)
    assert all(one.model or "cannot begin" in one.reason for one in found.candidates)
    assert np.isfinite(found.fit.nrmse)


@pytest.mark.slow
def test_the_verdict_extends_to_loops_on_which_a_tested_band_is_narrow(elbow):
    given = {"noise": 0.05, "rng": np.random.default_rng(0), "samples": 60}
    curves = [along(elbow, 0.52, top, 0.52, name=f"{top}", **given) for top in (1.0, 1.3, 1.57)]
    curves.append(along(elbow, 0.52, 1.5, 0.7, 1.3, 0.9, name="loops", **given))
    deeper = Motion(None, sweep(0.52, 1.55, 0.6, 1.45, 0.7, 1.35, 0.8, 1.2, 0.95))
    found = select(curves, intended=[deeper])
    assert found.fit.shortfalls  # seven reversals within each other, the curves have three
    assert found.fit.verdict == DESCRIBES
    assert found.agreement.tested and found.agreement.half_width < 0.05 * found.fit.curves.peak
    assert found.agreement.remark.values["by"] == "curve 'loops'"
    farther = select(curves, intended=[deeper, Motion(None, sweep(0.52, 1.7))])
    assert farther.fit.verdict == NOT_BEYOND  # a band says nothing outside the range
    alone = select(curves[:3], intended=[deeper])
    assert alone.fit.verdict == NOT_BEYOND
    assert not alone.agreement.tested
    turned = agreement(alone.ensemble, [Motion(None, np.array([0.0, 7.0]))], 5.0)
    assert turned.remark.kind == "agreement unknown"
    assert agreement(alone.ensemble, [Motion(None, np.zeros(3))], 5.0) is None
