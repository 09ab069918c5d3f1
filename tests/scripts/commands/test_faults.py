"""`activesuit evaluate faults`: the table and the result."""

import json

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks

SHORT = ["evaluate", "faults", "--env", "ActiveSuit/ElbowFlexion-v0", "--episodes", "8"]


def test_table_and_result(tmp_path, capsys, monkeypatch):
    shorten_tasks(monkeypatch, 0.5)
    folder = tmp_path / "faults"
    main([*SHORT, "--policies", "compensation", "--coupling", "cuffs", "--out", str(folder)])
    out = capsys.readouterr().out
    assert "elbow's motor stops" in out
    assert "cuffs: +20 N" in out
    result = json.loads((folder / "result.json").read_text())
    assert [one["policy"] for one in result["surprises"]] == ["compensation"] * 10
    assert "| compensation | both motors stop |" in (folder / "faults.md").read_text()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (["--episodes", "3"], "episodes is 3"),
        (["--policies", "copmensation"], "unknown policy 'copmensation'"),
        (["--coupling", "none"], "needs motors"),
    ],
)
def test_bad_input_is_one_sentence(given, sentence, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([*SHORT, *given])
    assert stopped.value.code == 2
    assert sentence in capsys.readouterr().err
