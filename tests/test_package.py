"""The package as a whole: what importing costs, which part may use which, what the README shows."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# Which part may import which; everything may use the root's errors and files.
ALLOWED = {
    "assets": {"hysteresis"},
    "hysteresis": set(),
    "identification": {"hysteresis"},
    "envs": {"hysteresis", "assets"},
    "scripts": {"assets", "hysteresis", "identification", "envs"},
}
ROOT_MODULES = {"arrays", "checks", "errors", "files", "published", "__version__"}


def modules(part):
    return sorted((ROOT / part).rglob("*.py"))


def relative_imports(path):
    """Yields, for each relative import of a file, the path of parts below the root it names."""
    package = list(path.relative_to(ROOT).parent.parts)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            yield (
                [*base, *(node.module or "").split(".")]
                if node.module
                else base + [alias.name for alias in node.names]
            )


@pytest.mark.parametrize("part", ALLOWED)
def test_imports_follow_the_architecture(part):
    for path in modules(part):
        for target in relative_imports(path):
            assert target[0] in ALLOWED[part] | {part} | ROOT_MODULES, f"{path} imports {target}"


@pytest.mark.parametrize("part", ["hysteresis", "identification"])
def test_only_the_engine_knows_mujoco(part):
    for path in modules(part):
        if "engine" not in path.parts:
            assert "mujoco" not in re.findall(r"^\s*(?:import|from) (\w+)", path.read_text(), re.M)


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
EXAMPLES = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_readme_has_its_three_examples():
    assert len(EXAMPLES) >= 3


@pytest.mark.parametrize("example", EXAMPLES)
def test_readme_examples_run(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "README.md", "exec"), {"__name__": "__main__"})


def test_readme_links_exist():
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", README):
        assert (ROOT / target).exists(), target


def test_versions_agree():
    pyproject = (ROOT / "pyproject.toml").read_text()
    version = re.search(r'^version = "(.*)"', pyproject, re.M)[1]
    for name in ("__init__.py", "CHANGELOG.md", "CITATION.cff"):
        assert version in (ROOT / name).read_text(), name
