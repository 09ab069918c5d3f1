"""Scores and drawings of extras on the command line: one that is registered here, and muscles."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.envs.benchmark import run_trial, suite
from activesuit.envs.evaluation import evaluate
from activesuit.envs.extras import DRAWINGS, SCORES, Score, Scored
from activesuit.envs.muscles import muscle_scores
from activesuit.envs.rendering import Capsule
from activesuit.errors import InputError
from activesuit.scripts.main import main
from helpers import fails, run, short_benchmark, shorten_tasks

SHORT = ("--env", "ActiveSuit/ElbowFlexion-v0")
EVALUATE = ("evaluate", *SHORT, "--motions", "8", "--policies", "compensation")
SMALL = (
    *("benchmark", "run", "--tasks", "ElbowFlexion", "--levels", "nominal", "--believed"),
    *("emu-like", "--policies", "compensation", "--motions", "8"),
    *("--workers", "1", "--backend", "threading"),
)
FILM = ("view", *SHORT, "--size", "240", "120", "--film")


def scored(motions, *, threads, on_motion):
    """The wearer's mean torque in N·m, and in another convention twice that of the elbow."""
    mean = tuple(float(np.abs(one.human_torque).mean()) for one in motions)
    elbow = tuple(2 * float(np.abs(one.human_torque[:, 2]).mean()) for one in motions)
    for _ in motions:
        on_motion()
    facts = {"parts": {"elbow": max(elbow), "all": max(mean)}, "loud": 2.0}
    return Scored({"mean": {"standard": mean, "elbow": elbow}}, facts)


def check(simulation):
    if simulation.fatigue:
        raise InputError("toys do not tire")


TOY = Score(
    check=check,
    scored=scored,
    least={"mean": 0.1},
    units={"mean": "N·m", "parts": "N·m"},
    text="*Mean* is that of a toy.",
    limits={"loud": (1.0, "it is {:.0f} loud")},
)


@pytest.fixture
def toy(monkeypatch):
    for registry, extra in ((SCORES, TOY), (DRAWINGS, lambda _: beside)):
        monkeypatch.setattr(registry, "_registered", {})
        registry.register("toy", extra)
        with pytest.raises(InputError, match="there is another"):
            registry.register("toy", extra)


def beside():
    end = np.array([-0.3, -0.6, 1.6])
    return [Capsule(end, end - [0, 0, 1.0], 0.1, np.array([1.0, 0.0, 1.0, 1.0]))]


@pytest.mark.usefixtures("toy")
def test_evaluate_says_a_registered_score(capsys, tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 0.5)
    said = run(capsys, *EVALUATE, "--score", "toy", "--out", tmp_path / "out")
    assert "toy: the suit changes mean from" in said
    assert "it is 2 loud; scores are limited so in 3 of 3 cases" in said
    found = json.loads((tmp_path / "out" / "result.json").read_text())["scores"]
    one = found["compensation"]["toy"]
    assert len(one["mean"]["standard"]) == 8 and one["units"]["mean"] == "N·m"
    low, high = one["mean_relief_range"]
    assert low <= one["mean_relief"]["value"] <= high
    assert found["unsuited"]["toy"]["mean_relief"]["value"] == 1


@pytest.mark.usefixtures("toy")
def test_the_benchmark_keeps_a_registered_score(capsys, tmp_path):
    folder = tmp_path / "run"
    with short_benchmark(0.5):
        said = run(capsys, *SMALL, "--score", "toy", "--out", folder)
        assert "nominal: toy" in said and "nominal: toy, mean by task" in said
        page = (folder / "tables.md").read_text()
        assert "## The score toy" in page and "*Mean* is that of a toy." in page
        assert "nominal: toy" in (folder / "report.html").read_text()
        trials = sorted((folder / "trials").glob("*.json"))
        kept = json.loads(trials[0].read_text())
        assert kept["extra"]["toy"]["facts"]["loud"] == 2
        trials[0].unlink()
        run(capsys, *SMALL, "--score", "toy", "--out", folder)
        assert (folder / "tables.md").read_text() == page
        wrong = fails(capsys, *SMALL, "--out", folder)
        assert "holds a benchmark whose scores is" in wrong
        tiring = ["OverheadHold" if one == "ElbowFlexion" else one for one in SMALL]
        tiring += ["--score", "toy", "--out", tmp_path / "n"]
        assert "toys do not tire" in fails(capsys, *tiring)
    others = [kept | {"policy": "mine", "extra": {}}, kept | {"policy": "odd"}]
    others[1]["extra"]["toy"]["facts"] = {"loud": {"parts": 1.0}, "parts": 3.0}
    (tmp_path / "more.jsonl").write_text("".join(json.dumps(one) + "\n" for one in others))
    said = run(capsys, "benchmark", "table", folder, tmp_path / "more.jsonl")
    assert "note: 1 of 6 trials were run without --score toy" in said
    assert "it is 2 loud; scores are limited so in 4 of 5 cases" in said


