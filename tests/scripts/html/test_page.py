"""The page itself: texts of users stay texts, and nothing else than what it says is in it."""

import json
from pathlib import Path

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.scripts.folders import RunFolder
from activesuit.scripts.html import page as page_module
from activesuit.scripts.html.charts import label, line, thinned
from activesuit.scripts.html.columns import MEANINGS
from activesuit.scripts.html.page import build, data_script, plotly_source
from activesuit.scripts.html.writing import write_report
from activesuit.scripts.reports import validation
from pages import EVIL, Page, checked_page, evil_run, parsed, seen

REPORTS = Path(validation.__file__).parent


def test_names_of_users_are_texts(tmp_path):
    page = checked_page(evil_run(tmp_path / "evil"))
    plain = evil_run(tmp_path / "plain", [f"name {i}" for i in range(len(EVIL))])
    other = parsed(plain / "report.html")
    names = [name for name, _ in page.elements if name != "br"]
    assert names == [name for name, _ in other.elements]
    assert not any(key.startswith("on") for _, given in page.elements for key in given)
    for name in EVIL:
        assert page.text.count(seen(name)) >= 4  # in answer, caption, header, cells


def test_names_in_charts_are_texts_for_plotly(tmp_path):
    page = parsed(evil_run(tmp_path / "evil") / "report.html")
    charts = [json.loads(content) for kind, content in page.scripts if kind == "application/json"]
    drawn = [one["name"] for chart in charts for one in chart["data"]]
    for name in EVIL:
        assert {label(f"{what}, {name}") for what in ("band", "measured", "model")} <= {*drawn}
    assert not any("<" in name or "\n" in name or "\u202e" in name for name in drawn)


@pytest.mark.parametrize("text", EVIL)
def test_data_cannot_end_its_script(text):
    script = data_script({"name": text})
    assert script.count("<") == script.count(">") == 2
    page = Page()
    page.feed(script)
    ((kind, content),) = page.scripts
    assert kind == "application/json"
    assert json.loads(content) == {"name": text}


def test_a_page_forbids_what_would_come_from_a_network(tmp_path):
    page = parsed(evil_run(tmp_path) / "report.html")
    (policy,) = [one["content"] for one in page.all("meta") if "http-equiv" in one]
    parts = dict(part.strip().split(" ", 1) for part in policy.split(";"))
    assert parts.pop("default-src") == "'none'"
    assert not any("http" in value or "*" in value for value in parts.values())


def test_plotly_is_in_the_page_once(tmp_path):
    text = (evil_run(tmp_path) / "report.html").read_text(encoding="utf-8")
    source = plotly_source()
    assert source is not None
    assert text.count(source) == 1


@pytest.mark.parametrize("end", ["</SCRIPT >", "<!--"])
def test_a_plotly_that_ends_its_script_is_refused(tmp_path, monkeypatch, end):
    monkeypatch.setattr(page_module, "plotly_source", lambda: f"x = '{end}'")
    with pytest.raises(InputError, match="cannot stand in a page"):
        evil_run(tmp_path)


def test_a_section_without_content_is_left_out(tmp_path):
    text = build(tmp_path, "title", "lead", [])
    assert "<section" not in text
    assert "plotly" not in text.split("<script>")[0]


def test_numbers_are_right_and_texts_left(tmp_path):
    run = RunFolder(tmp_path)
    cells = [["a", "1.5", "-", "x"], ["b", "-2 (−3 to -1)", "1,000", "2-way"]]
    write_report(
        *(run, "bench honesty", "t"),
        answer=[],
        tables={"t": (["n", "p", "q", "r"], cells)},
        settings={},
    )
    page = parsed(tmp_path / "report.html")
    sides = [one.get("class") for one in page.all("th")[:4]]
    assert sides == ["left", None, None, "left"]


def test_columns_whose_names_do_not_say_it_are_explained(tmp_path):
    run = RunFolder(tmp_path)
    tables = {"t": (["a", "over fit\nnoise"], [["b", "1"]]), "u": (["a", "b"], [["c", "2"]])}
    write_report(*(run, "bench honesty", "t"), answer=[], tables=tables, settings={})
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    line = "<p>over fit noise: root mean square of the error over what the fit left of its curves."
    assert page.count(line) == 1


@pytest.mark.parametrize("name", MEANINGS)
def test_every_explained_column_is_in_a_table(name):
    sources = " ".join(path.read_text(encoding="utf-8") for path in REPORTS.glob("*.py"))
    assert name in sources.replace("\\n", " ")


def test_lines_are_thinned_and_have_no_infinities():
    drawn = thinned(100_000)
    assert len(drawn) <= 602
    assert drawn[0] == 0
    assert drawn[-1] == 99_999
    found = line(np.arange(3.0), np.array([1.0, np.nan, np.inf]), "a", "red")
    assert found["y"] == [1.0, None, None]
