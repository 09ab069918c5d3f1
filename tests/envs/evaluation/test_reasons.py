"""Why a motion failed, what counts as an oscillation, and the trace of a motion as CSV."""

import csv
from dataclasses import asdict, replace

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout, score
from activesuit.envs.evaluation.figures import strain_plot
from activesuit.envs.evaluation.reasons import Oscillation, Reason, most_frequent, oscillation
from activesuit.envs.evaluation.report import trace_columns
from activesuit.envs.evaluation.scores import UNITS
from activesuit.envs.interface.reward import is_success
from activesuit.envs.model import ASSISTED
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.tasks import TASKS
from activesuit.envs.tasks.task import EVERYWHERE, TOLERANCES
from activesuit.scripts.folders import RunFolder
from scipy.signal import lfilter

DURATION, SEEDS = 3.0, [0, 1]


def played(task, policy, **options):
    """Returns the motions of a task under a policy, and the arms."""
    arms = ArmEnv(task, **options, **needed_options(policy)).rows(len(SEEDS), threads=1)
    return rollout(arms, make_policy(policy, arms), SEEDS), arms


@pytest.mark.parametrize("name", TASKS)
def test_success_is_false_exactly_where_there_is_a_reason(name):
    shipped = replace(TASKS[name], duration=DURATION)
    loose = {field: getattr(shipped, field) * 100 for field in TOLERANCES}
    loose = {field: min(value, 10.0) for field, value in loose.items()}
    seen = set()
    for task in (shipped, replace(shipped, **loose), replace(shipped, effort=1e-3)):
        traces, arms = played(task, "compensation")
        ends = arms.episodes.costs, arms.episodes.simulation.state.episode.step
        for trace, costs, periods in zip(traces, *ends, strict=True):
            well = is_success(costs, int(periods), task, ended=trace.terminated)
            assert trace.success == (not trace.why) == well
            for reason in trace.why:
                limit = next(one for one in task.limits if one.name == reason.name)
                assert (reason.limit, reason.unit) == (limit.value, limit.unit)
                assert reason.value > reason.limit
                assert 0 < reason.time_s <= trace.time[-1]
                if reason.name in trace.costs:
                    assert reason.value == pytest.approx(trace.costs[reason.name])
            seen.add(trace.success)
        assert score("it", traces).success == tuple(trace.success for trace in traces)
    assert seen == {True, False}


def test_a_lost_arm_has_its_reason():
    traces, _ = played("ElbowFlexion", "none", payload={"mass": 40.0}, wearer={"strength": 5})
    for trace in traces:
        assert trace.terminated and not trace.success
        lost = trace.why[0]
        assert (lost.name, lost.time_s) == ("lost", trace.time[-1])
        assert lost.part in ("shoulder_flexion", "elbow_flexion")


def test_the_time_is_the_first_one_above_the_limit():
    task = replace(TASKS["RangeOfMotion"], duration=12.0, hand_error=0.005, tracking=0.005)
    traces, _ = played(task, "none")
    for trace in traces:
        why = {one.name: one for one in trace.why}
        error = trace.angle - trace.target_angle
        squares = np.cumsum(error**2, axis=0).max(axis=1) / len(error)
        assert why["worst_joint"].time_s == trace.time[np.argmax(squares > task.tracking**2)]
        effort = np.cumsum((trace.effort**2).mean(axis=1)) / len(error)
        if "effort" in why:
            assert why["effort"].time_s == trace.time[np.argmax(effort > task.effort**2)]
    assert any(one.name == "hand_error" for trace in traces for one in trace.why)


def test_a_motor_that_is_hot_and_one_at_its_peak():
    motor = {"continuous_torque": 1.0, "thermal_time_constant": 0.5, "peak_torque": 3.0}
    traces, _ = played("ArmTracking", "compensation", exo={"shoulder": motor})
    found = score("it", traces)
    for i, trace in enumerate(traces):
        hot = found.hot_from["shoulder_flexion"][i]
        assert np.isfinite(hot) and trace.motor_load is not None
        before = trace.motor_load[trace.time < hot, 0]
        assert (before < 1).all()
        assert np.isinf(found.hot_from["elbow_flexion"][i])
        assert 0 < found.saturated["shoulder_flexion"][i] < 1
        heat = next(one for one in trace.why if one.name == "heat")  # as it changes so quickly
        assert heat.part == "shoulder_flexion" and heat.time_s >= hot


def test_without_motors_none_is_hot_and_with_fatigue_strength_falls():
    task = replace(TASKS["OverheadHold"], duration=DURATION)
    found = score("it", played(task, "none", coupling="none")[0])
    assert (found.hot_from, found.saturated) == ({}, {})
    traces, _ = played(task, "none")
    for trace in traces:
        assert trace.fatigue is not None
        assert trace.fatigue.shape == trace.strength.shape == (len(trace.time), 2, 4)
        assert 0 < trace.fatigue[-1].max() < 1
    rested, _ = played(task, "none", fatigue=False)
    assert rested[0].fatigue is None and score("it", rested).fatigued == {}
    tired, fresh = score("it", traces).strength_left, score("it", rested).strength_left
    assert all(tired[joint][0] <= fresh[joint][0] for joint in tired)
    assert tired["shoulder_flexion"][0] < fresh["shoulder_flexion"][0]


