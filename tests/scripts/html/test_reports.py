"""The report of each command: made from the files of a run alone, and the same each time."""

import hashlib
import json
import shutil

import numpy as np
import pytest
from activesuit.assets import curves_path, load_suit
from activesuit.envs.making import make_arms
from activesuit.errors import InputError
from activesuit.identification import load_curves, select
from activesuit.scripts.folders import RunFolder
from activesuit.scripts.html import page as page_module
from activesuit.scripts.html.blocks import Player
from activesuit.scripts.html.contents import read_contents
from activesuit.scripts.html.loops import NUMBERS, loop_charts, loop_rows, write_loops
from activesuit.scripts.html.motions import motion_blocks
from activesuit.scripts.html.series import read_columns
from activesuit.scripts.html.writing import report_page
from activesuit.scripts.main import main
from helpers import one_sentence, shorten_tasks, without_figures
from pages import checked_page, parsed

ELBOW = str(curves_path("elbow"))
FEW = ("--motions", "8")
RUNS = {
    "identify": ("identify", ELBOW, "--samples", "2"),
    "rig": ("rig",),
    "simulate": ("simulate", "--policy", "compensation", "--side", "left", "--coupling", "cuffs"),
    "evaluate": ("evaluate", "--policies", "none", "compensation", "--unadapted", *FEW),
    "validate": ("validate", "mock-suit", "--plant", "emu-like", *FEW),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Function from a command to the folder of a short run of it, which is made once."""
    base, made = tmp_path_factory.mktemp("runs"), {}

    def folder(command):
        if command not in made:
            made[command] = base / command
            main([*RUNS[command], "--out", str(made[command])])
        return made[command]

    with pytest.MonkeyPatch.context() as patch, without_figures():
        shorten_tasks(patch, 0.5)
        yield folder


@pytest.fixture
def copied(runs, tmp_path):
    """Function from a command to a copy of its folder, to be damaged."""

    def folder(command):
        shutil.copytree(runs(command), tmp_path / command)
        return tmp_path / command

    return folder


@pytest.mark.slow
@pytest.mark.parametrize("command", RUNS)
def test_the_page_is_made_from_the_folder_alone(runs, command):
    page = checked_page(runs(command))
    found = read_contents(runs(command))
    for sentence in found.answer:
        assert " ".join(sentence.split()) in page.text
    for table in found.tables:
        assert " ".join(table.title.split()) in page.text
    assert {"activesuit", "python", "mujoco"} <= set(found.versions)
    headings = [attributes["id"] for attributes in page.all("h2")]
    assert len(headings) >= 3


@pytest.mark.parametrize(("command", "option"), [("identify", "data_sha256"), ("evaluate", "seed")])
def test_the_origin_names_options_and_hashes(runs, command, option):
    page = parsed(runs(command) / "report.html")
    assert option in page.text
    assert str(read_contents(runs(command)).settings[option]) in page.text
    digest = hashlib.sha256((runs(command) / "result.json").read_bytes()).hexdigest()
    assert digest in page.text


def test_the_loops_are_those_of_the_curves_and_the_fit(runs):
    folder = runs("identify")
    texts, numbers = read_columns(
        folder, "loops.csv", ("curve", "role"), ("angle_rad", "measured_nm", "model_nm")
    )
    entry = load_suit(folder / "suit.json").joints["elbow_flexion"]
    curves = load_curves(ELBOW)
    assert len(texts["curve"]) == sum(curve.angle.size for curve in curves)
    for curve in curves:
        rows = np.array([name == curve.name for name in texts["curve"]])
        assert numbers["angle_rad"][rows] == pytest.approx(curve.angle, rel=1e-5)
        assert numbers["measured_nm"][rows] == pytest.approx(curve.torque, rel=1e-5, abs=1e-6)
        modeled = entry.model.response(curve.angle, entry.start_torque)
        assert numbers["model_nm"][rows] == pytest.approx(modeled, rel=1e-4, abs=1e-4)
        assert {role for role, row in zip(texts["role"], rows, strict=True) if row} == {curve.role}
    charts = [json.loads(text) for kind, text in parsed(folder / "report.html").scripts if kind]
    drawn = {one["name"] for chart in charts for one in chart["data"]}
    for curve in curves:
        assert {f"measured, {curve.name}", f"model, {curve.name}"} <= drawn


def test_bands_are_drawn_where_there_are_some(tmp_path, small_family):
    result = select(small_family)
    write_loops(RunFolder(tmp_path), loop_rows("elbow_flexion", result, None))
    texts, numbers = read_columns(tmp_path, "loops.csv", ("curve",), NUMBERS)
    (curve, *_) = result.fit.curves.held_out()
    rows = np.array([name == curve.name for name in texts["curve"]])
    low, high = result.ensemble.band(curve)
    assert numbers["low_nm"][rows] == pytest.approx(low, rel=1e-4, abs=1e-4)
    assert numbers["high_nm"][rows] == pytest.approx(high, rel=1e-4, abs=1e-4)
    names = [one["name"] for chart in loop_charts(tmp_path) for one in chart.data]
    assert f"band, {curve.name}" in names


def test_the_drawn_arm_is_the_simulated_one(runs):
    folder = runs("simulate")
    (player, *_) = motion_blocks(folder, read_contents(folder))
    assert isinstance(player, Player)
    (motion,) = player.motions
    arms = make_arms("ActiveSuit/ArmTracking-v0", 1, **{"side": "left", "coupling": "cuffs"})
    arm = arms.episodes.simulation.arm_of(0)
    names = ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
    angles = read_columns(folder, "trace.csv", (), [f"{name}_angle_rad" for name in names])[1]
    angle = np.stack(list(angles.values()), axis=1)[motion.frames]
    assert motion.places[:, -1] == pytest.approx(arm.in_world(angle), abs=1e-9)
    links = np.linalg.norm(np.diff(motion.places[:, 1:4], axis=1), axis=2)
    assert np.ptp(links, axis=0).max() < 1e-9  # upper arm and forearm keep their lengths
    assert motion.places[0, 0, 1] > 0  # the left arm


def test_a_page_of_motions_has_one_slider_for_arm_and_loops(runs):
    page = parsed(runs("evaluate") / "report.html")
    (slider,) = [one for one in page.all("input") if one["type"] == "range"]
    (data,) = [json.loads(text) for kind, text in page.scripts if '"motions"' in text[:20]]
    assert len(data["motions"]) == len(page.all("option")) == 4
    for motion in data["motions"]:
        frames = len(motion["time"])
        assert all(len(view) == frames for view in (*motion["arm"], *motion["intended"]))
        assert all(len(mark) == frames for loop in motion["loops"] for mark in loop["marks"])
    assert slider["max"] == str(len(data["motions"][0]["time"]) - 1)


def test_relief_is_drawn_with_its_intervals(runs):
    scores = json.loads((runs("evaluate") / "result.json").read_text())["scores"]
    page = parsed(runs("evaluate") / "report.html")
    charts = [json.loads(text) for kind, text in page.scripts if '"data"' in text[:8]]
    (drawn,) = charts[0]["data"]
    assert drawn["y"] == ["none", "compensation"]
    for i, name in enumerate(drawn["y"]):
        relief, error = scores[name]["relief"], drawn["error_x"]
        assert drawn["x"][i] == pytest.approx(relief["value"], rel=1e-3)
        assert drawn["x"][i] + error["array"][i] == pytest.approx(relief["high"], rel=1e-3)
        assert drawn["x"][i] - error["arrayminus"][i] == pytest.approx(relief["low"], rel=1e-3)


def test_without_plotly_there_are_pictures_and_a_sentence(copied, monkeypatch):
    folder = copied("identify")
    interactive = (folder / "report.html").stat().st_size
    monkeypatch.setattr(page_module, "plotly_source", lambda: None)
    (folder / "report.html").write_text(report_page(folder), encoding="utf-8")
    page = checked_page(folder)
    assert "pip install -e '.[report]' -c constraints.txt" in page.text
    assert len(page.all("img")) == 1
    assert "Plotly.newPlot" in page.scripts[-1][1]  # our own script, which finds none
    assert (folder / "report.html").stat().st_size < interactive / 10


def changed(name, text):
    """Damage that replaces the content of a file, or removes the file."""
    return lambda folder: (
        (folder / name).unlink() if text is None else (folder / name).write_text(text)
    )


def report(**parts):
    """Damage that changes parts of report.json."""

    def damage(folder):
        path = folder / "report.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **parts}))

    return damage


def motion(**parts):
    """Damage that changes the motion in report.json."""

    def damage(folder):
        (one,) = json.loads((folder / "report.json").read_text())["motions"]
        report(motions=[{**one, **parts}])(folder)

    return damage


def cut(folder):
    path = folder / "trace.csv"
    path.write_text(path.read_text()[:-50])


DAMAGES = {  # message, command and damage of its folder
    "has no report.json: its run is of an": ("simulate", changed("report.json", None)),
    "is not complete JSON": ("simulate", changed("report.json", "{")),
    "has the format None": ("simulate", changed("report.json", "[]")),
    "cannot read the time series": ("simulate", changed("trace.csv", None)),
    "has no column 'time_s'": ("simulate", changed("trace.csv", "")),
    "has the format 0, and this version reads 1": ("simulate", report(format=0)),
    "unknown command 'fly'": ("simulate", report(command="fly")),
    "has a wrong answer": ("simulate", report(answer="yes")),
    "has a wrong extra": ("simulate", report(extra=1)),
    "is no file of the run folder": ("simulate", motion(file="../trace.csv")),
    "have another shape": ("simulate", motion(links=[[1.0], [1.0, 2.0]])),
    "cells below a header of": ("simulate", cut),
    "holds no evaluation: restore it": ("evaluate", changed("result.json", "[]")),
}


@pytest.mark.parametrize("message", DAMAGES)
def test_bad_input_is_one_sentence(copied, message):
    command, damage = DAMAGES[message]
    folder = copied(command)
    damage(folder)
    with pytest.raises(InputError) as refusal:
        report_page(folder)
    assert message in str(refusal.value) and one_sentence(refusal)
