"""Kernels of the control cycle: one compilation serves all arms, begun in a second process."""

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import activesuit
import pytest
from activesuit.envs.simulation import compiling

ROOT = Path(activesuit.__file__).parent.parent
PROGRAM = """
import activesuit
from activesuit.envs.making import make_arms
from activesuit.envs.interface.reward import judge
from activesuit.envs.simulation.cycle import after, before

for suit in ("mock-suit", "none"):
    for coupling in ("rigid", "none", "cuffs"):
        for rows in (1, 3):
            make_arms("ActiveSuit/ArmTracking-v0", rows, suit=suit, coupling=coupling)
print(*(len(kernel.overloads) for kernel in (before, after, judge)))
"""


@pytest.mark.slow
def test_arms_without_a_suit_or_an_exoskeleton_need_no_kernels_of_their_own():
    environment = {**os.environ, compiling.ALONE: "1", "PYTHONPATH": str(ROOT)}
    program = [sys.executable, "-c", PROGRAM]
    found = subprocess.run(program, env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["1", "1", "1"]


def test_one_process_is_begun_where_the_cache_is_old_and_awaited(monkeypatch, tmp_path):
    begun, waited = [], []

    def process(command, env, **options):
        begun.append(env)
        return SimpleNamespace(wait=lambda: waited.append(env))

    monkeypatch.setattr(compiling.subprocess, "Popen", process)
    monkeypatch.setattr(compiling, "_begun", [])
    monkeypatch.setattr(compiling, "_cores", lambda: 2)
    monkeypatch.delenv(compiling.ALONE, raising=False)
    source = tmp_path / "cycle.py"
    function = SimpleNamespace(__name__="before", __code__=SimpleNamespace(co_filename=str(source)))
    kernel = SimpleNamespace(py_func=function, stats=SimpleNamespace(cache_path=str(tmp_path)))
    for name in ("cycle.py", "cycle.before-68.py311.nbi"):  # a source, and its cache
        (tmp_path / name).write_text("")
    compiling.begin(kernel)
    assert not begun
    os.utime(source, (2e9, 2e9))
    for _ in range(2):
        compiling.begin(kernel)
    assert len(begun) == 1 and begun[0][compiling.ALONE] == "1"  # it begins no other
    assert not waited
    compiling.wait()
    assert waited