def test_the_most_frequent_reason_comes_first():
    def reason(name, value, time, part=None, swing=None):
        return Reason(name, value, 0.1, "rad", time, part, swing)

    why = [
        (reason("tilt", 0.2, 1.0),),
        (reason("worst_joint", 0.3, 2.0, "a"), reason("tilt", 0.4, 3.0)),
        (),
        (reason("tilt", 0.9, 8.0), reason("worst_joint", 0.5, 4.0, "a")),
    ]
    first, second = most_frequent(why)
    assert (first.name, first.motions, first.value, first.time_s) == ("tilt", 3, 0.4, 3.0)
    assert (second.name, second.motions, second.part) == ("worst_joint", 2, "a")
    assert second.value == pytest.approx(0.4)
    # An oscillation of most motions is that of all.
    swings = [Oscillation(period, 0.1 * period) for period in (2.0, 3.0, 2.5)]
    for some, expected in (
        ([*swings, None, None], Oscillation(2.5, 0.25)),
        ([swings[0], None], None),
    ):
        why = [(reason("worst_joint", 0.1, 1.0, "a", swing),) for swing in some]
        assert most_frequent(why)[0].oscillation == expected


@pytest.mark.slow
def test_a_weak_wearer_oscillates_under_compensation_only():
    task = replace(TASKS["OverheadHold"], duration=30.0)
    weak = {"gravity": "moon", "wearer": {"sex": "female", "strength": 20}}
    alone, _ = played(task, "none", **weak)
    assert all(one.oscillation is None for trace in alone for one in trace.why)
    traces, _ = played(task, "compensation", **weak)
    reasons = {one.name: one for trace in traces for one in trace.why}
    assert all(one.oscillation is None for one in reasons.values() if one.unit != "rad")
    found = reasons["worst_joint"].oscillation
    assert found is not None and reasons["worst_joint"].part == "shoulder_flexion"
    trace = traces[0]
    error = (trace.angle - trace.target_angle)[:, JOINTS.index("shoulder_flexion")]
    still = (trace.time > 9) & (trace.time < 13)  # at the second place
    ups = np.flatnonzero(np.diff(np.sign(error[still])) > 0)
    assert np.diff(ups) * 0.01 == pytest.approx(found.period_s, rel=0.15)
    assert found.amplitude == pytest.approx(np.sqrt(2) * error.std(), rel=0.3)


def test_each_number_of_a_score_has_a_unit():
    found = score("it", played(replace(TASKS["ElbowFlexion"], duration=0.5), "none")[0])
    others = {"policy", "success", "why", "limits", "failures"}  # words, and counts
    assert UNITS.keys() == asdict(found).keys() - others
    assert UNITS["costs"].keys() == found.costs.keys()
    assert UNITS["load"].keys() == found.load["elbow_flexion"].keys()
    assert found.to_dict()["units"] == UNITS
    assert {one.name for one in found.limits} >= {one.name for one in EVERYWHERE}
    for limit in found.limits:
        assert limit.name == "lost" or UNITS["costs"][limit.name] == limit.unit


DT = 0.01
TIME = np.arange(1, 6001) * DT
NOISES = 60  # of each kind


def moves(time, hold=6.0, move=1.5):
    """Places that are held, with smooth moves between them, as in OverheadHold."""
    stops = np.arange(0.0, time[-1] + 2 * (hold + move), hold + move)
    places = np.random.default_rng(3).uniform(0.8, 1.2, len(stops))
    phase = np.clip(((time % (hold + move)) - hold) / move, 0, 1)
    smooth = phase**3 * (10 - 15 * phase + 6 * phase**2)
    at = (time // (hold + move)).astype(int)
    return (places[at] + (places[at + 1] - places[at]) * smooth)[:, None]


def cycles(time, period=4.0):
    return 0.4 * np.sin(2 * np.pi * time / period)[:, None]


def rest(time):
    return np.full((len(time), 4), 0.7)


@pytest.mark.parametrize(
    ("intended", "period", "amplitude"),
    [(moves, 2.5, 0.035), (cycles, 0.31, 0.2), (rest, 6.5, 0.05), (moves, 6.5, 0.05)],
)
def test_a_sine_has_its_period_and_amplitude(intended, period, amplitude):
    error = amplitude * np.sin(2 * np.pi * TIME / period + 0.4) + amplitude * (TIME / 60 - 0.3)
    found = oscillation(error, intended(TIME), DT)
    assert found is not None and found.period_s == pytest.approx(period, rel=0.03)
    assert found.amplitude == pytest.approx(amplitude, rel=0.05)
    assert oscillation(error + 2 * amplitude, intended(TIME), DT) is None  # most of it is constant


def test_a_cycle_that_begins_anew_at_each_place():
    since = TIME % 7.5
    swing = np.tanh(3 * np.sin(2 * np.pi * since / 2.4)) * (since < 6.0)
    noise = np.random.default_rng(0).normal(scale=0.1, size=len(TIME))
    found = oscillation(0.05 * (swing + noise), moves(TIME), DT)
    assert found is not None and found.period_s == pytest.approx(2.4, rel=0.02)


@pytest.mark.parametrize("seconds", [0.5, 24, pytest.param(120, marks=pytest.mark.slow)])
def test_noise_and_drift_do_not_oscillate(seconds):
    random, n = np.random.default_rng(5), round(seconds / DT)
    time = np.arange(1, n + 1) * DT
    for _ in range(NOISES if seconds < 100 else NOISES // 3):
        white = random.normal(size=n)
        share = np.exp(-DT / random.uniform(0.02, 3.0))
        slow = lfilter([1], [1, -share], white)
        errors = [white, slow, lfilter([1], [1, -share], slow), np.cumsum(white), np.cumsum(slow)]
        errors += [np.zeros(n), time, np.exp(-time / random.uniform(0.1, 30)), white + 9 * time]
        intended = moves(time) if random.random() < 0.5 else np.cumsum(slow)[:, None] * 1e-4
        for error in errors:
            assert oscillation(error, intended, DT) is None


@pytest.mark.parametrize("period", [1.0, 7.0])
def test_what_the_intended_motion_causes_is_no_oscillation(period):
    """Lag, spring, inertia and friction about a cyclic motion that grows."""
    growing = cycles(TIME, period)[:, 0] * (0.3 + TIME / TIME[-1])
    intended = np.stack([growing, np.full_like(growing, 0.5)], axis=1)
    rate = np.gradient(growing, DT)
    lag = np.interp(TIME - 0.15, TIME, growing) - growing
    random = np.random.default_rng(1).normal(scale=0.02, size=len(TIME))
    for error in (lag, 0.1 * growing, 0.05 * np.sign(rate), lag + 0.05 * np.sign(rate) + random):
        assert oscillation(error, intended, DT) is None
    swing = 0.5 * np.sin(2 * np.pi * TIME / 1.3)
    found = oscillation(lag + swing, intended, DT)
    assert found is not None and found.period_s == pytest.approx(1.3, rel=0.02)


@pytest.mark.parametrize("signs", [(1, 1), (1, -0.3)])
def test_what_follows_each_move_is_no_oscillation(signs):
    since = (TIME - 6.0) % 7.5
    shape = np.exp(-since / 1.5) - 1.3 * np.exp(-since / 0.5)
    error = shape * np.where((TIME - 6.0) // 7.5 % 2, *signs)
    assert oscillation(error, moves(TIME), DT) is None
    for n in (0, 1, 2, 14):
        assert oscillation(error[:n], moves(TIME)[:n], DT) is None  # too few samples


MUSCLES = [f"{joint}_{way}" for way in ("extensor", "flexor") for joint in JOINTS]


def held(**options):
    return played(replace(TASKS["OverheadHold"], duration=1.0), "none", **options)[0][0]


def columns(folder):
    with open(folder / "trace.csv") as file:
        (_, *header), *rows = csv.reader(file)
    return dict(zip(header, np.array([row[1:] for row in rows], float).T, strict=True))


def test_fatigue_strength_and_heat_are_in_the_trace(tmp_path):
    trace = held()
    assert trace.fatigue is not None and trace.motor_load is not None
    RunFolder(tmp_path).csv("trace.csv", *trace_columns({"none": trace}))
    found = columns(tmp_path)
    wanted = {f"{one}_fatigue": trace.fatigue.reshape(-1, 8)[:, i] for i, one in enumerate(MUSCLES)}
    left = trace.strength.reshape(-1, 8)
    wanted |= {f"{one}_strength_nm": left[:, i] for i, one in enumerate(MUSCLES)}
    wanted |= {f"{one}_motor_load": trace.motor_load[:, i] for i, one in enumerate(ASSISTED)}
    wanted |= {f"{one}_effort": trace.effort[:, i] for i, one in enumerate(JOINTS)}
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-5, err_msg=name)
    assert found["shoulder_flexion_flexor_fatigue"][-1] > 0
    assert found["time_s"][-1] == pytest.approx(1.0)


@pytest.mark.parametrize(("options", "rows"), [({}, 4), ({"fatigue": False}, 3)])
def test_what_is_not_there_is_left_out(tmp_path, options, rows):
    bare = held(coupling="none", **options)
    RunFolder(tmp_path).csv("trace.csv", *trace_columns({"none": bare}))
    names = columns(tmp_path)
    assert not any("motor_load" in name for name in names)
    assert any("fatigue" in name for name in names) == (rows == 4)
    for trace, count in ((bare, rows - 1), (held(**options), rows)):
        assert len(strain_plot({"none": trace}).panels) == 2 * count
