"""Scores of muscles on short motions: what they must say, and bad input."""

from dataclasses import replace

import mujoco
import myo_sim
import numpy as np
import pytest
from activesuit.benchmarks.muscles import map_errors
from activesuit.envs.evaluation import evaluate
from activesuit.envs.evaluation.extra_scores import cost_of
from activesuit.envs.muscles import CONVENTIONS, STANDARD, MyoArm, muscle_scores
from activesuit.envs.muscles.mapping import OWN, THIRD, decomposed, shoulder_axes, turn
from activesuit.envs.muscles.metabolic import MODELS, bhargava, muscle_masses, umberger
from activesuit.envs.muscles.myoarm import JOINTS, Geometry, myoarm_spec
from activesuit.envs.muscles.scores import SCORE
from activesuit.envs.person import Person, isometric_strength, strength_limits
from helpers import assert_refused

TASK, SHORT = "ActiveSuit/ElbowFlexion-v0", {"max_episode_steps": 60}


def motions(policies=("none",), count=2, **options):
    options = {"gravity": "earth", "adapted": False, **SHORT, **options}
    return evaluate(TASK, list(policies), motions=count, **options).traces


@pytest.fixture(scope="module")
def traces():
    return motions(count=8)


@pytest.fixture(scope="module")
def scores(traces):
    return {name: muscle_scores(one) for name, one in traces.items()}


def test_each_motion_has_a_value_under_each_convention(scores):
    for score in scores.values():
        assert set(score.costs["power"]) == set(score.costs["effort"]) == set(CONVENTIONS)
        assert all(len(values) == 8 for values in score.costs["power"].values())
        assert min(score.costs["power"][STANDARD]) > score.facts["rest"] > 1
        assert score.facts["reserve"] < 0.01
        assert score.facts["saturated"] == score.facts["outside"] == 0
        assert len(score.facts["loaded"]) == 3
        assert set(SCORE.units) == {*score.costs, *score.facts}
        assert set(SCORE.least) == set(score.costs)


def test_suit_and_exoskeleton_cost_the_muscles(scores):
    power = {name: np.mean(score.costs["power"][STANDARD]) for name, score in scores.items()}
    assert power["unsuited"] < power["suited"] < power["none"]
    found = cost_of(scores, "none", "power", SCORE.least["power"])
    assert found.mean == power["none"] and found.relief is not None and found.relief.high < 0
    low, high = found.between
    assert low <= found.relief.value <= high and high - low > 0.01


def test_the_relief_of_the_references_is_known(scores):
    for what, least in SCORE.least.items():
        for name, value in (("unsuited", 1), ("suited", 0)):
            found = cost_of(scores, name, what, least)
            assert found.relief is not None and found.relief.value == pytest.approx(value)
    alike = {**scores, "unsuited": scores["suited"]}
    assert cost_of(alike, "none", "power", 0.5)[1:] == (None, None)


def test_conventions_move_scores_the_way_they_must(scores):
    for score in scores.values():
        power, effort = (
            {name: np.mean(values) for name, values in one.items()}
            for one in (score.costs["power"], score.costs["effort"])
        )
        assert power["relaxed"] < power[STANDARD]
        assert effort["rotation free"] < effort[STANDARD] + 1e-9
        assert effort[STANDARD] < min(effort["cubes"], effort["volume"])
        assert effort["least activation"] > effort[STANDARD]
        assert effort["Bhargava 2004"] == effort[STANDARD]


def test_a_weaker_wearer_needs_more_of_weaker_muscles(traces):
    one = traces["unsuited"][0]
    weaker = replace(one, strength=one.strength / 2, effort=one.effort * 2)
    man, other = (muscle_scores([trace], conventions=["relaxed"]) for trace in (one, weaker))
    twice = 2 * man.costs["effort"]["relaxed"][0]
    assert other.costs["effort"]["relaxed"][0] == pytest.approx(twice, rel=0.02)
    assert other.facts["rest"] == pytest.approx(man.facts["rest"] / 2)


def test_progress_and_threads(traces):
    seen = []
    one, many = (
        muscle_scores(traces["none"], conventions=[], threads=n, on_motion=lambda: seen.append(1))
        for n in (1, 2)
    )
    assert one == many and len(seen) == 16


def test_motions_that_end_at_once_have_no_value(traces):
    one = traces["none"][0]
    cut = ("time", "angle", "rate", "human_torque", "effort", "strength")
    short = replace(one, **{name: getattr(one, name)[:2] for name in cut})
    power = muscle_scores([one, short], conventions=[]).costs["power"][STANDARD]
    assert np.isfinite(power).tolist() == [True, False]
    assert_refused(muscle_scores, [([short], "no motion has 3 samples")])


