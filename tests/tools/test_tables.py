"""The tables of the docs that code holds are up to date."""

import pytest
from activesuit.envs.interface.observation import SUITES
from activesuit.errors import InputError
from activesuit.tools.leaderboard import PAGE, leaderboard
from activesuit.tools.sentences import FACTS
from activesuit.tools.tables import PAGES, ROOT, TABLES, marks, page, sensor_suites

WITH_TABLES = [path for path in PAGES if marks(path)]


@pytest.mark.slow
@pytest.mark.parametrize("path", WITH_TABLES, ids=lambda path: path.name)
def test_a_page_is_what_the_code_says(path):
    assert path.read_text(encoding="utf-8") == page(path), "python -m activesuit.tools.tables"


def test_every_table_stands_on_a_page():
    assert {name for path in WITH_TABLES for name in marks(path)} == {*TABLES}


@pytest.mark.slow
def test_the_leaderboard_is_made_from_the_results():
    assert PAGE.read_text(encoding="utf-8") == leaderboard(), "python -m ...tools.leaderboard"


@pytest.mark.slow
@pytest.mark.parametrize("name", FACTS)
def test_sentences_have_the_numbers_of_the_kept_results(name):
    text = " ".join((ROOT / "docs" / name).read_text(encoding="utf-8").split())
    assert [fact for fact in FACTS[name]() if fact not in text] == []


def test_every_part_of_a_suite_has_a_row_with_its_size():
    rows = [[cell.strip() for cell in row.split("|")] for row in sensor_suites().splitlines()[2:]]
    parts = [part for suite in SUITES.values() for part in suite]
    assert [row[2] for row in rows] == [f"`{part.name}`" for part in parts]
    sizes = {row[2].strip("`"): int(row[4]) for row in rows}
    assert (sizes["angle"], sizes["cuff_force"], sizes["target"]) == (4, 9, 6)


@pytest.mark.parametrize(
    ("mark", "said"),
    [("gain", "did you mean 'gains'"), ("gains", "put '<!-- end: gains -->' below it, once")],
)
def test_a_wrong_mark_is_refused(tmp_path, mark, said):
    path = tmp_path / "model.md"
    path.write_text(f"<!-- made by tables.py: {mark} -->\n", encoding="utf-8")
    with pytest.raises(InputError, match=said):
        page(path)
