"""Pictures and pages of examples are what the programs of today make of the data of today."""

import re
import runpy
import shutil

import matplotlib.pyplot as plt
import pytest
from activesuit.tools import pictures
from activesuit.tools.pictures import (
    DOCS,
    ENDINGS,
    EXAMPLE_PAGES,
    EXAMPLES,
    FIGURES,
    TUTORIALS,
    introduction,
    programs,
    stale,
)
from c_programs import need_compiler
from helpers import shorten_tasks

DRAWN = [name for name, path in programs().items() if path.parent == FIGURES]
EXAMPLE_NAMES = [name for name, path in programs().items() if path.parent == EXAMPLES]


def test_no_picture_is_older_than_its_program_or_its_data():
    old = stale()
    assert not old, f"make them again: python -m activesuit.tools.pictures {' '.join(old)}"


def test_every_picture_and_page_has_its_program():
    assert {path.stem for path in EXAMPLE_PAGES.glob("*.md")} == {*EXAMPLE_NAMES}
    pages = [path.read_text(encoding="utf-8") for path in DOCS.glob("**/*.md")]
    for path in (*FIGURES.iterdir(), *EXAMPLE_PAGES.iterdir()):
        if path.suffix in ENDINGS:
            named = f'"{path.stem}'  # or with its ending
            assert any(named in one.read_text("utf-8") for one in programs().values()), path
            assert any(re.search(rf"\]\([^)]*{path.name}\)", page) for page in pages), path
    for path in (TUTORIALS / "figures").iterdir():
        assert path.name.rsplit("-", 2)[0] in programs(), path


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_the_page_of_an_example_begins_as_its_docstring(name):
    page = (EXAMPLE_PAGES / f"{name}.md").read_text(encoding="utf-8")
    assert page.startswith(introduction(name)), f"python -m activesuit.tools.pictures {name}"


@pytest.mark.parametrize(
    ("text", "is_older"),
    [
        ("draw(2)\n", True),
        ("import b\ndraw(1)\n", True),
        ('"""Another text."""\n\n# a remark\ndraw(1)\n', False),
    ],
)
def test_a_change_of_the_code_makes_a_picture_old(tmp_path, monkeypatch, text, is_older):
    program = tmp_path / "drawn.py"
    program.write_text('"""Text."""\ndraw(1)\n')
    monkeypatch.setattr(pictures, "programs", lambda: {"drawn": program})
    monkeypatch.setattr(pictures, "KEPT", tmp_path / "pictures.json")
    pictures.keep(["drawn"])
    assert not stale()
    program.write_text(text)
    assert stale() == ["drawn"] * is_older
    monkeypatch.setattr(pictures, "DATA", {"drawn": ()})
    assert stale() == ["drawn"]  # other data


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_a_program_draws_its_pictures(name, tmp_path, monkeypatch):
    if name == "device":
        need_compiler()
    if name == "muscles":
        pytest.importorskip("myo_sim")
    shutil.copy(FIGURES / "arm.xml", tmp_path)
    shorten_tasks(monkeypatch, 1.0)
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    with plt.rc_context():
        runpy.run_path(str(programs()[name]), run_name="__main__")
    plt.close("all")
    drawn = [path.name for path in tmp_path.iterdir() if path.suffix in ENDINGS]
    assert drawn
    assert all((FIGURES / one).exists() for one in drawn)
