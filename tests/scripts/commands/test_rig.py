"""`activesuit measure rig`: from the simulated rig to a suit that simulates."""

import json

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.identification import load_curves
from activesuit.scripts.commands import rig as command
from activesuit.scripts.main import main

WAY = "time_s,angle_rad\n0,0.52\n5,1.0\n"


def run(capsys, *arguments) -> str:
    main([str(argument) for argument in arguments])
    return capsys.readouterr().out


def test_rig_identify_simulate(capsys, tmp_path, undrawn):
    out = run(capsys, "measure", "rig", "--noise", 0.05, "--out", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    loops = {"loops.csv", "loops.png", "loops.svg"}
    own = {".activesuit", "elbow_flexion.csv", "config.json", "report.html", "report.json"}
    assert names == own | loops
    curves = tmp_path / "elbow_flexion.csv"
    assert f"next: activesuit identify {curves}" in out
    run(capsys, "identify", curves, "--out", tmp_path / "fit")
    suit = tmp_path / "fit" / "suit.json"
    truth = load_suit("mock-suit").joints["elbow_flexion"].model
    found = load_suit(str(suit)).joints["elbow_flexion"]
    for curve in load_curves(curves):
        difference = found.model.response(curve.angle, found.start_torque)
        difference -= truth.response(curve.angle)
        assert np.abs(difference).max() < 0.05
    arguments = ["--env", "ActiveSuit/ElbowFlexion-v0", "--suit", suit, "--json"]
    out = run(capsys, "simulate", *arguments, "--out", tmp_path / "motion")
    assert json.loads(out)["failures"] == 0
    run(capsys, "measure", "rig", "--suit", suit, "--out", tmp_path / "again")


def test_what_is_written(capsys, tmp_path, undrawn):
    arguments = ["--turns", 0.9, 1.2, 1.1, 1.0, "--sample-rate", 10, "--out", tmp_path]
    result = json.loads(run(capsys, "measure", "rig", *arguments, "--json"))
    roles = {"0.90": "fit", "1.20": "fit", "1.10": "fit", "1.00": "predict"}
    assert {one["name"]: one["role"] for one in result["measured"]} == roles
    curves = load_curves(result["curves"])
    assert {curve.name: curve.role for curve in curves} == roles
    for curve, one in zip(curves, result["measured"], strict=True):
        np.testing.assert_allclose(np.diff(curve.time), 0.1)
        assert one["samples"] == curve.angle.size
        assert one["peak_torque"] == pytest.approx(np.abs(curve.torque).max(), abs=1e-5)
        assert one["work"] == pytest.approx(np.trapezoid(curve.torque, curve.angle), abs=1e-4)
    config = json.loads((tmp_path / "config.json").read_text())
    assert config["turns"] == [0.9, 1.2, 1.1, 1.0]
    assert config["predict"] == [1.0]
    assert config["start_angle"] == 0.52
    run(capsys, "measure", "rig", *arguments, "--predict", 1.1)
    assert [curve.role for curve in load_curves(result["curves"])] == [
        "fit",
        "fit",
        "predict",
        "fit",
    ]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--turns", "3.0"], "turn is 3 rad: give an angle in the range of elbow_flexion"),
        (["--rate", "0"], "rate is 0 rad/s: give 0.01 to 0.5"),
        (["--noise", "-1"], "noise is -1 N·m: give 0 or more"),
        (["--joint", "knee"], "unknown joint of suit 'mock-suit' 'knee'"),
        (["--suit", "nope"], "unknown suit 'nope'"),
        (["--predict", "1.1"], "predict has 1.1 rad: give some of the turns, 0.87, 1.05"),
        (["--turns", "1.0", "--predict", "1.0"], "predict has all turns"),
        (["--out", "{file}/out"], "choose another --out"),
        (["--motion", "{file}"], "is empty: give a header 'time_s,angle_rad'"),
        (["--motion", "none.csv"], "cannot read the motion 'none.csv'"),
    ],
)
def test_mistakes(capsys, tmp_path, arguments, sentence):
    file = tmp_path / "file"
    file.write_text("")
    arguments = [argument.format(file=file) for argument in arguments]
    with pytest.raises(SystemExit) as stop:
        main(["measure", "rig", "--out", str(tmp_path / "out"), *arguments])
    captured = capsys.readouterr()
    assert stop.value.code == 2
    assert captured.out == ""
    (message,) = captured.err.splitlines()
    assert message.startswith(f"activesuit: error: {sentence}") or sentence in message
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("text", "arguments", "sentence"),
    [
        ("angle_rad\n0.52\n1\n", [], "has no column time_s: add it"),
        (WAY, ["--predict", "1.0"], "--predict belongs to first-order curves"),
        (WAY, ["--turns", "1.0"], "turns is (1.0,) beside a motion"),
        (WAY.replace("5,", "0.1,"), [], "at 4.8 rad/s: give 0.01 to 0.5 rad/s"),
        (WAY.replace("1.0", "3.0"), [], "3 rad: give an angle in the range of elbow_flexion"),
    ],
)
def test_mistakes_with_a_motion(capsys, tmp_path, text, arguments, sentence):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    with pytest.raises(SystemExit) as stop:
        main(["measure", "rig", "--motion", str(path), "--out", str(tmp_path / "out"), *arguments])
    assert stop.value.code == 2
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupted_measurement_leaves_nothing(capsys, tmp_path, monkeypatch):
    def interrupt(config):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "run_rig", interrupt)
    with pytest.raises(SystemExit):
        main(["measure", "rig", "--out", str(tmp_path / "out")])
    assert "interrupted" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