@pytest.mark.render
@pytest.mark.usefixtures("toy")
def test_a_film_draws_what_is_registered(tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 0.2)
    films = [tmp_path / "without.gif", tmp_path / "with.gif"]
    for film, more in zip(films, ((), ("--draw", "toy")), strict=True):
        main([*FILM, str(film), *more])
    assert films[0].read_bytes() != films[1].read_bytes()


@pytest.mark.usefixtures("toy")
@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("evaluate --out out --score toy --fatigue true", "toys do not tire"),
        ("evaluate --out out --score tow", "unknown score 'tow': use one of "),
        ("benchmark run --out out --score tow", "unknown score 'tow'"),
        ("view --draw tow", "unknown drawing 'tow'"),
    ],
)
def test_bad_input_is_one_sentence(given, sentence, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert sentence in fails(capsys, *given.split())
    assert list(tmp_path.iterdir()) == []


def test_a_package_that_cannot_be_imported_is_named(monkeypatch):
    broken = SimpleNamespace(load=lambda: __import__("no_such_module"))
    monkeypatch.setitem(SCORES._installed, "broken", broken)
    with pytest.raises(InputError, match="the score 'broken' cannot be imported"):
        SCORES.find("broken")


@pytest.mark.parametrize(
    "command",
    [
        "evaluate --out out --score",
        "view --film out.gif --draw",
        "benchmark run --out out --score",
        "view --draw",
    ],
)
def test_missing_muscles_are_named_before_anything_runs(command, tmp_path, capsys, monkeypatch):
    from activesuit.envs.muscles import MyoArm

    MyoArm.load.cache_clear()
    monkeypatch.setitem(sys.modules, "myo_sim", None)
    monkeypatch.chdir(tmp_path)
    assert "activesuit[muscles]" in fails(capsys, *command.split(), "muscles")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_evaluate_scores_and_draws_muscles(capsys, tmp_path, monkeypatch):
    pytest.importorskip("myo_sim")
    shorten_tasks(monkeypatch, 0.5)
    folder = tmp_path / "out"
    said = run(capsys, *EVALUATE, "--score", "muscles", "--out", folder)
    assert "muscles: the suit changes power from" in said
    one = json.loads((folder / "result.json").read_text())["scores"]["compensation"]["muscles"]
    assert len(one["power"]["standard"]) == 8 and len(one["loaded"]) == 3
    assert one["units"]["power"] == "W" and one["power_relief"] is not None
    assert (folder / "score-muscles.png").read_bytes()[:4] == b"\x89PNG"
    assert "score-muscles" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_trial_has_the_muscles_of_evaluate():
    pytest.importorskip("myo_sim")
    changes = {"policies": ("none",), "tasks": ("ElbowFlexion", "OverheadHold")}
    with short_benchmark(0.5):
        small = suite("quick", levels=("nominal",), scores=("muscles",), **changes)
        assert small.contract == suite("quick", levels=("nominal",), **changes).contract
        chosen = [one for one in small.trials if one.label in ("none", "unsuited")]
        results = [run_trial(small, one) for one in chosen]
        options = {"motions": 8, "suit": "emu-like"}
        traces = evaluate("ActiveSuit/ElbowFlexion-v0", ["none"], **options).traces
    for one in results:
        kept = one.extra["muscles"]
        if one.task == "OverheadHold":
            assert "strength of this wearer" in kept["reason"] and one.failed is None
            continue
        found = muscle_scores(traces[one.policy])
        assert list(kept["facts"]["loaded"]) == list(found.facts["loaded"])
        for convention, power in found.costs["power"].items():
            np.testing.assert_allclose(kept["costs"]["power"][convention], power, rtol=1e-5)
        assert "myo-sim" in kept["packages"]
