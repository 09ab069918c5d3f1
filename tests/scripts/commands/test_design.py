"""`activesuit design`, and its record over the rig to a fit of nested loops."""

import json

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.identification import load_curves, load_motion, save_curves
from helpers import run


def test_design_rig_identify(capsys, tmp_path, undrawn):
    motion, measured = tmp_path / "motion.csv", tmp_path / "rig" / "elbow_flexion.csv"
    reported = run(capsys, "design", curves_path("elbow"), "--out", motion)
    assert "from 0.52 to 1.57 rad" in reported
    assert f"wrote {motion}; next: activesuit rig --motion {motion}" in reported
    run(capsys, "rig", "--motion", motion, "--out", tmp_path / "rig")
    (record,) = load_curves(measured)
    assert (record.name, record.role) == ("motion", "fit")
    assert record.time is not None
    config = json.loads((tmp_path / "rig" / "result.json").read_text())["config"]
    assert config["turns"] == []
    assert len(config["motion"]) < 30  # the reversals, not all samples
    together = tmp_path / "elbow.csv"
    save_curves(together, [*load_curves(curves_path("elbow")), record])
    before, after = (
        json.loads(run(capsys, "identify", file, "--for", "any", "--json"))["coverage"]
        for file in (curves_path("elbow"), together)
    )
    assert len(before["shortfalls"]) == 2
    assert after["shortfalls"] == []
    assert after["measured"]["rates"] is not None


def test_the_record_is_data_and_keeps_the_limits(capsys, tmp_path):
    out = tmp_path / "new.csv"
    limits = ["--min-rate", 0.05, "--max-rate", 0.2, "--sample-rate", 10]
    given = ["--range", -0.2, 0.4, *limits, "--out", out, "--json"]
    result = json.loads(run(capsys, "design", *given))
    time, angle = load_motion(out)
    assert (angle[0], angle[-1]) == (-0.2, -0.2)
    rates = np.abs(np.diff(angle) / np.diff(time))
    assert (rates.min(), rates.max()) == pytest.approx((0.05, 0.2), rel=1e-4)
    assert result["motion"] == str(out)
    assert result["samples"] == time.size
    assert result["duration"] == pytest.approx(time[-1])
    assert result["range"] == [-0.2, 0.4]
    assert len(result["branch_rates"]) == len(result["points"]) - 1


def test_it_begins_where_the_curves_begin(capsys, tmp_path):
    (tmp_path / "down.csv").write_text("curve,angle_rad,torque_nm\nA,1,0\nA,0.2,1\nA,0.9,2\n")
    run(capsys, "design", tmp_path / "down.csv", "--out", tmp_path / "new.csv")
    angle = load_motion(tmp_path / "new.csv").angle
    assert (angle[0], angle.min()) == (1, pytest.approx(0.2))
