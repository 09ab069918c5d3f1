"""`activesuit identify`: rates, long records, and curves that it cannot take."""

import json
from contextlib import nullcontext

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.hysteresis import Viscoelastic
from activesuit.identification import Curve, Curves, save_curves
from activesuit.scripts.main import main
from helpers import sweep

ELBOW = curves_path("elbow")


def run(capsys, *arguments, code=0) -> str:
    with pytest.raises(SystemExit) if code else nullcontext() as stop:
        main(["identify", *map(str, arguments)])
    assert not code or stop.value.code == code
    return capsys.readouterr().out


def fails(capsys, *arguments) -> str:
    with pytest.raises(SystemExit) as stop:
        main(["identify", *map(str, arguments)])
    assert stop.value.code == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


@pytest.fixture
def fast(tmp_path, elbow):
    """A file of curves at several speeds, of a joint with a dashpot."""
    viscous, rng, curves = Viscoelastic(model=elbow, damping=0.3), np.random.default_rng(0), []
    for turn, duration in ((0.8, 1.0), (1.1, 2.0), (1.4, 8.0), (1.57, 4.0)):
        time = np.linspace(0, duration, 160)
        angle = 0.52 + (turn - 0.52) * (1 - np.cos(2 * np.pi * time / duration)) / 2
        torque = viscous.response(angle, time=time) + 0.05 * rng.standard_normal(time.size)
        curves.append(Curve(angle, torque, f"{turn} rad", time=time))
    save_curves(tmp_path / "elbow.csv", Curves(curves))
    return tmp_path / "elbow.csv"


def test_the_rate_goes_into_the_suit_file(capsys, tmp_path, fast, undrawn):
    out = run(capsys, fast, code=3)
    assert "fit the rate too (--rate viscous)" in " ".join(out.split())
    out = run(capsys, fast, "--rate", "viscous", "--samples", 2, "--out", tmp_path / "fit")
    assert "damping [N·m·s/rad]" in out
    model = json.loads((tmp_path / "fit/suit.json").read_text())["joints"]["elbow_flexion"]["model"]
    assert model["model"] == "viscoelastic"
    assert model["damping"] == pytest.approx(0.3, abs=0.03)


def test_cycles_are_averaged_on_request(capsys, tmp_path, elbow):
    angle = sweep(0.52, *[1.57, 0.52] * 5, samples=80)
    torque = elbow.response(angle) + 0.1 * np.random.default_rng(0).standard_normal(angle.size)
    file = tmp_path / "elbow.csv"
    save_curves(file, Curves([Curve(angle, torque, "bench")]))
    assert "mean of the cycles after the first: 4 of bench" in run(capsys, file, "--average-cycles")
    result = json.loads(run(capsys, file, "--average-cycles", "--json"))
    assert result["nrmse"] < 0.015
    assert "curve '0.87' has 2 branches" in fails(capsys, ELBOW, "--average-cycles")


def written(tmp_path, *rows, header="curve,angle_rad,torque_nm,time_s"):
    file = tmp_path / "elbow.csv"
    file.write_text("\n".join([header, *rows]) + "\n")
    return file


def rows(angle, torque, time=None):
    time = np.arange(len(angle)) if time is None else time
    return [f"A,{a:.5f},{t:.5f},{s:.3f}" for a, t, s in zip(angle, torque, time, strict=True)]


UP = np.linspace(0.52, 1.57, 40)
LOOP = np.concatenate([UP, UP[::-1]])
BAD = {
    "fewer samples than parameters": (rows(LOOP[::10], LOOP[::10]), "give at least 10"),
    "one monotone branch": (rows(UP, 5 * UP), "no curve turns back"),
    "constant angle": (rows(0 * UP + 1, UP), "stays at the angle 1 rad: without motion"),
    "time runs back": (
        rows(LOOP, LOOP, np.r_[np.arange(40), np.arange(40)]),
        "line 42: the time runs back from 39 to 0 s",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_curves_get_one_sentence(capsys, tmp_path, case):
    lines, said = BAD[case]
    assert said in fails(capsys, written(tmp_path, *lines))


def test_a_motion_beyond_the_fitted_range_is_reported_with_both_ranges(capsys, tmp_path):
    far = tmp_path / "motion.csv"
    far.write_text("time_s,angle_rad\n" + "".join(f"{i},{0.5 + 0.1 * i}\n" for i in range(15)))
    out = " ".join(run(capsys, ELBOW, "--for", far).split())
    assert "the intended motion goes from 0.5 to 1.9 rad, the curves from 0.52 to 1.57 rad" in out
    assert "describes the curves, not beyond" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--samples", "-1"], "samples is -1"),
        (["--rate", "viscous", "--method", "pso"], "which the method 'pso' does not fit"),
        (["--rate", "viscous"], "has no times"),
        (["--rate", "fast"], "fast"),
    ],
)
def test_wrong_arguments_get_one_sentence(capsys, arguments, said):
    assert said in fails(capsys, ELBOW, *arguments)
