"""What a residual shows: misfits, faults of a measurement, the sign, and the verdict."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen
from activesuit.identification import Curve, Search, fit_curves, motion_coverage
from activesuit.identification.data.curves import loop_work, refuse_driven
from activesuit.identification.data.files import Motion
from activesuit.identification.judging.faults import played
from activesuit.identification.judging.misfit import repeated_noise
from activesuit.identification.judging.noise import slow_noise
from activesuit.identification.judging.sentences import DESCRIBES, NOT, NOT_BEYOND, UNKNOWN
from helpers import along, spring, sweep

TURNS = (0.87, 1.05, 1.22, 1.4, 1.57)
NOISE = 0.05
STOPS = BoucWen(elastic=2.0, hysteretic=15.0, beta=5.0, gamma=-2.0, n=1.0, rest_angle=0.52)


def codes(fit):
    return [one.code for one in fit.remarks]


def family(model, *, memory=0.0, seed=0, repeats=1, gap=0.0, added=lambda i, torque: torque):
    rng, curves = np.random.default_rng([seed, 11]), []
    for i, turn in enumerate(TURNS * repeats):
        angle = sweep(0.52, turn, 0.52, samples=60)
        torque = added(i, model.response(played(angle, gap)))
        noise = NOISE * slow_noise(angle.size, memory, rng)
        curves.append(Curve(angle, torque + noise, f"{i}"))
    return curves


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_right_models_are_not_doubted(elbow, memory):
    fits = [fit_curves(family(elbow, memory=memory, seed=seed)) for seed in range(3)]
    assert not any(fit.judgement.causes for fit in fits)
    expected = NOT_BEYOND if memory == 0 else UNKNOWN  # slow noise may be a misfit
    assert all(fit.verdict == expected for fit in fits)
    assert np.mean([fit.judgement.noise.deviation for fit in fits]) == pytest.approx(NOISE, rel=0.2)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_a_model_of_the_wrong_kind_is_reported(memory):
    for seed in range(2):
        fit = fit_curves(family(STOPS, memory=memory, seed=seed))
        assert fit.verdict == NOT
        assert "misfit" in codes(fit)
    right = fit_curves(family(STOPS, memory=memory), model="bouc-wen")
    assert right.verdict == (NOT_BEYOND if memory == 0 else UNKNOWN)
    twice = fit_curves(family(STOPS, memory=memory, repeats=2), model="bouc-wen")
    assert twice.verdict == NOT_BEYOND


def louder(curves, deviation, seed=0):
    """Adds noise, a function of the torque."""
    out = []
    for one in curves:
        noise = np.random.default_rng([one.torque.size, seed]).standard_normal(one.torque.size)
        out.append(replace(one, torque=one.torque + deviation(one.torque) * noise))
    return out


def test_an_error_above_five_percent_needs_repeats(elbow):
    loud, again = (louder(family(elbow), lambda torque: 8 * NOISE, seed) for seed in (0, 1))
    fit = fit_curves(loud)
    assert fit.verdict == UNKNOWN
    assert codes(fit) == ["wandering"]
    assert len(fit.judgement.doubts) == 1
    again = [replace(one, name=f"{one.name} again") for one in again]
    assert fit_curves([*loud, *again]).verdict == NOT_BEYOND


@pytest.mark.slow
def test_noise_in_proportion_to_the_torque_has_no_outliers(elbow):
    for seed in range(8):
        curves = louder(family(elbow, seed=seed), lambda torque: 0.02 * torque, seed)
        fit = fit_curves(curves)
        assert fit.verdict == NOT_BEYOND
        assert not any(one.code == "outliers" for one in fit.remarks)
        assert fit.judgement.to_dict()["noise_share"] == pytest.approx(0.02, rel=0.5)
    spoilt = curves[-1].torque.copy()
    spoilt[[20, 50]] += 2.0
    (remark,) = fit_curves([*curves[:-1], replace(curves[-1], torque=spoilt)]).remarks
    assert (remark.kind, remark.values["count"]) == ("outliers", 2)


def test_repeated_curves_tell_the_noise_whatever_the_misfit(elbow):
    curves = family(elbow, repeats=2, added=lambda i, torque: torque + np.sin(40 * torque))
    noise = repeated_noise(curves)
    assert noise.deviation == pytest.approx(NOISE, rel=0.1)
    assert repeated_noise(family(elbow)) is None
    wandering = family(STOPS, memory=0.97, repeats=2)
    assert repeated_noise(wandering).memory > 0.8
    assert fit_curves(wandering).judgement.is_repeated


@pytest.mark.parametrize(
    ("name", "size", "fault"),
    [
        ("tare", 0.3, {"added": lambda i, torque: torque + 0.3}),
        ("play", np.radians(0.5), {"gap": np.radians(0.5)}),
        ("drift", 0.02, {"added": lambda i, torque: torque * (1 + 0.02 * i)}),
    ],
)
def test_a_fault_of_the_measurement_is_named(elbow, name, size, fault):
    found = fit_curves(family(elbow, **fault)).judgement
    assert found.causes[0].name == name
    assert found.causes[0].size == pytest.approx(size, rel=0.3)
    assert found.causes[0].remark in found.remarks


def test_too_few_samples_are_one_sentence(elbow):
    few = [replace(one, angle=one.angle[::24], torque=one.torque[::24]) for one in family(elbow)]
    with pytest.raises(InputError, match="samples in all, and the model 'preisach' fits"):
        fit_curves(few, model="preisach")
    assert fit_curves(few, model="jiles-atherton").judgement.misfit.columns < 20


def test_copies_are_no_repeats_and_rounding_is_no_work(elbow):
    curves = family(elbow)
    copies = [*curves, *(replace(one, name=f"{one.name} again") for one in curves)]
    assert repeated_noise(copies) is None
    assert fit_curves(copies).verdict == NOT_BEYOND
    angle = sweep(0.52, 1.5, 0.52)
    refuse_driven([Curve(angle, np.full(angle.size, 3.0), "constant")])


def test_loops_that_drive_the_joint_are_refused(elbow):
    right = family(elbow)
    assert loop_work(right).z > 10
    refuse_driven(right)
    refuse_driven([replace(one, torque=one.torque + 1.3) for one in right])
    driven = [replace(one, torque=-one.torque) for one in right]
    assert loop_work(driven).work == pytest.approx(-loop_work(right).work)
    with pytest.raises(InputError, match="change its sign"):
        fit_curves(driven)
    # A joint that begins far below its rest gives back what it stored, and is no mistake.
    loaded = family(replace(elbow, Ms=337.4, a=934.73, alpha=-1.5777, c=1.781, k=95.9))
    assert loop_work(loaded).z < -3
    refuse_driven(loaded)
    rng = np.random.default_rng(0)
    way = {"noise": 0.1, "rng": rng, "samples": 60}
    springs = [along(spring(1.0), 0.52, 1.5, 0.52, **way) for _ in range(100)]
    assert sum(loop_work([one]).z < -3 for one in springs) <= 1


def test_where_no_memory_is_seen_a_baseline_is_as_good():
    fit = fit_curves([along(spring(3.0), 0.52, 1.5, 0.52, noise=0.05)], model="bouc-wen")
    assert "memoryless" in codes(fit)
    assert fit.judgement.baselines["a spring"] < 1.2 * fit.nrmse


def test_the_verdict_knows_the_intended_motion(elbow):
    curves = family(elbow)
    simple = motion_coverage([Motion(None, sweep(0.6, 1.5, 0.6))])
    nested = motion_coverage([Motion(None, sweep(0.6, 1.5, 0.7, 1.4, 0.8, 1.3, 0.9))])
    assert fit_curves(curves, needed=simple).verdict == DESCRIBES
    beyond = fit_curves(curves, needed=nested)
    assert beyond.verdict == NOT_BEYOND
    assert "coverage nesting" in [one.kind for one in beyond.shortfalls]
    record = along(elbow, 0.52, 1.5, 0.6, 1.4, 0.7, 1.3, 0.8, 1.2)
    assert fit_curves([*curves, record]).verdict == DESCRIBES


def test_a_search_that_ended_early_is_reported(elbow):
    search = Search("pso", trials=1, swarm_size=10, max_iterations=3)
    fit = fit_curves(family(elbow), method=search, workers=1)
    assert fit.verdict == NOT
    assert "search" in codes(fit)
