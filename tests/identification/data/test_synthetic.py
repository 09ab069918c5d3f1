"""The synthetic rig: the truth, then its noise, then its sensors; and the motions."""

import math

import numpy as np
import pytest
from activesuit.hysteresis import TABLE_2, BoucWen, PoleError, PrandtlIshlinskii, Preisach
from activesuit.identification import first_order_motions, measure
from activesuit.identification.data.curves import noise_floor
from helpers import assert_refused

TURNS = (0.87, 1.22, 1.57)
MOTIONS = first_order_motions(TURNS, start_angle=0.52, angle_step=0.004)
BOUC_WEN = BoucWen(elastic=2.0, hysteretic=6.0, beta=3.0, gamma=-1.0, n=1.5)
STOPS = PrandtlIshlinskii(stiffness=1.0, thresholds=(0.1, 0.3), weights=(4.0, 3.0))
RELAYS = Preisach(levels=(0.5, 1.0, 1.6), density=((3.0,), (1.0, 2.0)), elastic=(0.5, 0.5))


MODELS = (TABLE_2["elbow-sa-pso"], BOUC_WEN, STOPS, RELAYS)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_a_perfect_rig_measures_the_model_itself(model):
    first = 1.25 if model is MODELS[0] else 0.0
    curves = measure(model, MOTIONS, rng=0, predict=["1.22"], initial_torque=first)
    assert [curve.name for curve in curves] == ["0.87", "1.22", "1.57"]
    assert [curve.role for curve in curves] == ["fit", "predict", "fit"]
    for curve in curves:
        np.testing.assert_array_equal(curve.angle, MOTIONS[curve.name])
        np.testing.assert_array_equal(curve.torque, model.response(curve.angle, first))


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_noise_is_a_fraction_of_the_family_and_seeded(model):
    truth = measure(model, MOTIONS, rng=0)
    noisy = measure(model, MOTIONS, rng=1, noise_fraction=0.02)
    peak = max(np.abs(curve.torque).max() for curve in truth)
    errors = np.concatenate([a.torque - b.torque for a, b in zip(noisy, truth, strict=True)])
    # 1,050 samples: a standard deviation is known to 2.2 %, the mean to 3 % of it.
    assert errors.std() == pytest.approx(0.02 * peak, rel=0.1)
    assert abs(errors.mean()) < 0.15 * 0.02 * peak
    assert noise_floor(noisy) == pytest.approx(0.02 * peak, rel=0.15)
    again = measure(model, MOTIONS, rng=np.random.default_rng(1), noise_fraction=0.02)
    other = measure(model, MOTIONS, rng=2, noise_fraction=0.02)
    for a, b, c in zip(noisy, again, other, strict=True):
        np.testing.assert_array_equal(a.torque, b.torque)
        assert (a.torque != c.torque).any()
        np.testing.assert_array_equal(a.angle, MOTIONS[a.name])


def test_sensors_round_what_is_measured_not_what_happens(elbow):
    exact = measure(elbow, MOTIONS, rng=3, noise_fraction=0.01)
    steps = {"torque_resolution": 0.25, "angle_resolution": 0.01}
    coarse = measure(elbow, MOTIONS, rng=3, noise_fraction=0.01, **steps)
    for a, b in zip(exact, coarse, strict=True):
        steps = b.torque / 0.25
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
        assert np.abs(b.torque - a.torque).max() <= 0.125 + 1e-12
        assert np.abs(b.torque - a.torque).max() > 0.1
        np.testing.assert_allclose(b.angle / 0.01, np.round(b.angle / 0.01), atol=1e-9)
        assert np.abs(b.angle - a.angle).max() <= 0.005 + 1e-12


def test_first_order_motions():
    for turn, angle in zip(TURNS, MOTIONS.values(), strict=True):
        assert (angle[0], angle.max(), angle[-1]) == (0.52, turn, 0.52)
        top = int(angle.argmax())
        assert (np.diff(angle[: top + 1]) > 0).all()
        assert (np.diff(angle[top:]) < 0).all()
        assert np.abs(np.diff(angle)) == pytest.approx(0.004, rel=0.02)
    down = first_order_motions([-0.5], start_angle=0.0, angle_step=0.1)["-0.50"]
    np.testing.assert_allclose(down, [0, -0.1, -0.2, -0.3, -0.4, -0.5, -0.4, -0.3, -0.2, -0.1, 0])


def test_bad_rigs(elbow):
    rows = [
        ({"motions": {}}, "there is no motion"),
        ({"motions": {"A": [0.0, math.nan]}}, r"motion 'A'\[1\] is nan"),
        ({"motions": {"A": [0.5]}}, "curve 'A' has 1 sample"),
        ({"predict": ["1.2"]}, "predict names '1.2': the motions are 0.87, 1.22, 1.57"),
        ({"noise_fraction": -0.01}, "noise_fraction is -0.01: give 0 or more"),
        ({"noise_fraction": math.inf}, "noise_fraction is inf"),
        ({"torque_resolution": 0}, r"torque_resolution is 0 N·m: give a number above 0"),
        ({"angle_resolution": -1.0}, "angle_resolution is -1 rad: give a number above 0"),
        ({"angle_resolution": 100.0}, "stays at the angle 0 rad"),
        ({"initial_torque": "measured"}, "initial torque is 'measured': give a number"),
    ]
    usual = {"motions": MOTIONS, "rng": 0}
    assert_refused(lambda options: measure(elbow, **usual | options), rows)


def test_a_motion_into_the_pole_is_no_measurement(shoulder):
    with pytest.raises(PoleError):
        measure(shoulder, first_order_motions([math.pi / 2], start_angle=0, angle_step=0.01), rng=0)


def test_bad_motions():
    rows = [
        ((0.871, 0.872), 0.5, 0.01, "differ by 0.01 rad"),
        ((), 0.5, 0.01, "give at least one number"),
        ((1.0,), 0.5, -0.1, "angle_step is -0.1 rad"),
        ((1.0,), math.nan, 0.1, "start_angle is nan"),
    ]

    def made(turns, start, step):
        first_order_motions(turns, start_angle=start, angle_step=step)

    assert_refused(made, rows)
