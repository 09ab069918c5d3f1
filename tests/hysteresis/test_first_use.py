"""A first use that compiles for long says so, once, and names the cache."""

import os
import subprocess
import sys

import pytest
from activesuit.hysteresis import first_use


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(first_use.time, "monotonic", lambda: now[0])
    return now


def test_long_compiling_is_announced_once(capsys, clock):
    listener = first_use.FirstUse()
    for seconds in (0.5, 1.0):
        listener.on_start(None)
        clock[0] += seconds
        listener.on_end(None)
        clock[0] += 100  # what happens between two functions is not compiling
    assert capsys.readouterr().err == ""
    listener.on_start(None)
    clock[0] += 0.6
    listener.on_start(None)  # a function inside
    assert capsys.readouterr().err == first_use.MESSAGE + "\n"
    listener.on_end(None)
    listener.on_end(None)
    clock[0] += 100
    listener.on_start(None)
    clock[0] += 100
    listener.on_end(None)
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_the_engine_alone_compiles_only_the_model_that_is_used(tmp_path):
    code = (
        "import mujoco, activesuit.hysteresis.engine as engine\n"
        "from activesuit.hysteresis import BoucWen\n"
        'spec = mujoco.MjSpec.from_string(\'<mujoco><worldbody><body><joint name="a"/>'
        '<geom size=".1"/></body></worldbody></mujoco>\')\n'
        "engine.attach(spec, 'a', BoucWen(elastic=1, hysteretic=1, beta=1, gamma=0, n=1))\n"
        "spec.compile()\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stderr in ("", first_use.MESSAGE + "\n")
    compiled = {path.parent.name.rpartition("_")[0] for path in tmp_path.rglob("*.nbi")}
    assert "bouc_wen" in compiled
    assert not {"preisach", "prandtl_ishlinskii", "jiles_atherton"} & compiled
