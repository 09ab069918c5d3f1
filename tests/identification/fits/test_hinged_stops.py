"""The fit of hinged stops: its own truths, dead zones that no other fit describes, bad families."""

import numpy as np
import pytest
from activesuit.hysteresis import HingedStops, PrandtlIshlinskii
from activesuit.identification import Curve, fit_hinged_stops
from activesuit.identification.fits.objective import predicted
from activesuit.identification.fits.registry import fit_model
from helpers import sweep

LOW, HIGH, NOISE = 0.4, 1.6, 0.1  # rad, rad, N·m of about 10


def stops(rng, count, smallest):
    """The numbers of stops with random weights."""
    thresholds = (HIGH - LOW) * np.linspace(smallest, 0.85, count)
    stiffness, weights = rng.uniform(0.2, 2), np.exp(rng.normal(0, 1, count))
    numbers = {"stiffness": stiffness, "thresholds": thresholds, "weights": weights}
    return numbers | {"rest_angle": LOW}


def torque_at_high(model):
    return model.response([LOW, HIGH])[-1]


def own_truth(rng):
    numbers = stops(rng, 12, 0.03)
    top = torque_at_high(PrandtlIshlinskii(**numbers))
    knots, slopes = top * np.arange(1, 10) / 10, np.exp(rng.normal(0, 0.5, 10))
    model = HingedStops(**numbers, knots=knots, slopes=slopes)
    return model.scaled(torque=10 / torque_at_high(model)).response


def dead_zone_truth(rng):
    """A modified Prandtl-Ishlinskii model (Kuhnen 2003): torque beyond two depths counts more."""
    inside = PrandtlIshlinskii(**stops(rng, 8, 0.03))
    top = torque_at_high(inside)
    depths, gains = rng.uniform(0.1, 0.6, 2) * top, rng.uniform(-0.4, 0.8, 2)
    last = top + gains @ np.maximum(top - depths, 0)

    def torque(angle):
        P = inside.response(angle)
        return 10 / last * (P + np.maximum(P[:, None] - depths, 0) @ gains)

    return torque


def family(torque, seed, turns=5):
    rng = np.random.default_rng([seed, 1])
    curves = []
    for turn in np.linspace(LOW, HIGH, turns + 1)[1:]:
        angle = sweep(LOW, turn, LOW, samples=70)
        measured = torque(angle) + NOISE * rng.standard_normal(angle.size)
        curves.append(Curve(angle, measured, f"{turn}"))
    return curves


def random_motion_error(name, torque, seed):
    """The error over the noise: on the fitted curves, and along a random motion."""
    curves = family(torque, seed)
    found = fit_model(name, curves, np.random.default_rng(0))
    turns = np.random.default_rng([seed, 2]).uniform(LOW, HIGH, 9)
    motion = Curve(sweep(LOW, *turns, samples=40), np.zeros(9 * 39 + 1), "random")
    error = predicted(found.model, found.initial_torque, motion) - torque(motion.angle)
    peak = max(np.abs(curve.torque).max() for curve in curves)
    return found.loss * peak / NOISE, np.sqrt(np.mean(error**2)) / NOISE


def errors(name, truth, count):
    truths = [truth(np.random.default_rng(seed)) for seed in range(count)]
    return np.array([random_motion_error(name, torque, i) for i, torque in enumerate(truths)])


def test_its_own_truths_come_back_at_the_noise():
    fitted, along_random_motions = errors("hinged-stops", own_truth, 20).T
    assert fitted.max() < 1.1
    assert np.median(along_random_motions) < 0.5
    assert along_random_motions.max() < 1


def test_dead_zones_are_predicted_where_other_fits_fail():
    fitted, along_random_motions = errors("hinged-stops", dead_zone_truth, 20).T
    assert np.median(fitted) < 1.1
    assert np.median(along_random_motions) < 1
    for name in ("jiles-atherton", "bouc-wen", "prandtl-ishlinskii"):
        assert np.median(errors(name, dead_zone_truth, 6)[:, 1]) > 2


def test_stops_without_a_hinge_are_described_too():
    numbers = {"thresholds": [0.05, 0.1, 0.2, 0.4], "weights": [20, 8, 0, 5]}
    truth = PrandtlIshlinskii(stiffness=2, **numbers, rest_angle=LOW)
    curves = family(truth.response, 0)
    path = sweep(LOW, 1.5, 0.7, 1.2, 0.9, 1.4, LOW)
    found = fit_hinged_stops(curves)
    error = found.response(path, found.offset) - truth.response(path)
    assert np.sqrt(np.mean(error**2)) < 2 * NOISE


def test_scale_offset_and_direction_change_nothing_else():
    curves = family(dead_zone_truth(np.random.default_rng(3)), 3)
    path = sweep(LOW, 1.5, 0.7, 1.2, LOW)
    expected = fit_hinged_stops(curves)
    torque = expected.response(path, expected.offset)
    for angle, scale, offset in ((-1, -1, 0), (0.5, 1, 0), (1, 10, 0), (1, 1, 3)):
        changed = [Curve(angle * c.angle, scale * c.torque + offset, c.name) for c in curves]
        found = fit_hinged_stops(changed)
        begun = scale * expected.offset + offset
        assert found.offset == pytest.approx(begun, abs=1e-3 * abs(scale))
        there = found.response(angle * path, found.offset)
        np.testing.assert_allclose(there, scale * torque + offset, atol=5e-3 * abs(scale))


def test_a_spring_without_noise():
    curves = family(dead_zone_truth(np.random.default_rng(2)), 2)
    spring = [Curve(c.angle, 4 * (c.angle - LOW), c.name) for c in curves]
    found = fit_hinged_stops(spring)
    torque = found.response(spring[-1].angle, found.offset)
    np.testing.assert_allclose(torque, spring[-1].torque, atol=1e-3)
