"""The programs in examples/: each runs by itself, and its page is made from it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from activesuit.tools.example_pages import PAGES, PROGRAMS, introduction, program_names


@pytest.mark.parametrize("name", program_names())
def test_the_page_is_that_of_the_program(name):
    page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    assert page.startswith(introduction(name)), "python -m activesuit.tools.example_pages makes it"
    assert (PAGES / f"{name}.png").exists() == (f"]({name}.png)" in page)


@pytest.mark.slow
@pytest.mark.parametrize("name", program_names())
def test_it_runs_by_itself(name, tmp_path):
    done = subprocess.run(
        [sys.executable, PROGRAMS / f"{name}.py", "--quick"],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    drawn = {path.name for path in PAGES.glob("*.png")}
    if f"{name}.png" in drawn:
        assert Path(tmp_path, f"{name}.png").read_bytes()[:4] == b"\x89PNG"


def test_every_page_has_its_program():
    assert {path.stem for path in PAGES.glob("*.md")} == set(program_names())
