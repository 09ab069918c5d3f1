"""The choice among models: four truths, and what is said about it."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import Asymmetric, BoucWen, PrandtlIshlinskii, Preisach
from activesuit.identification import Curve, auto
from activesuit.identification.auto import first_torque, identify_auto
from helpers import sweep

START = 0.52
THREE, SIX = (0.87, 1.22, 1.57), (0.7, 0.87, 1.05, 1.22, 1.4, 1.57)
UNSEEN = (0.78, 1.0, 1.13, 1.3, 1.48)
NAMES = {"jiles-atherton", "asymmetric", "bouc-wen", "prandtl-ishlinskii", "preisach"}


def known_preisach():
    rng = np.random.default_rng(1)
    return Preisach(
        levels=np.linspace(0.4, 1.6, 9),
        density=[rng.uniform(0, 0.3, i + 1) for i in range(8)],
        elastic=rng.uniform(10, 15, 8),
    )


@pytest.fixture(scope="module")
def truths(elbow):
    return {
        "jiles-atherton": elbow,
        "bouc-wen": BoucWen(
            elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=START
        ),
        "prandtl-ishlinskii": PrandtlIshlinskii(
            stiffness=2.0,
            thresholds=[0.05, 0.1, 0.2, 0.35],
            weights=[20.0, 8.0, 4.0, 5.0],
            rest_angle=START,
        ),
        "preisach": known_preisach(),
        "asymmetric preisach": Asymmetric(model=known_preisach(), polynomial=[0.0, 1.5, -2.0, 1.5]),
    }


def peak(model):
    return np.abs(model.response(sweep(START, SIX[-1], START))).max()


def family(model, turns, noise=0.0, seed=0, start=0.0):
    rng = np.random.default_rng(seed)
    curves = []
    for turn in turns:
        angle = sweep(START, turn, START, samples=60)
        torque = model.response(angle, start)
        torque = torque + noise * peak(model) * rng.standard_normal(angle.size)
        curves.append(Curve(angle, torque, f"{turn}"))
    return curves


def held_out(candidate, truth, noise):
    """NRMSE on noisy curves with unseen turns."""
    curves = family(truth, UNSEEN, noise, seed=100)
    torques = [candidate.model.response(curve.angle, candidate.first_torque) for curve in curves]
    errors = [torque - curve.torque for torque, curve in zip(torques, curves, strict=True)]
    return np.sqrt(np.mean(np.concatenate(errors) ** 2)) / peak(truth)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("name", "turns"),
    [
        ("jiles-atherton", THREE),
        ("bouc-wen", THREE),
        ("prandtl-ishlinskii", THREE),
        ("preisach", SIX),
    ],
)
def test_the_truth_or_one_as_good_is_found_under_noise(truths, name, turns, seed):
    noise, truth = 0.01, truths[name]
    fit = identify_auto(family(truth, turns, noise, seed), seed=seed)
    found = held_out(fit, truth, noise)
    assert found <= 1.5 * noise
    table = {candidate.name: candidate for candidate in fit.candidates}
    assert set(table) == NAMES
    assert fit.name == name or found <= 1.1 * held_out(table[name], truth, noise)
    assert fit.model.certificate().certified
    assert fit.model.certificate().dissipative


@pytest.mark.parametrize("seed", range(3))
def test_a_truth_of_another_kind_is_predicted(truths, seed):
    noise, truth = 0.02, truths["asymmetric preisach"]
    fit = identify_auto(family(truth, SIX, noise, seed), seed=seed)
    assert held_out(fit, truth, noise) <= 1.3 * noise


def test_the_choice_follows_its_rule_and_says_so(truths):
    fit = identify_auto(family(truths["jiles-atherton"], THREE, 0.01))
    scores = [candidate.prediction_nrmse for candidate in fit.candidates]
    assert scores == sorted(scores)
    good = [one for one in fit.candidates if one.prediction_nrmse <= 1.1 * scores[0]]
    assert len(good) > 1
    assert fit.name == min(good, key=lambda one: one.parameters).name == "jiles-atherton"
    assert "jiles-atherton predicts curves left out of its fit" in fit.why
    parameters = {candidate.name: candidate.parameters for candidate in fit.candidates}
    assert parameters == {
        "jiles-atherton": 5,
        "bouc-wen": 6,
        "asymmetric": 9,
        "prandtl-ishlinskii": 22,
        "preisach": 230,
    }


def test_a_simpler_model_within_a_tenth_is_preferred(monkeypatch):
    truth = PrandtlIshlinskii(stiffness=9.0, thresholds=[1.0], weights=[0.0], rest_angle=START)
    curves = [Curve(c.angle, c.torque + 0.1, c.name) for c in family(truth, THREE)]
    # Their errors grow with the stiffness; the bent one has four parameters more.
    models = {
        "bent": Asymmetric(model=truth, polynomial=[0.0, 0.0, 0.0, 0.0]),
        "simple": truth.scaled(torque=0.999),
        "far": truth.scaled(torque=0.5),
    }
    fitters = {name: lambda curves, rng, m=m: m for name, m in models.items()}
    monkeypatch.setattr(auto, "CANDIDATES", fitters)
    monkeypatch.setattr(auto, "first_torque", lambda model, curves: 0.0)
    fit = identify_auto(curves)
    assert [one.name for one in fit.candidates] == ["bent", "simple", "far"]
    assert fit.name == "simple"
    assert "within 10 % of the best (bent," in fit.why
    assert "fewer parameters (3 instead of 7)" in fit.why


def test_a_candidate_that_fails_is_listed(truths, monkeypatch):
    def unusable(curves, rng):
        raise InputError("nothing fits: measure again")

    monkeypatch.setitem(auto.CANDIDATES, "bouc-wen", unusable)
    curves = family(truths["jiles-atherton"], THREE, 0.01)
    last = identify_auto(curves).candidates[-1]
    assert (last.name, last.reason, last.model) == ("bouc-wen", "nothing fits: measure again", None)
    for name in NAMES:
        monkeypatch.setitem(auto.CANDIDATES, name, unusable)
    with pytest.raises(InputError, match=r"no model could be fitted .*preisach: nothing fits"):
        identify_auto(curves)


def test_the_first_torque_is_known_better_than_its_sample(truths):
    truth = truths["preisach"]
    errors = []
    for seed in range(20):
        curves = family(truth, THREE, 0.01, seed, start=0.4)
        errors.append(first_torque(truth, curves) - 0.4)
    assert np.std(errors) < 0.2 * 0.01 * peak(truth)


def test_a_seed_fixes_the_result_and_other_roles_do_not_count(truths):
    curves = family(truths["bouc-wen"], THREE, 0.01)
    wrong = Curve(curves[0].angle, -curves[0].torque, "wrong", "predict")
    one, two = identify_auto(curves, seed=5), identify_auto([*curves, wrong], seed=5)
    assert one == two


def test_bad_input(truths):
    curves = family(truths["bouc-wen"], THREE)
    with pytest.raises(
        InputError, match=r"the number of curves with role 'fit' is 1: .* at least 2"
    ):
        identify_auto(curves[:1])
    with pytest.raises(InputError, match="seed is -1"):
        identify_auto(curves, seed=-1)