def test_motions_that_cannot_be_scored(traces):
    one = traces["none"][0]
    angle = np.tile([0.0, 0.5, 2.35, 0.0], (len(one.time), 1))
    average = isometric_strength(Person.percentile("male", 50))
    low, high = strength_limits(average, angle, np.zeros_like(angle))
    bent = replace(one, angle=angle, strength=np.stack([-low, high], axis=1))
    tired = motions(count=1, references=False, fatigue=True)["none"]
    rows = [
        ([bent], None, "100% of the postures are outside"),
        (tired, None, "MyoArm is scaled by one factor: leave fatigue out"),
        ([], ["squared"], "unknown convention 'squared'"),
        ([], None, "there are no motions"),
    ]
    assert_refused(
        lambda found, names: muscle_scores(found, **({"conventions": names} if names else {})), rows
    )


RNG = np.random.default_rng(0)
ANGLE = RNG.uniform([0.02, -0.4, 0.05, -0.7], [1.4, 2.2, 2.1, 0.7], (40, 4))
RATE = RNG.normal(size=ANGLE.shape)
STEP = 1e-5  # rad


@pytest.fixture(scope="module")
def arm():
    return MyoArm.load()


def lengths(arm, theirs):
    found = np.empty((len(theirs), len(arm.muscles)))
    data = mujoco.MjData(arm.model)
    for i, one in enumerate(theirs):
        data.qpos[:] = arm.coupled @ one
        mujoco.mj_fwdPosition(arm.model, data)
        found[i] = data.actuator_length
    return found


def test_segments_point_where_ours_do():
    errors = map_errors(200)
    # What is left is MyoArm's anatomy: the carrying angle and the joint axes of elbow and wrist.
    assert errors["turn of the upper arm [deg]"][1] < 0.06  # the least elevation is 1 mrad
    assert errors["turn of the hand [deg]"][1] < 15
    assert errors["direction of the upper arm [deg]"][1] < 2
    assert errors["direction of the forearm [deg]"][1] < 20
    assert errors["wrist [mm]"][1] < 90


def test_moment_arms_are_differences_of_lengths(arm):
    arms = arm.geometry(ANGLE, RATE).arms
    for joint, axis in enumerate(OWN):
        h = STEP * np.eye(4)[joint]
        change = lengths(arm, arm.angles(ANGLE + h)) - lengths(arm, arm.angles(ANGLE - h))
        assert arms[:, axis] == pytest.approx(-change / (2 * STEP), abs=1e-8)
    for axis, name in ((4, "pro_sup_r"), (6, "deviation_r")):
        h, theirs = STEP * np.eye(7)[JOINTS.index(name)], arm.angles(ANGLE)
        change = lengths(arm, theirs + h) - lengths(arm, theirs - h)
        assert arms[:, axis] * arm.signs[axis] == pytest.approx(-change / (2 * STEP), abs=1e-8)


def test_moment_arms_about_the_third_axis(arm):
    upper = turn(0, -ANGLE[:, 0]) @ turn(2, ANGLE[:, 1])
    axis, found = shoulder_axes(ANGLE)[:, :, THIRD], []
    for h in (STEP, -STEP):
        turned = upper.copy()
        for i, (unit, one) in enumerate(zip(axis, upper, strict=True)):
            turned[i] += h * np.cross(unit, one, axisb=0, axisc=0)
        theirs = arm.angles(ANGLE)
        theirs[:, :3] = decomposed(turned)
        found.append(lengths(arm, theirs))
    arms = arm.geometry(ANGLE, RATE).arms[:, THIRD]
    assert arms == pytest.approx(-(found[0] - found[1]) / (2 * STEP), abs=1e-7)


def test_speeds_are_rates_of_lengths(arm):
    change = [lengths(arm, arm.angles(ANGLE + h * RATE)) for h in (STEP, -STEP)]
    speed = arm.geometry(ANGLE, RATE).speed
    assert speed == pytest.approx((change[0] - change[1]) / (2 * STEP), abs=1e-7)


def test_forces_are_those_of_the_muscle_functions(arm):
    model, found = arm.model, arm.geometry(ANGLE, RATE)
    length = lengths(arm, arm.angles(ANGLE))
    for m in range(model.nu):
        span, weight = model.actuator_lengthrange[m], model.actuator_acc0[m]
        gain, bias = model.actuator_gainprm[m, :9], model.actuator_biasprm[m, :9]
        for i in range(len(ANGLE)):
            at, speed = length[i, m], found.speed[i, m]
            for v, force in ((speed, found.full), (0.0, found.isometric)):
                full = -mujoco.mju_muscleGain(at, v, span, weight, gain)
                assert force[i, m] == pytest.approx(full, abs=1e-9)
            slack = -mujoco.mju_muscleBias(at, span, weight, bias)
            assert found.passive[i, m] == pytest.approx(slack, abs=1e-9)


