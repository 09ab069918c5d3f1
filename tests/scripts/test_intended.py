"""`identify --for`: what the curves do not tell about the motions that the model is for."""

import json

from activesuit.assets import curves_path
from activesuit.scripts.main import main

ELBOW = str(curves_path("elbow"))
FAST = ["--model", "bouc-wen"]


def run(capsys, *arguments) -> str:
    main([str(argument) for argument in ["identify", ELBOW, *FAST, *arguments]])
    return capsys.readouterr().out


def test_without_a_use_the_result_has_the_coverage_only(capsys):
    reported = json.loads(run(capsys, "--json"))["coverage"]
    assert reported["measured"]["range"] == [0.52, 1.57]
    assert reported["measured"]["nesting"] == 1
    assert (
        reported["measured"]["reversals"] == 3
    )  # the curves that are kept out tell the fit nothing
    assert (reported["needed"], reported["shortfalls"]) == (None, [])
    assert "note: the intended" not in run(capsys)


def test_the_motions_of_a_task(capsys, tmp_path, undrawn):
    text = run(capsys, "--for", "MinorLoops", "--out", tmp_path)
    reported = json.loads((tmp_path / "result.json").read_text())["coverage"]
    assert reported["for"] == "MinorLoops"
    assert reported["needed"]["nesting"] > 2
    assert reported["needed"]["rates"][1] > 0.5
    assert "curves at most 1: first-order curves do not identify nested loops" in text
    for sentence in reported["shortfalls"]:
        assert f"note: {sentence}" in text


def test_a_motion_outside_the_fitted_range_is_a_sentence(capsys, tmp_path):
    (tmp_path / "wide.csv").write_text("angle_rad\n0.3\n2.0\n0.3\n")
    text = run(capsys, "--for", tmp_path / "wide.csv")
    assert "note: the intended motion goes from 0.3 to 2 rad, the curves from 0.52 to 1.57" in text
    own = "time,shoulder_abduction,shoulder_flexion,elbow_flexion,wrist_flexion\n"
    (tmp_path / "own.csv").write_text(f"{own}0,9,9,0.6,9\n1,9,9,1.5,9\n2,9,9,0.6,9\n")
    reported = json.loads(run(capsys, "--for", tmp_path / "own.csv", "--json"))["coverage"]
    assert reported["needed"]["range"] == [0.6, 1.5]
    assert [sentence[:40] for sentence in reported["shortfalls"]] == [
        "the intended motion moves at up to 0.9 r"
    ]
