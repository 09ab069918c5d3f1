"""The tables of the docs that code holds are up to date."""

import pytest
from activesuit.envs.interface.observation import SUITES
from activesuit.errors import InputError
from activesuit.tools import tables
from activesuit.tools.sentences import FACTS
from activesuit.tools.tables import DOCS, TABLES, page, sensor_suites


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_a_page_is_what_the_code_says(name):
    assert (DOCS / name).read_text(encoding="utf-8") == page(name), (
        "python -m activesuit.tools.tables"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FACTS)
def test_sentences_have_the_numbers_of_the_kept_results(name):
    text = " ".join((DOCS / name).read_text(encoding="utf-8").split())
    assert [fact for fact in FACTS[name]() if fact not in text] == []


def test_every_part_of_a_suite_has_a_row_with_its_size():
    rows = [[cell.strip() for cell in row.split("|")] for row in sensor_suites().splitlines()[2:]]
    parts = [part for suite in SUITES.values() for part in suite]
    assert [row[2] for row in rows] == [f"`{part.name}`" for part in parts]
    sizes = {row[2].strip("`"): int(row[4]) for row in rows}
    assert sizes["angle"] == 4
    assert sizes["cuff_force"] == 9
    assert sizes["target"] == 6


def test_a_page_without_its_marks_is_refused(tmp_path, monkeypatch):
    (tmp_path / "model.md").write_text("nothing", encoding="utf-8")
    monkeypatch.setattr(tables, "DOCS", tmp_path)
    with pytest.raises(InputError, match="marks of 'gains'"):
        page("model.md")
