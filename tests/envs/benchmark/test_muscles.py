"""Muscles in results of the benchmark: files, merging, and what several settings cost."""

import json
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from activesuit.envs.benchmark import Setting, run_trial, suite
from activesuit.envs.benchmark.muscles import muscle_measure, muscle_standing
from activesuit.envs.benchmark.results import Result, lines, read_results
from activesuit.envs.benchmark.standings import Standings
from activesuit.envs.evaluation import evaluate
from activesuit.envs.muscles import STANDARD, MuscleScore, muscle_relief, muscle_scores
from activesuit.errors import InputError
from helpers import short_benchmark

MOTIONS = 8
HERE = Setting("ElbowFlexion", "nominal", "emu-like")
needs_extra = pytest.mark.skipif(find_spec("myo_sim") is None, reason="needs the extra muscles")


def score(power, effort=0.1, other=None, **changes) -> MuscleScore:
    """A score of motions that all cost the same; `other` is the power under "cubes"."""
    powers = {STANDARD: power, "cubes": power if other is None else other}
    usual = {
        "power": {name: (float(watts),) * MOTIONS for name, watts in powers.items()},
        "effort": {name: (effort,) * MOTIONS for name in powers},
        "loaded": {"DELT1": 0.5, "BRA": 0.2, "SUBSC": 0.1},
    }
    limits = dict.fromkeys(("rest", "reserve", "largest_reserve", "saturated", "outside"), 0.0)
    return MuscleScore(**{**usual, **limits, **changes})


def result(policy, setting=HERE, **changes) -> Result:
    size = (0.1,) * MOTIONS
    usual = {"effort": size, "assisted_effort": size, "tracking": size}
    usual |= {"success": (True,) * MOTIONS, "failed": None, "protocol": {"contract": "abc"}}
    return Result(policy=policy, options={"name": policy}, **setting._asdict(), **usual | changes)


SCORES = {"unsuited": score(90), "suited": score(110, 0.3), "compensation": score(95, 0.2, 100)}
MUSCULAR = [result(name, muscles=one) for name, one in SCORES.items()]


def test_muscles_go_through_a_file(tmp_path):
    ended = replace(SCORES["suited"], power={STANDARD: (np.inf,) * MOTIONS})
    kept = [*MUSCULAR, result("other", muscles=ended), result("tired", no_muscles="it tires")]
    (tmp_path / "a.jsonl").write_text(lines(kept))
    assert read_results([tmp_path / "a.jsonl"]) == kept
    assert "muscles" not in json.loads(result("none").to_json())  # as before there were any


def test_a_trial_with_and_without_muscles_counts_once(tmp_path):
    bare = [result(name) for name in SCORES]
    with_package = [replace(one, protocol={**one.protocol, "myo-sim": "1"}) for one in MUSCULAR]
    paths = [tmp_path / "bare.jsonl", tmp_path / "muscles.jsonl"]
    for path, found in zip(paths, (bare, with_package), strict=True):
        path.write_text(lines(found))
    assert read_results(paths) == read_results(paths[::-1]) == with_package
    other = replace(MUSCULAR[0], muscles=SCORES["suited"])
    paths[0].write_text(lines([other]))
    paths[1].write_text(lines(MUSCULAR))
    with pytest.raises(InputError, match="have different results of unsuited"):
        read_results(paths)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"power": {STANDARD: (1.0,)}}, "has not 8 values of the muscles' power under"),
        ({"effort": {"cubes": (0.1,) * MOTIONS}}, "values of the muscles' effort under the conv"),
        ({"rest": -1.0}, "muscles.rest"),
        ({"loaded": {"a" * 201: 0.1}}, "muscles.loaded"),
    ],
)
def test_damaged_muscles_are_named(changes, message):
    text = result("none", muscles=replace(score(90), **changes)).to_json()
    with pytest.raises(InputError, match=message):
        Result.from_json(text, "line 1")


