"""The counts of unclear prose, and how little there is."""

import pytest
from activesuit.tools import prose

SOURCE = '''"""A module."""


def act(kind, target, time=0.0):
    """Acts.

    Args:
        kind: of the action.
        target: Name of the target: of
            the action.
        time (float): [s].

    Returns:
        with some luck, a result.
        of no interest

    Raises:
        ValueError: on error.
    """
'''


def test_fragments_are_found_by_how_they_begin(tmp_path, capsys):
    (tmp_path / "act.py").write_text(SOURCE)
    found = list(prose.lines([tmp_path / "act.py"]))
    assert [(line.number, line.is_fragment) for line in found] == [
        (8, True),
        (9, False),
        (11, True),
        (14, True),
    ]
    assert prose.main(tmp_path) == 1
    out = capsys.readouterr().out
    assert out.startswith("act.py:8: of the action.\n")
    assert "3 of     4, 75.0%" in out


BEHIND = """LIMIT = 3  # of all starts
RATE = 4.0  # Hz, up to which a cycle is learned
STEP = 0.1  # [s], greatest time between two samples
SIZE = 5  # kPa, 8.2 psi
text = "# no comment"  # noqa: E501
# of a line of its own
"""


def test_comments_behind_code_are_counted(tmp_path, capsys):
    (tmp_path / "limits.py").write_text(BEHIND)
    found = list(prose.comments(tmp_path / "limits.py"))
    assert [(line.number, line.is_fragment) for line in found] == [
        (1, True),
        (2, True),
        (3, False),
        (4, False),
    ]
    assert prose.main(tmp_path) == 1
    assert "2 of     4, 50.0%; at most 5%" in capsys.readouterr().out


PRIVATE = '''"""What the suit is told. `told` and held-out curves; `Held`."""
held = {"told": 1}
held["told"] += 1  # the torque that is held
raise ValueError(f"the suit {held} is worn")
'''


def test_private_words_are_counted_in_prose_only(tmp_path, capsys):
    (tmp_path / "suit.py").write_text(PRIVATE)
    found = [(line.number, line.text) for line in prose.private_words(tmp_path / "suit.py")]
    assert found == [(1, "told"), (3, "held"), (4, "worn")]
    (tmp_path / "page.md").write_text("He told it: `told`.\n\nheld-out, held outside\n")
    found = [(line.number, line.text) for line in prose.private_words(tmp_path / "page.md")]
    assert found == [(1, "he"), (1, "told"), (3, "held")]
    assert prose.main(tmp_path) == 1
    assert "told 2, worn 1" in capsys.readouterr().out


def test_long_sentences_of_a_page_are_found(tmp_path, capsys):
    page = (
        "# A title of many words is no sentence at all\n\n" + "word " * 29 + "end.\n\n| a | b |\n"
    )
    assert prose.sentence_length(page) == 30
    assert prose.sentence_length(page + "\nA short one. And one more.\n") == pytest.approx(12)
    (tmp_path / "page.md").write_text(page)
    assert prose.main(tmp_path) == 1
    assert "page.md: 30.0 words in a sentence on average" in capsys.readouterr().out


@pytest.mark.parametrize(
    "text",
    ["Whether it helps.", "the action", "`kind` of it", "None, or a name.", "Measured curves."],
)
def test_noun_phrases_and_clauses_are_none(text, tmp_path):
    assert not prose.Line(tmp_path, 1, text).is_fragment


@pytest.mark.slow
def test_the_package_has_few(capsys):
    assert prose.main() == 0, capsys.readouterr().out
