"""`activesuit warm`: compiles all kernels, and says when there is nothing left to compile."""

import os
import subprocess
import sys

import numpy as np
import pytest
from activesuit.envs.simulation.compiling import ALONE
from activesuit.hysteresis import first_use
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


def test_nothing_else_reports_progress_meanwhile(quick, monkeypatch, capsys):
    monkeypatch.setattr(first_use, "PATIENCE", -1.0)
    monkeypatch.setattr(first_use.listener, "_next", -1.0)
    main(["warm"])
    assert first_use.MESSAGE not in capsys.readouterr().err
    njit(lambda x: x + 1)(1.0)
    assert first_use.MESSAGE in capsys.readouterr().err


def test_the_record_has_a_loop_inside():
    record = module._record()
    turns = np.flatnonzero(np.diff(np.sign(np.diff(record.angle))))
    assert turns.size == 5
    assert record.torque[0] == 0


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