def test_a_standing_has_costs_reliefs_range_and_load():
    standings = Standings(MUSCULAR)
    found = muscle_standing(standings, "compensation", [HERE])
    assert (found.power, found.effort) == pytest.approx((95, 0.2))
    assert found.power_relief.value == pytest.approx(15 / 20)
    assert found.power_relief_range == pytest.approx((10 / 20, 15 / 20))
    assert found.effort_relief.value == pytest.approx(0.5)
    assert found.loaded == {"DELT1": 0.5, "BRA": 0.2, "SUBSC": 0.1}
    assert standings.standing("compensation", [HERE]).relief is None  # efforts are alike here


def test_a_load_is_that_of_the_worst_setting():
    other = HERE._replace(task="Scoop")
    worse = score(95, loaded={"LAT1": 0.3, "DELT1": 0.4})
    results = [*MUSCULAR, result("compensation", other, muscles=worse)]
    found = muscle_standing(Standings(results), "compensation", [HERE, other])
    assert found.loaded == {"DELT1": 0.5, "LAT1": 0.3, "BRA": 0.2}


def test_where_relief_has_no_meaning_there_is_none():
    cheap = [replace(MUSCULAR[1], muscles=score(90.4, 0.101)), MUSCULAR[0], MUSCULAR[2]]
    found = muscle_standing(Standings(cheap), "compensation", [HERE])
    assert (found.power_relief, found.power_relief_range, found.effort_relief) == (None,) * 3
    assert muscle_standing(Standings([result("none")]), "none", [HERE]) is None
    # Under another convention the suit costs nothing, so that no range over all of them is known.
    one = [MUSCULAR[0], replace(MUSCULAR[1], muscles=score(110, 0.3, 90)), MUSCULAR[2]]
    found = muscle_standing(Standings(one), "compensation", [HERE])
    assert found.power_relief.value == pytest.approx(0.75) and found.power_relief_range is None


def test_a_policy_that_failed_somewhere_has_no_power_and_no_finite_interval():
    other = HERE._replace(task="Scoop")
    references = [replace(one, task="Scoop") for one in MUSCULAR[:2]]
    failed = result("compensation", other, failed="no torque", effort=(np.inf,) * MOTIONS)
    standings = Standings([*MUSCULAR, *references, failed])
    found = muscle_standing(standings, "compensation", [HERE, other])
    assert found.power == np.inf and found.power_relief.low == -np.inf
    relief = standings.relief(other, "compensation", of=muscle_measure("power"))
    assert (relief == -np.inf).all()


@needs_extra
@pytest.mark.slow
def test_a_trial_has_the_muscles_of_evaluate():
    changes = {"policies": ("none",), "tasks": ("ElbowFlexion", "OverheadHold"), "muscles": True}
    with short_benchmark(0.5):
        small = suite("quick", levels=("nominal",), **changes)
        assert small.contract == replace(small, muscles=False).contract
        results = [run_trial(small, one) for one in small.trials if one.label != "best-known-plan"]
        traces = evaluate(
            "ActiveSuit/ElbowFlexion-v0", ["none"], episodes=MOTIONS, suit="emu-like"
        ).traces
    scores = {name: muscle_scores(motions) for name, motions in traces.items()}
    mine = {one.policy: one for one in results if one.task == "ElbowFlexion"}
    for name, one in scores.items():
        kept = mine[name].muscles
        assert list(kept.loaded) == list(one.loaded)
        for convention, power in one.power.items():
            np.testing.assert_allclose(kept.power[convention], power, rtol=1e-5)
    assert all("myo-sim" in one.protocol for one in results)
    relief = Standings(results).relief(HERE, "none", of=muscle_measure("power"))
    expected = muscle_relief(*(scores[name] for name in ("unsuited", "suited", "none")))
    assert relief.mean() == pytest.approx(expected.value, rel=1e-3)
    tired = [one for one in results if one.task == "OverheadHold"]
    assert all("strength of this wearer" in one.no_muscles for one in tired)
    assert all(one.muscles is None and one.failed is None for one in tired)
