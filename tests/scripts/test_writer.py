"""Reports: files, and a page that holds everything and asks nothing of any other place."""

import base64
import gzip
import json
import re

import numpy as np
import pytest
from activesuit.plots import FIXED, PALETTE, Band, Cells, Intervals, Line, Panel, Plot
from activesuit.scripts.folders import RunFolder
from activesuit.scripts.writer import Report, conclude

EVIL = (
    "<script>window.hacked=1</script>",
    "</script><img src=x onerror=window.hacked=1>",
    "\"' onmouseover='window.hacked=1'",
    "<!-- <b>&amp;&lt;",
    "{{ 7 * 7 }}",
    "\u202egnp.exe\u2066",
    "\x1b[2J\0",
)
ANGLE = np.linspace(0, 1, 5000)


pytestmark = pytest.mark.usefixtures("closed")


def test_references_have_colors_that_no_policy_has():
    assert not {color for color, _ in FIXED.values()} & {*PALETTE}


def report(name="model", **changes):
    marks = [
        Line(ANGLE, ANGLE**2, "measured", points=True),
        Line(ANGLE, np.where(ANGLE < 0.5, ANGLE, np.nan), name),
        Band(ANGLE, ANGLE - 1, ANGLE + 1, name),
    ]
    panel = Panel(x="angle [rad]", y="torque [N·m]", marks=marks, title=name, levels={name: 0.5})
    cells = Cells([[0.1, 0.9]], [[name, "b"]], [name], ["x", "y"])
    ends = Intervals([name, "two"], [0, 1], [-1, 0.5], [1, 1.5])
    plots = {
        "loops": Plot(panels=[panel, panel], title=name, columns=2),
        "matrix": Plot(panels=[Panel(x="true", y="believed", marks=[cells])]),
        "relief": Plot(panels=[Panel(x="relief", y="", marks=[ends])]),
    }
    usual = {
        "heading": f"Heading {name}",
        "about": name,
        "result": {"value": np.float64(2.5), "bad": np.nan, "list": [1, 2], "name": name},
        "tables": {f"Answer {name}": (["policy", "relief"], [[name, "0.5"], ["none", "-"]])},
        "answer": [f"sentence {name}"],
        "columns": {"loops.csv": (["a", "b"], [[1, 2], [3, 4]])},
        "plots": plots,
        "pictures": {"arm": np.zeros((4, 4, 3), np.uint8)},
    }
    return Report(**usual | changes)


def test_everything_is_in_the_folder_and_the_page_lists_it(tmp_path, capsys):
    conclude(report(), RunFolder(tmp_path))
    figures = ("loops", "matrix", "relief")
    assert {path.name for path in tmp_path.iterdir()} == {
        *("result.json", "loops.csv", "report.html", "arm.png"),
        *(f"{name}.{end}" for name in figures for end in ("png", "svg")),
    }
    assert json.loads((tmp_path / "result.json").read_text())["bad"] is None
    assert (tmp_path / "loops.csv").read_text() == "a,b\n1,2\n3,4\n"
    shown = capsys.readouterr().out
    assert "Answer model" in shown and "sentence model" in shown and "report.html" in shown
    page = (tmp_path / "report.html").read_text()
    for text in ("Heading model", "sentence model", "loops.csv", "result.json", "mujoco"):
        assert text in page
    assert len(page) < 3_000_000
    packed = re.search(r'id="plotly">([\w+/=]+)<', page)
    assert packed is not None and b"Plotly" in gzip.decompress(base64.b64decode(packed[1]))
    assert not re.search(r"(src|href)=[\"'](?!data:|#)", page)  # nothing from other places


def test_json_is_all_that_is_printed(tmp_path, capsys):
    conclude(report(), RunFolder(tmp_path), json=True)
    assert json.loads(capsys.readouterr().out)["value"] == 2.5


@pytest.mark.parametrize("name", EVIL)
def test_names_are_texts(tmp_path, capsys, name):
    conclude(report(name), RunFolder(tmp_path))
    assert "\x1b" not in capsys.readouterr().out
    page = (tmp_path / "report.html").read_text()
    template = re.sub(r'<script type="application/json">.*?</script>', "", page)
    assert template.count("<script") == 2  # plotly, and what draws
    assert "<img src=x" not in page and "onmouseover='" not in page
    assert "\u202e" not in page and "\x1b" not in page and "\0" not in page
    for found in re.findall(r'<script type="application/json">(.*?)</script>', page):
        panel = json.loads(found)
        texts = [trace["name"] for trace in panel["data"]] + [panel["layout"]["title"]["text"]]
        assert not any("<" in text.replace("<br>", "") for text in texts)


def test_matplotlib_and_plotly_draw_the_same():
    plot = report().plots["loops"]
    axes = plot.figure().axes
    panels = plot.plotly()
    assert len(axes) == len(panels) == 2
    measured, model, _ = panels[0]["data"]
    assert len(measured["x"]) <= 501 and measured["x"][-1] == 1  # thinned, with its end
    assert model["y"][-1] is None
    assert axes[0].get_xlabel() == panels[0]["layout"]["xaxis"]["title"]["text"] == "angle [rad]"
    color, _ = plot.styles()["model"]
    assert axes[0].lines[1].get_color() == model["line"]["color"] == color


def test_a_flat_angle_does_not_fill_its_axis():
    still = Plot(panels=[Panel(x="s", y="rad", marks=[Line(ANGLE, 1 + 1e-3 * ANGLE)], least=0.1)])
    low, high = still.figure().axes[0].get_ylim()
    assert high - low == pytest.approx(0.1)
    low, high = still.plotly()[0]["layout"]["yaxis"]["range"]
    assert high - low == pytest.approx(0.1)
