"""The measuring rig: what it reads is the suit's resistance, as well as its sensors allow."""

import re
from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import load_suit, suit_names
from activesuit.envs.evaluation.scores import root_mean_square as rms
from activesuit.envs.rig import RigConfig, run_rig
from activesuit.envs.rig.rig import NOISE
from activesuit.hysteresis import BoucWen
from activesuit.identification import Curve, Motion, fit_curves, motion_coverage, nested_motion
from activesuit.identification.data.motions import through
from helpers import assert_refused

EXACT = NOISE / 10  # N·m, so that no reading of the default sensor could tell
START, TURNS = 0.52, (0.87, 1.22)
FAST = [("mock-suit", "elbow_flexion"), ("exploration-56kpa", "shoulder_flexion")]
MOTION = ((0, START), (7, 1.22), (10, 0.9))
SHIPPED = [
    pytest.param(suit, joint, marks=() if (suit, joint) in FAST else pytest.mark.slow)
    for suit in suit_names()
    for joint in load_suit(suit).joints
]


def exact(model, **options):
    options = {"turns": TURNS, "noise": 0, **options}
    return run_rig(RigConfig(suit=model, start_angle=START, **options))


def errors(model, record):
    return record.torque - model.response(record.angle)


def curves_of(records):
    roles = ["predict" if i % 2 else "fit" for i in range(len(records))]
    return [Curve(r.angle, r.torque, r.name, role) for r, role in zip(records, roles, strict=True)]


def prediction_error(fit, curves):
    wrong = [fit.predict(one) - one.torque for one in curves if one.role == "predict"]
    return rms(np.concatenate(wrong))


def test_a_perfect_rig_reads_the_resistance(elbow):
    for record, turn in zip(exact(elbow), TURNS, strict=True):
        assert record.name == f"{turn:.2f}"
        assert np.abs(errors(elbow, record)).max() < EXACT
        assert record.angle[0] == pytest.approx(START, abs=1e-9)
        assert record.angle[-1] == pytest.approx(START, abs=0.002)
        assert record.angle.max() == pytest.approx(turn, abs=0.002)  # the torque sensor twists
        assert record.torque[0] == pytest.approx(0, abs=EXACT)
        assert np.allclose(np.diff(record.time), 1 / 25)
    alone = exact(elbow, turns=TURNS[1:])[0]  # every curve begins with a fresh memory
    np.testing.assert_array_equal(record.torque, alone.torque)


def test_the_paper_measures_the_shipped_joints():
    assert RigConfig(joint="shoulder_flexion").turns == (0.52, 0.70, 0.87, 1.05, 1.22)
    assert RigConfig(joint="shoulder_flexion").start_angle == 0.35
    assert RigConfig(joint="elbow_flexion").turns == (0.87, 1.05, 1.22, 1.40, 1.57)
    assert RigConfig(joint="wrist_flexion").turns == (0.14, 0.28, 0.42, 0.56, 0.7)


def test_repeats_show_accommodation(elbow):
    once, thrice = (exact(elbow, repeats=n, turns=(1.57,))[0] for n in (1, 3))
    n = once.angle.size - 20  # before they part
    np.testing.assert_allclose(thrice.torque[:n], once.torque[:n], atol=EXACT)
    assert np.abs(errors(elbow, thrice)).max() < EXACT
    peaks = [part.max() for part in np.array_split(thrice.torque, 3)]
    assert peaks[0] > peaks[1] + 0.02 and peaks[1] > peaks[2]


def test_inertia_and_friction_of_the_rig_are_compensated(elbow):
    fast = exact(elbow, rate=0.5)[1]
    assert np.abs(errors(elbow, fast)).max() < 0.01  # inertia alone takes 0.15 N·m
    rough = exact(elbow, bearing_friction=0.2)[1]
    turned = np.abs(rough.time - rough.time[rough.angle.argmax()]) < 0.3
    moving = ~turned & (rough.time > 0.3) & (rough.time < rough.time[-1] - 0.3)
    assert np.abs(errors(elbow, rough))[moving].max() < 0.02
    # A bearing that sticks holds either way.
    assert np.abs(errors(elbow, rough)).max() < 0.4 + EXACT


def test_noise_has_its_size_and_its_seed(elbow):
    noisy = exact(elbow, noise=0.1, seed=3)
    assert rms(np.concatenate([errors(elbow, one) for one in noisy])) == pytest.approx(0.1, rel=0.1)
    again, other = exact(elbow, noise=0.1, seed=3), exact(elbow, noise=0.1, seed=4)
    np.testing.assert_array_equal(noisy[1].torque, again[1].torque)
    assert not np.array_equal(noisy[1].torque, other[1].torque)
    np.testing.assert_array_equal(noisy[1].angle, other[1].angle)


def test_drift_starts_anew_with_each_curve_and_readings_have_their_resolutions(elbow):
    for record in exact(elbow, drift=0.01):
        np.testing.assert_allclose(errors(elbow, record), 0.01 * record.time, atol=EXACT)
    steps = exact(elbow, angle_resolution=0.01)[1].angle / 0.01
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    coarse = np.abs(errors(elbow, exact(elbow, torque_resolution=1.0)[1]))
    assert 0.4 < coarse.max() < 0.5 + 0.02


def test_any_motion_of_any_model(elbow):
    motion = through([START, 1.4, 0.7, 1.2, 0.6, 1.5, 1.0, 1.57], 0.01)
    config = RigConfig(suit=elbow, start_angle=START, noise=0)
    (record,) = run_rig(config, {"random": motion})
    assert record.name == "random"
    assert np.abs(errors(elbow, record)).max() < EXACT
    assert np.count_nonzero(np.diff(np.sign(np.diff(record.angle[::5])))) == 6


