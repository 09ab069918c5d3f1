"""The losses that a fit of Jiles-Atherton parameters minimizes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton
from activesuit.identification import Curve, CurveObjective
from activesuit.identification.data.curves import noise_floor
from helpers import TABLE_2, assert_refused, family
from scipy.optimize import minimize

ROWS = np.array([TABLE_2["elbow-sa-pso"], TABLE_2["elbow-mpso"]])
POLE = [22.0, 30.0, 9.0, 6.0, 20.0]
NOISE = 0.057  # [N·m], 1 % of the peak
LOSSES = ("nrmse", "paper", "sse", "robust")


@pytest.fixture(scope="module")
def unequal(small_family):
    """Curves of different weight and torque."""
    weights = (2.0, 0.5, 7.0, 1.0)
    return [replace(one, weight=w) for one, w in zip(small_family, weights, strict=True)]


def transcribed(loss, normalize, curves, row):
    """One loss of one row, term by term as printed, for weights of any mean."""
    N = sum(curve.torque.size for curve in curves)
    Tmax = max(abs(T) for curve in curves for T in curve.torque)
    mean_weight = sum(curve.weight * curve.torque.size for curve in curves) / N
    d = 1.345 * noise_floor(curves)
    Ms, a, alpha, c, k = row
    model = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    total = 0.0
    for curve in curves:
        peak = max(abs(T) for T in curve.torque) if normalize == "curve" else Tmax
        for Tc, Tm in zip(model.response(curve.angle), curve.torque, strict=True):
            E = Tc - Tm
            robust = 2 * (math.sqrt(1 + (E / d) ** 2) - 1) * (d / peak) ** 2
            term = {"sse": E**2, "robust": robust}.get(loss, (E / peak) ** 2)
            total += curve.weight / mean_weight * term
    return {"paper": math.sqrt(total) / N, "sse": total}.get(loss, math.sqrt(total / N))


@pytest.mark.parametrize("normalize", ["family", "curve"])
def test_losses_are_their_equations(unequal, normalize):
    for loss in LOSSES if normalize == "family" else ("nrmse", "paper", "robust"):
        objective = CurveObjective(unequal, loss=loss, normalize=normalize)
        expected = [transcribed(loss, normalize, unequal, row) for row in ROWS]
        np.testing.assert_allclose(objective(ROWS), expected, rtol=1e-9)
        np.testing.assert_allclose(objective(ROWS[1]), expected[1:], rtol=1e-9)
        assert objective.evaluations == 3


def test_parameters_with_a_pole_score_infinity(small_family):
    for loss in LOSSES:
        scores = CurveObjective(small_family, loss=loss)([POLE, ROWS[0]])
        assert scores[0] == math.inf
        assert np.isfinite(scores[1])
        assert CurveObjective(small_family, loss=loss).nrmse(POLE) == math.inf


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("loss", LOSSES)
def test_absurd_parameters_score_badly_without_a_warning(small_family, loss):
    objective = CurveObjective(small_family, loss=loss)
    for Ms in (1e100, 1e200, 1e308, math.inf, math.nan):
        assert objective([Ms, 100.0, 0.0, 2.0, 20.0])[0] > 1e40
    assert objective(np.zeros(5))[0] == math.inf


def test_nrmse_is_the_same_whatever_is_minimized(small_family, unequal):
    expected = CurveObjective(small_family)(ROWS)
    for loss in LOSSES:
        score = CurveObjective(unequal, loss=loss).nrmse(ROWS)
        np.testing.assert_allclose(score, expected, rtol=1e-14)
    by_curve = CurveObjective(unequal, normalize="curve")
    np.testing.assert_allclose(by_curve.nrmse(ROWS), expected, rtol=1e-14)


def test_only_the_ratios_of_weights_count(unequal):
    for loss in LOSSES:
        expected = CurveObjective(unequal, loss=loss)(ROWS)
        for factor in (1e-3, 1e300):
            scaled = [replace(curve, weight=factor * curve.weight) for curve in unequal]
            found = CurveObjective(scaled, loss=loss)(ROWS)
            np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_the_robust_loss_ignores_gross_outliers(elbow):
    clean, rng = CurveObjective(family(elbow)), np.random.default_rng(1)
    spoiled = []
    for curve in family(elbow, noise=NOISE):
        torque = curve.torque.copy()
        hit = rng.choice(torque.size, round(0.05 * torque.size), replace=False)
        torque[hit] += 20.0  # the sensor's cable, always to one side
        spoiled.append(replace(curve, torque=torque))

    def fitted_nrmse(curves, loss):
        """NRMSE on clean curves of the fit to others, by Nelder-Mead in relative parameters."""
        objective = CurveObjective(curves, loss=loss)
        options = {"maxfev": 1500, "fatol": 1e-10, "xatol": 1e-6}

        def score(scale):
            return objective(ROWS[0] * scale)[0]

        found = minimize(score, np.full(5, 1.1), method="Nelder-Mead", options=options)
        return clean.nrmse(ROWS[0] * found.x)[0]

    assert fitted_nrmse(family(elbow, noise=NOISE), "nrmse") < 0.003
    assert fitted_nrmse(spoiled, "robust") < 0.005
    assert fitted_nrmse(spoiled, "nrmse") > 0.02


def test_the_robust_loss_has_a_scale_without_noise(elbow):
    right, wrong = CurveObjective(family(elbow), loss="robust")(ROWS)
    assert right < 1e-9
    assert wrong > 1e-3


def test_initial_torques(elbow):
    for first in [0.0, -1.5, 3.0]:
        curves = family(elbow, first=first, noise=NOISE)
        expected = np.concatenate([elbow.response(curve.angle, first) for curve in curves])
        fixed = CurveObjective(curves, initial_torque=first)
        identified = CurveObjective(curves, initial_torque="identified")
        np.testing.assert_allclose(fixed.responses(ROWS[0])[0], expected, atol=1e-9)
        both = identified.responses([[*ROWS[0], first], [*ROWS[1], 0.5]])
        np.testing.assert_allclose(both[0], expected, atol=1e-9)
        alone = CurveObjective(curves, initial_torque=0.5).responses(ROWS[1])[0]
        np.testing.assert_array_equal(both[1], alone)
        measured = CurveObjective(curves, initial_torque="measured").responses(ROWS)
        starts = np.cumsum([0, *(curve.angle.size for curve in curves)])[:-1]
        np.testing.assert_array_equal(measured[:, starts], [[one.torque[0] for one in curves]] * 2)


def test_bad_input(small_family):
    silent = Curve(small_family[0].angle, 0 * small_family[0].angle, "silent")
    beside, row = [*small_family, silent], ROWS[:1]
    rows = [
        ({"loss": "robus"}, row, "unknown loss 'robus'.*did you mean 'robust'"),
        ({"normalize": "curves"}, row, "unknown normalize 'curves'.*did you mean 'curve'"),
        ({"loss": "sse", "normalize": "curve"}, row, "'sse' does not normalize"),
        ({"initial_torque": "measurd"}, row, "'measurd': use one of a number.*mean 'measured'"),
        ({"initial_torque": math.nan}, row, "initial_torque is nan: give a finite number"),
        ({"initial_torque": [1, 2]}, row, "initial_torque is .*: give a number"),
        ({}, np.zeros(6), r"shape \(1, 6\): give rows of 5 numbers \(Ms"),
        ({}, np.zeros((2, 2, 5)), "give rows of 5"),
        ({"initial_torque": "identified"}, row, r"give rows of 6 numbers.*initial torque"),
        ({"normalize": "curve", "curves": beside}, row, "every torque of curve 'silent' is zero"),
    ]
    usual = {"curves": small_family}
    assert_refused(lambda options, given: CurveObjective(**usual | options)(given), rows)
    assert np.isfinite(CurveObjective(beside)(ROWS)).all()
