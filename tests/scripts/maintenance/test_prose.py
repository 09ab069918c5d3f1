"""The count of fragments in docstrings, and how few there are."""

import pytest
from activesuit.scripts.maintenance import prose

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


@pytest.mark.parametrize(
    "text",
    ["Whether it helps.", "the action", "`kind` of it", "None, or a name.", "Measured curves."],
)
def test_noun_phrases_and_clauses_are_none(text, tmp_path):
    assert not prose.Line(tmp_path, 1, text).is_fragment


def test_the_package_has_few(capsys):
    assert prose.main() == 0, capsys.readouterr().out