def test_threads_change_nothing_and_postures_outside_the_ranges_are_named(arm):
    angle = np.array([[0.1, 0.5, 1.0, 0.0], [0.1, 0.5, 2.4, 0.0], [0.0, -0.05, 0.5, 0.0]])
    assert arm.geometry(angle, np.zeros((3, 4))).outside.tolist() == [False, True, False]
    angle, rate = np.repeat(ANGLE, 20, axis=0), np.repeat(RATE, 20, axis=0)
    one, many = (arm.geometry(angle, rate, threads=n) for n in (1, 3))
    assert all(np.array_equal(a, b) for a, b in zip(one, many, strict=True))


@pytest.mark.parametrize(
    ("kind", "name", "joints"),
    [("muscle", "DELT1", JOINTS), ("joint", "elbow_flexion_r", JOINTS[:3])],
)
def test_models_that_lack_a_part_are_refused(monkeypatch, kind, name, joints):
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="humerus_r", mass=1, inertia=[1, 1, 1])
    for joint in joints:
        body.add_joint(name=joint)
        body = body.add_body(mass=1, inertia=[1, 1, 1])
    monkeypatch.setattr(myo_sim, "load_spec", lambda _: spec)
    assert_refused(myoarm_spec, [(f"without the {kind} '{name}': install version",)])


def geometry(arm, *, length=1.0, speed=0.0, full=1.0, isometric=1.0):
    """One sample in which all muscles have the same length, speed in lengths/s and force."""
    ones = np.ones((1, len(arm.muscles)))
    return Geometry(
        length=length * ones,
        speed=speed * arm.optimal * ones,
        arms=np.zeros((1, 7, len(arm.muscles))),
        full=full * arm.peak * ones,
        isometric=isometric * arm.peak * ones,
        passive=0 * ones,
        outside=np.zeros(1, bool),
    )


def test_masses_follow_from_force_length_tension_and_density(arm):
    i = arm.muscles.index("BRA")
    expected = arm.peak[i] / 0.5e6 * arm.optimal[i] * 1059.7
    assert muscle_masses(arm)[i] == pytest.approx(expected)
    assert 2 < muscle_masses(arm).sum() < 6  # kg


def test_umberger_of_an_isometric_muscle(arm):
    found = umberger(arm, geometry(arm), np.full((1, 32), 0.3)) / muscle_masses(arm)
    assert found == pytest.approx(1.5 * (25 + 128 * 0.5) * 0.3**0.6 * np.ones((1, 32)))
    long = umberger(arm, geometry(arm, length=1.2, isometric=0.5), np.full((1, 32), 0.3))
    assert long / muscle_masses(arm) == pytest.approx(0.7 * found)


def test_umberger_of_shortening_and_lengthening(arm):
    a, active = np.full((1, 32), 0.3), 1.5 * 89 * 0.3**0.6
    fast = arm.fastest
    heat = 1.5 * 0.09 * (0.5 * 250 / fast + 0.5 * 153 / fast) * 0.1
    work = 0.3 * 0.8 * arm.peak * 0.1 * arm.optimal
    found = umberger(arm, geometry(arm, speed=-0.1, full=0.8), a)
    assert found[0] == pytest.approx(muscle_masses(arm) * (active + heat) + work)
    found = umberger(arm, geometry(arm, speed=0.1, full=1.2), a)
    heat = 1.5 * 0.3 * 0.3 * 250 / fast * 0.1
    assert found[0] == pytest.approx(muscle_masses(arm) * (active + heat))


def test_bhargava(arm):
    slow, fast = 0.5 * np.sin(0.15 * np.pi), 0.5 * (1 - np.cos(0.15 * np.pi))
    heat = (40 + 74) * slow + (133 + 111) * fast
    a = np.full((1, 32), 0.3)
    assert bhargava(arm, geometry(arm), a)[0] == pytest.approx(muscle_masses(arm) * heat)
    short = (40 + 0.75 * 74) * slow + (133 + 0.75 * 111) * fast
    force, speed = 0.3 * 0.8 * arm.peak, 0.1 * arm.optimal
    found = bhargava(arm, geometry(arm, length=0.75, speed=-0.1, full=0.8, isometric=0.9), a)[0]
    shortening = (0.16 * 0.3 * 0.9 * arm.peak + 0.18 * force) * speed
    assert found == pytest.approx(muscle_masses(arm) * short + shortening + force * speed)


@pytest.mark.parametrize("model", MODELS.values())
def test_a_resting_muscle_has_a_watt_a_kilogram(arm, model):
    rest = model(arm, geometry(arm, speed=0.5), np.zeros((1, 32)))[0]
    assert rest == pytest.approx(muscle_masses(arm))
    pulled = model(arm, geometry(arm, speed=2.0, full=1.4), np.full((1, 32), 0.5))
    assert (pulled >= rest).all()  # a muscle that is pulled long gives nothing back
