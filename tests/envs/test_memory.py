"""Environments give their memory back when they are closed and collected."""

import gc
import re
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from activesuit.envs.rendering import RenderingUnavailableError

STORED = 8  # compiled models, at most; see `envs/model/compose.py`
ENVIRONMENTS, PICTURED = 12, 3
linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")


def resident() -> float:
    """Returns the memory of this process that is in use [MB]."""
    gc.collect()
    found = re.search(r"VmRSS:\s+(\d+)", Path("/proc/self/status").read_text())
    assert found
    return int(found[1]) / 1024


def make(number: int, **options) -> gymnasium.Env:
    payload = {"mass": 0.1 * number}  # each has another model
    env = gymnasium.make("ActiveSuit/ElbowFlexion-v0", payload=payload, **options)
    env.reset(seed=0)
    env.step(np.zeros(2, np.float32))
    if options:
        env.render()
    return env


@linux
@pytest.mark.slow
def test_environments_give_their_memory_back():
    for number in range(STORED):  # fills the store of compiled models
        make(number)
    before = resident()
    kept = [make(number) for number in range(ENVIRONMENTS)]
    assert (resident() - before) / ENVIRONMENTS < 16  # MB; was 23
    for env in kept:
        env.close()
    del env, kept
    assert (resident() - before) / ENVIRONMENTS < 3  # MB; was 23


@linux
@pytest.mark.slow
@pytest.mark.render
def test_pictures_give_their_memory_back():
    small = {"render_mode": "rgb_array", "width": 320, "height": 240}
    for number in range(STORED - 1):
        make(number)
    try:
        make(STORED - 1, **small).close()
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    before = resident()
    kept = [make(number, **small) for number in range(PICTURED)]
    for env in kept:
        env.close()
    del env, kept
    assert (resident() - before) / PICTURED < 30  # MB, drivers keep some; was 306
