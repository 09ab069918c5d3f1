"""The benchmark: suites, trials, results that merge, and standings."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs.benchmark import SUITES, Setting, run_trial, suite
from activesuit.envs.benchmark.results import lines, read_results
from activesuit.envs.benchmark.standings import Standings
from activesuit.envs.benchmark.suites import SUITE_TASKS
from activesuit.envs.evaluation import FIRST_SEED, evaluate
from activesuit.envs.policies import POLICIES, PolicySpec
from activesuit.envs.policies.trained import shipped_policies
from activesuit.envs.tasks import TASKS
from helpers import assert_refused, short_benchmark
from helpers import made_result as made

MOTIONS = 8


@pytest.fixture(scope="module", autouse=True)
def short():
    with short_benchmark(2.0):
        yield


@pytest.fixture(scope="module")
def small():
    return suite(
        "full",
        policies=("none", "compensation", "compensation:suit=mock-suit"),
        tasks=("ElbowFlexion",),
        levels=("nominal",),
        believed=("emu-like",),
        motions=MOTIONS,
    )


@pytest.fixture(scope="module")
def results(small):
    return [run_trial(small, trial) for trial in small.trials]


def test_the_full_suite_has_everything():
    full = SUITES["full"]
    assert (full.tasks, len(full.levels), full.motions) == (tuple(TASKS), 3, 20)
    least = {*shipped_policies(), "compensation", "adaptive", "predictive"}
    assert {*POLICIES, *shipped_policies()} > set(full.policies) > least
    assert not {"oracle", "corrected"} & set(full.policies)
    assert set(SUITES["cuffs"].policies) > {"compensation", "corrected"}
    assert all(SUITE_TASKS[name].duration <= task.duration for name, task in TASKS.items())
    names = [trial.file_name for trial in full.trials]
    assert len(set(names)) == len(names)
    # At "shift" what believes nothing runs once, the others once for each belief.
    shifted = [t for t in full.trials if t.setting.level == "shift" and t.setting.task == "Scoop"]
    runs = [trial.label for trial in shifted]
    assert (runs.count("none"), runs.count("compensation")) == (1, 2)
    beliefs = {t.policy.options["suit"] for t in shifted if t.label == "compensation"}
    assert beliefs == {"mock-suit", "emu-like"}
    setting = Setting("Ratchet", "shift", "mock-suit")
    assert "suit" not in setting.options  # the level says which one is worn
    assert setting.true_suit == "emu-like"
    assert setting._replace(level="nominal").true_suit == "mock-suit"


def test_a_trial_is_what_evaluate_says(small, results):
    found = evaluate(
        "ActiveSuit/ElbowFlexion-v0", ["compensation"], motions=MOTIONS, suit="emu-like"
    )
    mine = {one.policy: one for one in results}
    effort = found.scores["compensation"].effort
    np.testing.assert_allclose(mine["compensation"].effort, effort, rtol=1e-5)
    np.testing.assert_allclose(mine["suited"].effort, found.scores["suited"].effort, rtol=1e-5)
    standings = Standings(results)
    (setting,) = standings.settings
    relief = standings.relief(setting, "compensation")
    assert relief.mean() == pytest.approx(found.relief("compensation").value, abs=0.02)
    assert mine["compensation"].protocol["first_seed"] == FIRST_SEED
    assert mine["compensation"].protocol["contract"] == small.contract


def test_standings(results):
    standings = Standings(results)
    found = {one.policy: one for one in standings.by_level("nominal")}
    assert list(found)[:3] == ["unsuited", "suited", "best-known-plan"]
    assert found["unsuited"].relief.value == pytest.approx(1, abs=0.2)
    assert found["suited"].relief.value == pytest.approx(0, abs=1e-12)
    right, wrong = found["compensation"], found["compensation:suit=mock-suit"]
    assert right.relief.value > wrong.relief.value
    assert right.assisted.value > right.relief.value  # the wrist has no motor
    assert right.assisted.low < right.assisted.value < right.assisted.high
    assert wrong.gain.high < 0 and wrong.compared[2] > 0.5 > wrong.compared[0]
    assert sum(wrong.compared) == pytest.approx(1)
    assert right.gain is None  # it is what the others are compared with
    assert right.compared is None
    assert right.mean == pytest.approx(right.worst[0])  # in the only setting
    assert right.over_tasks is None  # there is only one
    (setting,) = standings.settings
    difference = standings.difference(setting, "compensation", "compensation:suit=mock-suit")
    assert difference.low > 0
    profile = standings.profile("compensation", "nominal", np.array([-10.0, 0.0, 10.0]))
    assert profile.tolist() == [1, 1, 0]


def test_the_best_known_plan_is_no_worse_than_a_policy_that_succeeds_whatever_it_believes():
    place = {"level": "shift", "success": (True, True, False)}
    place["tracking"] = (0.01, 0.01, 0.01)
    plan = made(policy="best-known-plan", believed="emu-like", effort=(0.2, 0.2, 0.2), **place)
    rival = made(policy="observer", believed="mock-suit", effort=(0.1, 0.3, 0.1), **place)
    standings = Standings([plan, rival])
    for believed in ("emu-like", "mock-suit"):
        best = standings.of(Setting("Scoop", "shift", believed), "best-known-plan")
        assert best.effort == (0.1, 0.2, 0.2)


def test_a_policy_with_fewer_motions_is_compared_on_those():
    """The first motions are harder here, and the quick policy is the better one in each."""
    size = {"tracking": (0.0,) * 10, "success": (True,) * 10}
    cost = np.array([0.3] * 5 + [0.1] * 5)
    efforts = {
        "unsuited": np.full(10, 0.1),
        "suited": 0.1 + cost,
        "compensation": 0.1 + 0.5 * cost,
        "short": 0.1 + 0.4 * cost[:5],
    }
    results = [
        made(
            policy=name,
            effort=tuple(effort.tolist()),
            **{what: values[: effort.size] for what, values in size.items()},
        )
        for name, effort in efforts.items()
    ]
    standings = Standings(results)
    (setting,) = standings.settings
    np.testing.assert_allclose(standings.relief(setting, "short"), 0.6)
    assert standings.relief(setting, "compensation").mean() == pytest.approx(0.5)
    short = standings.standing("short", [setting])
    np.testing.assert_allclose(list(short.gain.to_dict().values()), 0.1)
    assert short.compared == (1, 0, 0)


def test_a_policy_stands_only_at_levels_where_it_ran(results):
    again = [replace(one, level="randomized") for one in results if one.policy != "none"]
    standings = Standings([*results, *again])
    assert "none" in [one.policy for one in standings.by_level("nominal")]
    assert "none" not in [one.policy for one in standings.by_level("randomized")]
    assert all(np.isfinite(one.success) for one in standings.by_level("randomized"))


def test_a_suit_file_names_results_and_its_content_the_contract(tmp_path):
    path, contracts = tmp_path / "my.json", {SUITES["full"].contract, SUITES["cuffs"].contract}
    for name in ("mock-suit", "emu-like"):
        load_suit(name).save(path)
        small = suite("quick", tasks=("ElbowFlexion",), believed=(str(path),))
        contracts.add(small.contract)
        path.unlink()
    assert len(contracts) == 4
    assert SUITES["full"].contract == SUITES["quick"].contract
    names = [trial.file_name for trial in small.trials]
    assert not any("/" in name for name in names) and any(".my." in name for name in names)
    assert len(set(names)) == len(names)


def test_results_go_through_a_file(tmp_path):
    kept = [made(), made(policy="mine", effort=(np.inf,) * 2, failed="no torque")]
    (tmp_path / "a.jsonl").write_text(lines(kept))
    assert read_results([tmp_path / "a.jsonl"]) == kept
    more = made(level="shift")
    (tmp_path / "b.jsonl").write_text(lines([kept[0], more]))
    assert read_results([tmp_path / "a.jsonl", tmp_path / "b.jsonl"]) == [*kept, more]


def test_results_that_cannot_be_merged(tmp_path):
    rows = [
        (
            lines([made(protocol={"contract": "x"})]),
            "contract 'x', and earlier results have 'abc'",
        ),
        (lines([made(effort=(0.3, 0.3))]), "different results of none in Scoop at nominal"),
        ("{}\n", "line 1, is no result of the benchmark"),
        (lines([made(effort=(0.1,))]), "series of different lengths"),
        (lines([made(task="Knee")]), "line 1, has the task 'Knee': delete it"),
        (lines([made(policy="a" * 201)]), "at most 200 characters"),
        (
            lines([made(protocol={"contract": "abc", "episodes": 10**9})]),
            "has 2 motions, and its protocol 100000",
        ),
    ]
    (tmp_path / "a.jsonl").write_text(lines([made()]))
    for content, message in rows:
        (tmp_path / "b.jsonl").write_text(content)
        assert_refused(read_results, [([tmp_path / "a.jsonl", tmp_path / "b.jsonl"], message)])
    missing = (tmp_path / "none.jsonl", tmp_path, Path("a\0b"))
    rows = [([], "there are no results: give a file")]
    rows += [([path], "cannot read the results") for path in missing]
    assert_refused(read_results, rows)


def test_a_reference_that_failed_leaves_no_relief():
    efforts = {"unsuited": 0.1, "suited": np.inf, "compensation": 0.2}
    standings = Standings([made(policy=name, effort=(e,) * 2) for name, e in efforts.items()])
    (setting,) = standings.settings
    assert standings.relief(setting, "compensation") is None
    assert standings.standing("compensation", [setting]).relief is None


def test_a_policy_that_cannot_act_fails_and_the_run_goes_on(small):
    (trial,) = [one for one in small.trials if one.label == "none"]
    found = run_trial(small, trial._replace(policy=PolicySpec("corrected"), label="corrected"))
    assert "cuffs" in found.failed and found.success == (False,) * MOTIONS
    assert json.loads(found.to_json())["effort"] == [None] * MOTIONS
    standings = Standings([*[run_trial(small, one) for one in small.trials[:2]], found])
    standing = standings.standing("corrected", standings.settings)
    assert standing.failed == 1
    assert standing.relief.low == -np.inf and standing.relief.high == np.inf


def test_mistakes():
    rows = [
        ({"policies": ("copmensation",)}, "unknown policy"),
        ({"tasks": ("Knee",)}, "unknown task 'Knee'"),
        ({"levels": ("easy",)}, "unknown level 'easy'"),
        ({"believed": ("nosuit",)}, "unknown suit 'nosuit'"),
        ({"motions": 7}, "motions is 7: use at least 8"),
        ({"policies": ("none", "none")}, "the policies are none, none: name each one once"),
    ]
    assert_refused(lambda options: suite("full", **options), rows)
