"""The package as a whole: what importing it costs, and where the README leads."""

import os
import re
from pathlib import Path

import pytest
from helpers import python

ROOT = Path(__file__).parent.parent


def printed(code):
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return python("-c", code, check=True, env=clean, cwd=ROOT.parent).stdout


MAKE = "import activesuit, gymnasium; gymnasium.make('ActiveSuit/ElbowFlexion-v0').reset(seed=0)"


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import activesuit", "torch matplotlib numba scipy mujoco stable_baselines3"),
        (MAKE, "torch matplotlib stable_baselines3"),
        ("import activesuit.identification", "torch matplotlib mujoco pymoo cma"),
    ],
)
def test_slow_packages_are_not_imported(code, heavy):
    loaded = printed(f"{code}; import sys; print(*sys.modules)").split()
    assert not {*heavy.split()} & {*loaded}


README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_readme_links_exist():
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", README):
        assert (ROOT / target).exists(), target


def test_versions_agree():
    pyproject = (ROOT / "pyproject.toml").read_text()
    version = re.search(r'^version = "(.*)"', pyproject, re.M)[1]
    for name in ("__init__.py", "CHANGELOG.md", "CITATION.cff"):
        assert version in (ROOT / name).read_text(), name
