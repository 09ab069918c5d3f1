"""Why a motion failed: exactly where it is no success, in every task."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout, score
from activesuit.envs.evaluation.reasons import Oscillation, Reason, most_frequent
from activesuit.envs.evaluation.scores import UNITS
from activesuit.envs.interface.reward import is_success
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.tasks import TASKS
from activesuit.envs.tasks.task import EVERYWHERE, TOLERANCES

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
