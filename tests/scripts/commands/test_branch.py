"""`activesuit evaluate branch`: numbers and figures of what would have happened."""

import json

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks

ARGUMENTS = [
    "evaluate",
    "branch",
    "--policies",
    "none",
    "compensation",
    "--gravity",
    "microgravity",
]


@pytest.fixture(autouse=True)
def short(monkeypatch):
    shorten_tasks(monkeypatch, 1.5)


def test_branches_as_table_as_json_and_as_figures(capsys, tmp_path):
    arguments = [*ARGUMENTS, "--at", "0.4", "0.8", "--horizon", "0.5"]
    main([*arguments, "--out", str(tmp_path)])
    out = capsys.readouterr().out
    assert "after 0.4 s of feedforward," in out
    assert "best-known-plan" in out
    for at in ("0.4", "0.8"):
        assert (tmp_path / f"branches-{at}s.png").stat().st_size > 10_000
    main([*arguments, "--json"])
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((tmp_path / "result.json").read_text())
    for fork in result["forks"]:
        futures = fork["futures"]
        assert list(futures) == ["none", "compensation", "best-known-plan"]
        assert futures["best-known-plan"]["regret"] == 0
        assert futures["none"]["regret"] > futures["compensation"]["regret"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--at", "1.2"], "a branch of 1 s begins at 1.2 s: begin at 0.01 to 0.5 s"),
        (["--at", "0.2", "--base", "magic"], "unknown policy 'magic'"),
        (["--at", "0.2", "--coupling", "none"], "needs motors"),
    ],
)
def test_mistakes(capsys, arguments, message):
    with pytest.raises(SystemExit) as stop:
        main([*ARGUMENTS, *arguments])
    assert stop.value.code == 2
    assert message in capsys.readouterr().err