def pairs(*points, rates):
    ways = np.abs(np.diff(points)) / rates
    return tuple(zip(np.append(0, np.cumsum(ways)).tolist(), points, strict=True))


def test_a_motion_keeps_its_reversals_and_rates(elbow):
    design = nested_motion(START, 1.57, min_rate=0.05)
    motion = tuple(zip(design.time.tolist(), design.angle.tolist(), strict=True))
    config = RigConfig(suit=elbow, motion=motion, noise=0)
    assert config.start_angle == START
    np.testing.assert_allclose([angle for _, angle in config.motion], design.points, atol=1e-9)
    (record,) = run_rig(config)
    assert record.name == "motion"
    assert np.abs(errors(elbow, record)).max() < 2 * EXACT  # at 0.5 rad/s the servo lags
    found = motion_coverage([Motion(record.time, record.angle)])
    planned = motion_coverage([Motion(design.time, design.angle)])
    assert (found.nesting, found.reversals) == (planned.nesting, planned.reversals)
    assert found.rates == pytest.approx(planned.rates, rel=0.02)
    assert RigConfig(suit=elbow, motion=config.motion) == replace(config, noise=NOISE)


def test_bad_input_is_refused_with_a_sentence():
    rows = [
        ({"turns": (0.87, 1.7)}, "turn is 1.7 rad: give an angle in the range of elbow_flexion"),
        ({"turns": (0.87, float("nan"))}, "turns[1] is nan: give finite numbers"),
        ({"turns": (0.87, 0.872)}, "differ from the start and each other by 0.01 rad"),
        ({"turns": 1.2}, "turns is 1.2: give at least one number"),
        ({"rate": 0.0}, "rate is 0.0: use a number from 0.01 to 0.5 rad/s"),
        ({"sample_rate": 0.0}, "sample_rate is 0.0: use a number from 1 to 1000 Hz"),
        ({"noise": -0.1}, "noise is -0.1: use a number from 0 to 1000 N·m"),
        ({"repeats": 0}, "repeats is 0"),
        ({"joint": "knee"}, "unknown joint of suit 'mock-suit' 'knee': use one of elbow_flexion"),
        ({"motion": pairs(START, 1.7, rates=0.1)}, "an angle of motion is 1.7 rad: give an angle"),
        ({"motion": pairs(START, 1.2, rates=0.9)}, "0.68 rad in 0.756 s from 0 s on, at 0.9 rad/s"),
        ({"motion": ((0, START), (0, 1.2))}, "motion[1] is at 0 s, after one at 0 s: give times"),
        ({"motion": ((0, 1.0), (1, 1.0))}, "motion stays at 1 rad: let it move"),
        ({"motion": "motion.csv"}, "motion is 'motion.csv': give pairs"),
        ({"motion": ((0, START), (1, float("nan")))}, "give pairs"),
        ({"motion": MOTION, "turns": (1.2,)}, "turns is (1.2,) beside a motion, which has its own"),
        ({"motion": MOTION, "repeats": 2}, "repeats is 2 beside a motion"),
        ({"motion": MOTION, "start_angle": 0.6}, "start_angle is 0.6 rad, and the motion begins"),
    ]
    rows = [(options, re.escape(sentence)) for options, sentence in rows]
    assert_refused(lambda options: RigConfig(**options), rows)


def test_what_the_rig_cannot_measure_is_refused(elbow, shoulder):
    usual = {"suit": elbow, "start_angle": START}
    hours = {**usual, "turns": TURNS, "rate": 0.01, "repeats": 100}
    steel = BoucWen(elastic=200.0, hysteretic=1.0, beta=20.0, gamma=8.0, n=1.5)
    stops, infinite = {"suit": steel, "turns": (0.3, 1.0)}, {"suit": shoulder, "turns": (1.57,)}
    rows = [
        (usual, {}, "there is no motion"),
        (usual, {"a": [0.6, 1.0]}, "motion 'a' begins at 0.6 rad"),
        (usual, {"a": [START, START]}, "motion 'a' stays at 0.52 rad"),
        (usual, {"a": [START, 7.0, START]}, "motion 'a' is 7 rad"),
        (usual, {"a": [START, np.nan]}, "motion 'a'.* is nan"),
        (hours, None, r"curve '1.22' takes 14.* s: stay within 3600 s"),
        (stops, None, r"more than the 100 N·m of the motor on curve '1.00'"),
        (infinite, None, r"becomes infinite on curve '1.57'"),
    ]
    assert_refused(lambda options, motions: run_rig(RigConfig(**options), motions), rows)


@pytest.mark.parametrize(("suit", "joint"), SHIPPED)
def test_what_it_measures_predicts_turns_it_did_not_fit(suit, joint):
    config = RigConfig(suit=suit, joint=joint)
    curves = curves_of(run_rig(config))
    # The gas's part alone grew with the pressure of exploration-56kpa.
    model = "asymmetric" if suit == "exploration-56kpa" else "jiles-atherton"
    assert prediction_error(fit_curves(curves, model=model), curves) <= 1.2 * config.noise


def test_a_joint_as_an_object():
    suit = load_suit("mock-suit")
    joint = suit.joints["elbow_flexion"]
    config = RigConfig(suit=joint, turns=(1.2,))
    assert config.specimen().model == joint.model
    assert len(RigConfig(suit=joint).turns) == 5
    assert RigConfig(suit=suit).specimen() == RigConfig().specimen()
