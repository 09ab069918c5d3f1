"""The second process that compiles the control cycle, and when it is begun."""

import os
from types import SimpleNamespace

import pytest
from activesuit.envs.simulation import compiling
from activesuit.hysteresis import first_use


@pytest.fixture
def begun(monkeypatch, tmp_path):
    """Returns the processes that are begun, on a machine with two cores and an empty cache."""
    found = []

    class Popen:
        def __init__(self, command, **options):
            self.command, self.options, self.waited = command, options, False
            found.append(self)

        def wait(self):
            self.waited = True

    monkeypatch.setattr(compiling.subprocess, "Popen", Popen)
    monkeypatch.setattr(compiling, "_begun", [])
    monkeypatch.setattr(compiling, "_cores", lambda: 2)
    monkeypatch.setattr(first_use.listener, "expected", first_use.WHOLE)
    monkeypatch.delenv(compiling.ALONE, raising=False)
    return found


def kernel(folder, compiled=True):
    """Returns a kernel, and writes its source and the index of its cache."""
    source = folder / "cycle.py"
    source.write_text("")
    if compiled:
        (folder / "cycle.before-68.py311.nbi").write_text("")
    code = SimpleNamespace(co_filename=str(source))
    function = SimpleNamespace(__name__="before", __code__=code)
    return SimpleNamespace(py_func=function, stats=SimpleNamespace(cache_path=str(folder)))


def test_one_process_is_begun_and_awaited(begun, tmp_path):
    for _ in range(2):
        compiling.begin(kernel(tmp_path, compiled=False))
    assert len(begun) == 1
    assert begun[0].options["env"][compiling.ALONE] == "1"  # it begins no other
    assert first_use.listener.expected == first_use.BESIDE
    assert not begun[0].waited
    compiling.wait()
    assert begun[0].waited


def test_a_cached_kernel_needs_none_until_its_source_changes(begun, tmp_path):
    own = kernel(tmp_path)
    compiling.begin(own)
    assert not begun
    os.utime(tmp_path / "cycle.py", (2e9, 2e9))
    compiling.begin(own)
    assert len(begun) == 1
