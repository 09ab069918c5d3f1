"""Files with a policy of somebody else: no command runs their code unless it is trusted."""

import json
import sys

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks

POLICY = """
import pathlib
pathlib.Path("imported").touch()

class Sneaky:
    def __init__(self, env):
        pass

    def reset(self):
        pass

    def act(self, observation):
        return 0 * observation[..., :2]
"""
COMMANDS = [
    "simulate --out out --policy",
    "evaluate --motions 8 --unadapted --out out --policies",
    "benchmark run --tasks ElbowFlexion --levels nominal --motions 8 --out out --policies",
    "view --film film.gif --policy",
    "view --policy",
]


@pytest.fixture
def file(tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 1.0)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "sneaky.py").write_text(POLICY)
    (tmp_path / "foreign.json").write_text(json.dumps({"name": "sneaky:Sneaky"}))
    yield "foreign.json"
    sys.modules.pop("sneaky", None)


@pytest.mark.parametrize("command", COMMANDS)
def test_no_code_of_a_file_is_run(capsys, tmp_path, file, command):
    sys.path.append(str(tmp_path))  # the module can be found all the same
    with pytest.raises(SystemExit) as stop:
        main([*command.split(), file])
    assert stop.value.code == 2
    message = capsys.readouterr().err.strip().splitlines()[-1]
    assert "'foreign.json' names 'sneaky:Sneaky', and importing that would run its code" in message
    assert "add --trust" in message
    assert sorted(path.name for path in tmp_path.iterdir()) == ["foreign.json", "sneaky.py"]


@pytest.mark.parametrize("command", COMMANDS[:2])
def test_a_trusted_file_is_taken(tmp_path, file, command):
    main([*command.split(), file, "--trust"])
    assert (tmp_path / "imported").exists()


def test_a_class_on_the_command_line_needs_no_trust(tmp_path, file):
    main(["simulate", "--out", "out", "--policy", "sneaky:Sneaky"])
    assert (tmp_path / "imported").exists()
