"""The page in Chromium without a network: what is drawn, the slider, the tables, the names."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from activesuit.scripts.html.page import plotly_source
from activesuit.scripts.main import main
from helpers import PATIENCE, shorten_tasks, without_figures
from pages import EVIL, evil_run, seen

SCRIPT = Path(__file__).with_name("browser.js")
CHROMIUM, NODE = shutil.which("chromium"), shutil.which("node")


def missing() -> str:
    """What the tests lack, or nothing."""
    if CHROMIUM is None or NODE is None:
        return "needs chromium and node"
    found = subprocess.run(
        [NODE, "-e", "require('playwright-core')"], check=False, capture_output=True
    )
    return "needs playwright-core, in a folder of NODE_PATH" if found.returncode else ""


pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())


def used(folder) -> dict:
    """What happens in the page of a run, by the width of the window."""
    command = [NODE, str(SCRIPT), CHROMIUM, str(folder / "report.html")]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for one in found.values():
        assert one["complaints"] == []
        assert set(one["requests"]) <= {"file:", "data:", "blob:"}
        assert one["overflow"] <= 0
    assert found["1280"]["background"] != found["390"]["background"]
    return found


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    """What happens in the page of an evaluation."""
    folder = tmp_path_factory.mktemp("motions") / "run"
    with pytest.MonkeyPatch.context() as patch, without_figures():
        shorten_tasks(patch, 0.5)
        policies = ("none", "compensation", "--motions", "8", "--unadapted")
        main(["evaluate", "--policies", *policies, "--out", str(folder)])
    return used(folder)


@pytest.mark.parametrize("width", ["1280", "390"])
def test_the_slider_moves_arm_and_loops_together(motions, width):
    first, moved, other, played = motions[width]["states"]
    assert len(first["arm"]) == 2
    assert len(first["marks"]) == 4
    for before, after in ((first, moved), (moved, other), (other, played)):
        assert all(a != b for a, b in zip(before["arm"], after["arm"], strict=True))
        assert all(a != b for a, b in zip(before["marks"], after["marks"], strict=True))
    assert first["output"] != moved["output"] == other["output"] != played["output"]


@pytest.mark.parametrize("width", ["1280", "390"])
def test_tables_are_sorted_by_the_keyboard(motions, width):
    up, down = motions[width]["up"], motions[width]["down"]
    assert (up["sort"], down["sort"]) == ("ascending", "descending")
    assert list(map(float, up["cells"])) == sorted(map(float, up["cells"]))
    assert down["cells"] == up["cells"][::-1]
    assert len(set(up["cells"])) > 2


@pytest.mark.parametrize("width", ["1280", "390"])
def test_plotly_draws_every_chart(motions, width):
    assert plotly_source() is not None
    assert len(motions[width]["plots"]) == 3
    assert all(motions[width]["plots"])
    assert motions[width]["onPaper"] == ["rgb(0, 0, 0)"]


def test_names_of_users_run_nothing_and_are_shown(tmp_path):
    for one in used(evil_run(tmp_path)).values():
        assert one.get("hacked") is None
        shown = " ".join(one["text"].split())
        legends = {" ".join(legend.split()) for legend in one["legend"]}
        for name in EVIL:
            assert seen(name) in shown
            assert f"measured, {seen(name)}" in legends
