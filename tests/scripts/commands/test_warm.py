"""`activesuit warm`: compiles all kernels, and says when there is nothing left to compile."""

import os
import subprocess
import sys

import pytest
from activesuit.envs.simulation.compiling import ALONE
from activesuit.scripts.commands import warm as module
from activesuit.scripts.main import main
from numba import njit

USES = ("_plugins", "_arms", "_models", "_fit")


@pytest.fixture
def quick(monkeypatch):
    """Compiles one function of a test in place of all kernels."""

    @njit
    def twice(x):
        return 2 * x

    for name in USES:
        monkeypatch.setattr(module, name, lambda: None)
    monkeypatch.setattr(module, "_fit", lambda: twice(1.0))


def test_it_counts_what_it_compiles_and_says_when_all_is_there(quick, capsys, monkeypatch):
    monkeypatch.delenv(ALONE, raising=False)
    main(["warm"])
    assert capsys.readouterr().out.startswith("compiled 1 kernels; they are kept in ")
    main(["warm"])
    assert capsys.readouterr().out == "all kernels are compiled already\n"
    assert ALONE not in os.environ


COMMANDS = (
    ["simulate", "--out", "s"],
    ["evaluate", "--episodes", "8", "--task", "ElbowFlexion", "--unadapted"],
    ["identify", "{curves}", "--joint", "elbow_flexion"],
)


@pytest.mark.slow
def test_after_it_no_command_compiles_for_long(tmp_path):
    from activesuit.assets import curves_path

    environment = {**os.environ, ALONE: "1"}

    def run(*arguments):
        program = [sys.executable, "-m", "activesuit.scripts.main", *arguments]
        found = subprocess.run(
            program, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert "Traceback" not in found.stderr
        return found

    run("warm")
    assert run("warm").stdout == "all kernels are compiled already\n"
    for command in COMMANDS:
        arguments = [one.format(curves=curves_path("elbow")) for one in command]
        assert "kernels" not in run(*arguments).stderr
