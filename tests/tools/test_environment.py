"""The tables in the docstring of the environment say what the code says."""

from activesuit.tools.environment import FILE, remade


def test_the_tables_are_those_of_the_code():
    text = FILE.read_text(encoding="utf-8")
    assert text == remade(text), "python -m activesuit.tools.environment"
