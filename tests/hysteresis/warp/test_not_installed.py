"""What happens without MuJoCo Warp, which nothing but the extra `gpu` brings."""

import sys

import pytest
from activesuit.benchmarks import gpu
from activesuit.errors import InputError
from activesuit.hysteresis.warp import attach
from helpers import python

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("call", [lambda: attach(0, 0, 0, {}), lambda: gpu.rows(1, [1])])
def test_one_sentence_says_what_to_install(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "warp", None)
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(InputError, match=r"MuJoCo Warp .*: run pip install 'activesuit\[gpu\]'"):
        call()


def test_nothing_else_imports_warp():
    program = "import sys, activesuit.envs, activesuit.hysteresis.warp, activesuit.envs.model\n"
    program += "sys.exit(any('warp' == name.split('.')[0] for name in sys.modules))"
    assert python("-c", program).returncode == 0
