"""The package as a whole: what importing it costs, and where the README leads."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent


def python(code):
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=clean,
        cwd=ROOT.parent,
    ).stdout


def test_import_is_light():
    loaded = python("import activesuit, sys; print(sorted(sys.modules))")
    for heavy in ("torch", "matplotlib", "numba", "scipy", "mujoco", "stable_baselines3"):
        assert f"'{heavy}'" not in loaded


def test_environments_need_neither_torch_nor_matplotlib():
    loaded = python(
        "import gymnasium, activesuit, sys;"
        "gymnasium.make('ActiveSuit/ElbowFlexion-v0').reset(seed=0);"
        "print(sorted(sys.modules))"
    )
    for heavy in ("torch", "matplotlib", "stable_baselines3"):
        assert f"'{heavy}'" not in loaded


def test_identification_is_light():
    loaded = python("import activesuit.identification, sys; print(sorted(sys.modules))")
    for heavy in ("torch", "matplotlib", "mujoco", "pymoo", "cma"):
        assert f"'{heavy}'" not in loaded


README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_readme_links_exist():
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", README):
        assert (ROOT / target).exists(), target


def test_versions_agree():
    pyproject = (ROOT / "pyproject.toml").read_text()
    version = re.search(r'^version = "(.*)"', pyproject, re.M)[1]
    for name in ("__init__.py", "CHANGELOG.md", "CITATION.cff"):
        assert version in (ROOT / name).read_text(), name
