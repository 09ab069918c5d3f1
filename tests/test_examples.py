"""The programs in examples/: each runs by itself."""

import os
import subprocess
import sys

import pytest
from activesuit.tools.pictures import EXAMPLE_PAGES, EXAMPLES


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.py")))
def test_it_runs_by_itself(name, tmp_path):
    done = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py", "--quick"],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert (tmp_path / f"{name}.png").exists() == (EXAMPLE_PAGES / f"{name}.png").exists()
