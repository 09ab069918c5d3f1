"""`activesuit rig`: from the simulated rig to a suit, which the rig measures again."""

import json

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.identification import load_curves
from activesuit.scripts.commands import rig as command
from helpers import fails, interrupt, run


@pytest.mark.slow
def test_rig_identify_rig(capsys, tmp_path, undrawn):
    out = run(capsys, "rig", "--noise", 0.05, "--out", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    own = {"elbow_flexion.csv", "result.json", "report.html", "loops.png", "loops.svg"}
    assert names == own
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
    run(capsys, "rig", "--suit", suit, "--out", tmp_path / "again")


def test_what_is_written(capsys, tmp_path, undrawn):
    arguments = ["--turns", 0.9, 1.2, 1.1, 1.0, "--sample-rate", 10, "--out", tmp_path]
    result = json.loads(run(capsys, "rig", *arguments, "--json"))
    roles = {"0.90": "fit", "1.20": "fit", "1.10": "fit", "1.00": "predict"}
    assert {one["name"]: one["role"] for one in result["measured"]} == roles
    curves = load_curves(result["curves"])
    assert {curve.name: curve.role for curve in curves} == roles
    for curve, one in zip(curves, result["measured"], strict=True):
        np.testing.assert_allclose(np.diff(curve.time), 0.1)
        assert one["samples"] == curve.angle.size
        assert one["peak_torque"] == pytest.approx(np.abs(curve.torque).max(), abs=1e-5)
        assert one["work"] == pytest.approx(np.trapezoid(curve.torque, curve.angle), abs=1e-4)
    config = json.loads((tmp_path / "result.json").read_text())["config"]
    kept = {"turns": [0.9, 1.2, 1.1, 1.0], "predict": [1.0], "start_angle": 0.52}
    assert {name: config[name] for name in kept} == kept
    run(capsys, "rig", *arguments, "--predict", 1.1, "--force")
    roles = [curve.role for curve in load_curves(result["curves"])]
    assert roles == ["fit", "fit", "predict", "fit"]


def test_an_interrupted_measurement_leaves_nothing(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(command, "run_rig", interrupt)
    assert "interrupted" in fails(capsys, "rig", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
