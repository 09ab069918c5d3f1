"""Scores and drawings of extras on the command line: one that is registered here, and muscles."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.envs.extras import DRAWINGS, SCORES, Score, Scored
from activesuit.envs.rendering import Capsule
from activesuit.errors import InputError
from activesuit.scripts.main import main
from helpers import fails, run, shorten_tasks

SHORT = ("--env", "ActiveSuit/ElbowFlexion-v0")
EVALUATE = ("evaluate", *SHORT, "--motions", "8", "--policies", "compensation")
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
    "command", ["evaluate --out out --score", "view --film out.gif --draw", "view --draw"]
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
