"""The golden results are computed again."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_golden_results_are_equal():
    program = Path(__file__).with_name("golden.py")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr
