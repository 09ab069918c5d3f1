"""The programs in examples/: each runs by itself."""

import os

import pytest
from activesuit.tools.pictures import EXAMPLE_PAGES, EXAMPLES
from helpers import python


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.py")))
def test_it_runs_by_itself(name, tmp_path):
    given = {"cwd": tmp_path, "env": {**os.environ, "MPLBACKEND": "agg"}, "timeout": 500}
    done = python(EXAMPLES / f"{name}.py", "--quick", **given)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert (tmp_path / f"{name}.png").exists() == (EXAMPLE_PAGES / f"{name}.png").exists()
