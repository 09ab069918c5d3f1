"""`activesuit identify`: rates, long records, and intended motions."""

import io
import json
import re
from contextlib import nullcontext, redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import curves_path, load_suit
from activesuit.hysteresis import BoucWen, Viscoelastic
from activesuit.identification import Curve, Curves, save_curves
from activesuit.scripts.main import main
from helpers import sweep


def run(capsys, *arguments, code=0) -> str:
    with pytest.raises(SystemExit) if code else nullcontext() as stop:
        main(["identify", *map(str, arguments)])
    assert not code or stop.value.code == code
    return capsys.readouterr().out


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


DEGREE = np.pi / 180
TRUTH = BoucWen(elastic=1.7, hysteretic=2.5, beta=2.2, gamma=1.0, n=1.3, rest_angle=40 * DEGREE)
OFFSET = 0.35


def laboratory(path):
    """Writes one long record of a joint whose model is not used, by a sensor with an offset.

    It has semicolons, decimal commas, degrees, N·mm and lines of text before the header.
    """
    time = np.arange(0, 120, 0.02)
    size = np.choose((time // 20).astype(int) % 3, [1.0, 0.6, 0.8])
    turn = np.sin(2 * np.pi * 0.05 * time - np.pi / 2)
    angle = 40 + 35 * size * turn + 6 * np.sin(2 * np.pi * 0.31 * time)
    torque = TRUTH.response(angle * DEGREE, 0.0)
    noise = 0.02 * np.abs(torque).max() * np.random.default_rng(7).standard_normal(time.size)
    lines = ["Prüfstand;7", "Datum;12.03.2026", ""]
    lines += ["Zeit [s];Winkel [Grad];Drehmoment [Nmm];T [°C]"]
    for t, a, m in zip(time, angle, 1000 * (torque + OFFSET + noise), strict=True):
        lines.append(f"{t:.2f};{a:.3f};{m:.1f};21.3".replace(".", ","))
    path.write_text("\r\n".join(lines), encoding="cp1252")
    return path


@pytest.fixture(scope="module")
def laboratory_suit(tmp_path_factory):
    """A record of a laboratory, made a suit in one command; the folder, and what was printed."""
    folder = tmp_path_factory.mktemp("laboratory")
    record = laboratory(folder / "rohdaten.csv")
    said = io.StringIO()
    with redirect_stdout(said):
        main(["identify", str(record), "--joint", "elbow_flexion", "--out", str(folder / "fit")])
    return folder, " ".join(said.getvalue().split())


def test_a_record_of_a_laboratory_becomes_a_suit_in_one_command(laboratory_suit):
    folder, said = laboratory_suit
    page = (Path(__file__).parents[3] / "docs/identification.md").read_text(encoding="utf-8")
    shown = r"```console\n\$ activesuit identify rohdaten.*?\n(.*?)```"
    example = re.search(shown, page, re.DOTALL)
    assert " ".join(example[1].split()) in said
    assert "verdict: the model describes the curves" in said
    result = json.loads((folder / "fit/result.json").read_text(encoding="utf-8"))
    assert result["model_name"] == "bouc-wen"
    assert result["reading"][0] in said
    entry = load_suit(folder / "fit/suit.json").joints["elbow_flexion"]
    angle = sweep(0.1, 1.3, 0.4, 0.9, 0.1)
    error = entry.response(angle) - TRUTH.response(angle, entry.start_torque - OFFSET)
    assert np.abs(error - OFFSET).max() < 0.03 * 2.2  # all but the sensor's offset
    assert len(entry.samples) == 20
    assert "an offset of the torque sensor, if it was not zeroed" in entry.left_open


def test_what_the_record_leaves_open_is_said_where_the_suit_is_made(laboratory_suit):
    folder, said = laboratory_suit
    note = "note: these curves do not determine the offset of the torque sensor (any, by bouc-wen"
    assert said.index("verdict:") < said.index(note) < said.index("(--tare NUMBER)")
    page = re.sub(r"\s+", " ", (folder / "fit/report.html").read_text(encoding="utf-8"))
    assert "do not determine the offset of the torque sensor" in page
    entry = load_suit(folder / "fit/suit.json").joints["elbow_flexion"]
    assert f"not among them: {'; '.join(entry.left_open)}" in said
    assert re.search(r"samples: 20, of [1-8] kinds? of model", said)
    assert "suit: it resists elbow flexion only; --base mock-suit adds the other joints" in said


@pytest.mark.slow
def test_a_given_tare_needs_no_note(capsys, laboratory_suit):
    record = laboratory_suit[0] / "rohdaten.csv"
    said = " ".join(run(capsys, record, "--model", "bouc-wen", "--tare", OFFSET).split())
    assert "do not determine the offset" not in said


@pytest.mark.slow
def test_the_suit_goes_into_the_closed_loop_in_a_second_command(laboratory_suit, capsys):
    folder, _ = laboratory_suit
    suit = str(folder / "fit/suit.json")
    main(["validate", suit, "--motions", "8"])
    said = " ".join(capsys.readouterr().out.split())
    assert "with feedforward and this model the wearer works more than without exoskeleton" in said
    assert "drawn among the model and 20 others that its curves allow" in said
    assert "not contained: an offset of the torque sensor, if it was not zeroed;" in said
    assert "no verdict, since a suit says nothing against itself" in said


@pytest.mark.slow
def test_an_offset_that_is_not_determined_is_not_fitted(laboratory_suit, capsys, tmp_path):
    folder, _ = laboratory_suit
    options = ["--tare", "fit", "--joint", "elbow_flexion", "--samples", 0, "--out", tmp_path / "t"]
    said = " ".join(run(capsys, folder / "rohdaten.csv", *options, code=3).split())
    sentence = "tare: no offset of the torque sensor is taken off, because these curves do not "
    assert said.index(sentence) < said.index("any by bouc-wen") < said.index("verdict:")
    assert said.count("do not determine") == 1
    result = json.loads((tmp_path / "t/result.json").read_text(encoding="utf-8"))
    plain = json.loads((folder / "fit/result.json").read_text(encoding="utf-8"))
    assert result["tare"] == 0
    assert result["remarks"][0]["code"] == "open"
    assert result["model"] == plain["model"]
    assert (tmp_path / "t/suit.json").exists()


def test_several_files_with_named_columns(capsys, tmp_path, elbow):
    for turn in (0.9, 1.2, 1.57):
        angle = sweep(0.52, turn, 0.52)
        rows = zip(np.degrees(angle), 1000 * elbow.response(angle), strict=True)
        text = "phi1;M1\n" + "".join(f"{a:.4f};{m:.3f}\n" for a, m in rows)
        (tmp_path / f"turn-{turn}.csv").write_text(text.replace(".", ","))
    files = sorted(tmp_path.glob("turn*.csv"))
    options = ["--columns", "angle=phi1", "torque=M1", "--units", "angle=deg", "torque=Nmm"]
    result = json.loads(run(capsys, *files, *options, "--decimal", ",", "--json"))
    assert result["nrmse"] < 1e-3
    assert len(result["reading"]) == 3


def intended(capsys, *arguments) -> str:
    return run(capsys, curves_path("elbow"), "--model", "bouc-wen", *arguments)


def test_without_a_use_the_result_has_the_coverage_only(capsys):
    reported = json.loads(intended(capsys, "--json"))["coverage"]
    assert reported["measured"]["range"] == [0.52, 1.57]
    assert reported["measured"]["nesting"] == 1
    assert reported["measured"]["reversals"] == 3  # without the curves that are kept out of the fit
    assert (reported["needed"], reported["shortfalls"]) == (None, [])
    assert "note: the intended" not in intended(capsys)


def test_the_motions_of_a_task(capsys, tmp_path, undrawn):
    text = intended(capsys, "--for", "MinorLoops", "--out", tmp_path)
    reported = json.loads((tmp_path / "result.json").read_text())["coverage"]
    assert reported["for"] == "MinorLoops"
    assert reported["needed"]["nesting"] > 2
    assert reported["needed"]["rates"][1] > 0.5
    assert "curves at most 1: first-order curves do not identify nested loops" in text
    assert all(f"note: {sentence}" in text for sentence in reported["shortfalls"])


def test_a_motion_outside_the_fitted_range_is_a_sentence(capsys, tmp_path):
    (tmp_path / "wide.csv").write_text("angle_rad\n0.3\n2.0\n0.3\n")
    text = intended(capsys, "--for", tmp_path / "wide.csv")
    assert "note: the intended motion goes from 0.3 to 2 rad, the curves from 0.52 to 1.57" in text
    own = "time,shoulder_abduction,shoulder_flexion,elbow_flexion,wrist_flexion\n"
    (tmp_path / "own.csv").write_text(f"{own}0,9,9,0.6,9\n1,9,9,1.5,9\n2,9,9,0.6,9\n")
    reported = json.loads(intended(capsys, "--for", tmp_path / "own.csv", "--json"))["coverage"]
    assert reported["needed"]["range"] == [0.6, 1.5]
    (sentence,) = reported["shortfalls"]
    assert sentence.startswith("the intended motion moves at up to 0.9 r")
