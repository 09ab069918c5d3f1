"""Kernels that are bound to arrays: one compilation serves all arms."""

import os
import subprocess
import sys
from pathlib import Path

import activesuit
import pytest
from activesuit.envs.simulation.compiling import ALONE

ROOT = Path(activesuit.__file__).parent.parent
PROGRAM = """
import activesuit
from activesuit.envs.making import make_arms
from activesuit.envs.reward import judge
from activesuit.envs.simulation.cycle import after, before

for suit in ("mock-suit", "none"):
    for coupling in ("rigid", "none", "cuffs"):
        for rows in (1, 3):
            make_arms("ActiveSuit/ArmTracking-v0", rows, suit=suit, coupling=coupling)
print(*(len(kernel.overloads) for kernel in (before, after, judge)))
"""


@pytest.mark.slow
def test_arms_without_a_suit_or_an_exoskeleton_need_no_kernels_of_their_own():
    environment = {**os.environ, ALONE: "1", "PYTHONPATH": str(ROOT)}
    found = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    assert found.stdout.split() == ["1", "1", "1"]
