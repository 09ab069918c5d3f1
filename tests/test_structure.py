"""The structure of the source tree: who imports whom, what is private, where names are listed."""

import ast
import re
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGES = PYPROJECT["tool"]["setuptools"]["packages"]

# Which part may import which; everything may import the modules of the root.
ALLOWED = {
    "assets": {"hysteresis"},
    "hysteresis": set(),
    "identification": {"hysteresis"},
    "envs": {"hysteresis", "assets"},
    "scripts": {"assets", "hysteresis", "identification", "envs"},
    "benchmarks": {"assets", "hysteresis", "identification", "envs", "scripts"},
    "reproductions": {"assets", "hysteresis", "identification"},
    "tools": {"assets", "benchmarks", "hysteresis", "identification", "envs", "scripts"},
}
# Folders of the source repository that are not installed: speed, honesty and the readable models
# that kernels are compared with; repeated papers; programs for developers.
NOT_INSTALLED = {("benchmarks",), ("reproductions",), ("tools",)}
ROOT_MODULES = {path.stem for path in ROOT.glob("*.py")}

Name = tuple[str, ...]  # a module below `activesuit`: ("hysteresis", "registry")


@dataclass(frozen=True)
class Import:
    """One import of our own code."""

    target: Name  # imported module; the `__init__` of a package
    name: str | None  # imported name; None for the module itself
    runs: bool  # whether the import ever runs; others are for type checkers
    line: int


@cache
def sources() -> dict[Name, Path]:
    """Returns the files of the package, by module."""
    inside = [path for part in ALLOWED for path in (ROOT / part).rglob("*.py")]
    paths = [*ROOT.glob("*.py"), *inside]
    return {path.relative_to(ROOT).with_suffix("").parts: path for path in sorted(paths)}


@cache
def imports(path: Path) -> tuple[Import, ...]:
    """Returns the imports of our own modules in a source file or a test."""
    return tuple(_imports(ast.parse(path.read_text(encoding="utf-8")), path.relative_to(ROOT)))


def _imports(tree: ast.AST, path: Path, runs: bool = True) -> Iterator[Import]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ImportFrom) and (base := _base(node, path)) is not None:
            for alias in node.names:
                inside = _module((*base, alias.name))
                target, name = (inside, None) if inside else (_module(base), alias.name)
                assert target, f"{path}:{node.lineno} imports {base}, which does not exist"
                yield Import(target, name, runs, node.lineno)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("activesuit."):
                    target = _module(tuple(alias.name.split(".")[1:]))
                    assert target, f"{path}:{node.lineno} imports {alias.name}"
                    yield Import(target, None, runs, node.lineno)
        else:
            typed = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
            yield from _imports(node, path, runs and not typed)


def _base(node: ast.ImportFrom, path: Path) -> Name | None:
    """Returns the module after `from`, or None if it is not ours."""
    named = tuple(node.module.split(".")) if node.module else ()
    if node.level:
        package = path.parent.parts
        return (*package[: len(package) - node.level + 1], *named)
    return named[1:] if named[:1] == ("activesuit",) else None


def _module(name: Name) -> Name | None:
    return next((one for one in (name, (*name, "__init__")) if one in sources()), None)


def circles(graph: dict[str, set[str]]) -> list[str]:
    """Returns the names along a circle of a graph; nothing if it has none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_circle_between_modules():
    graph = {
        ".".join(name): {".".join(one.target) for one in imports(path) if one.runs}
        for name, path in sources().items()
    }
    assert not circles(graph)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_circle_between_the_parts_of_a_package(package):
    # Files and subfolders of one folder; its __init__ stands before them and imports them all.
    folder = tuple(package.split(".")[1:])
    graph = defaultdict(set)
    for name, path in sources().items():
        if name[: len(folder)] != folder or name[len(folder)] == "__init__":
            continue
        for one in imports(path):
            inside = one.target[: len(folder)] == folder and one.target[len(folder)] != "__init__"
            if inside and one.runs:
                graph[name[len(folder)]].add(one.target[len(folder)])
    assert not circles({part: targets - {part} for part, targets in graph.items()})


def against(rule: Callable[[Name, Import], bool]) -> list[str]:
    """Returns the imports of the package that a rule about module and import forbids."""
    return [
        f"{path.relative_to(ROOT)}:{one.line} imports {'.'.join(one.target)}"
        for name, path in sources().items()
        for one in imports(path)
        if rule(name, one)
    ]


@pytest.mark.parametrize("part", ALLOWED)
def test_no_arrow_up(part):
    allowed = ALLOWED[part] | {part} | ROOT_MODULES
    assert not against(lambda name, one: name[0] == part and one.target[0] not in allowed)


def test_modules_of_the_root_import_no_folder():
    assert not against(lambda name, one: len(name) == 1 and len(one.target) > 1)


@pytest.mark.parametrize("part", ["hysteresis", "identification"])
def test_only_the_engine_and_warp_know_mujoco(part):
    for path in sorted((ROOT / part).rglob("*.py")):
        if not {"engine", "warp"} & set(path.parts):
            assert "mujoco" not in re.findall(r"^\s*(?:import|from) (\w+)", path.read_text(), re.M)


def test_underscores_are_private_to_their_folder():
    tests = sorted((ROOT / "tests").rglob("*.py"))
    opened = {
        f"{path.relative_to(ROOT)}:{one.line} imports {'.'.join(one.target)}"
        + (f": {one.name}" if _is_private(one.name or "") else "")
        for path in (*sources().values(), *tests)
        for one in imports(path)
        if (_is_private(one.target[-1]) or _is_private(one.name or ""))
        and not path.is_relative_to(ROOT.joinpath(*one.target[:-1]))
    }
    assert not opened, "\n".join(sorted(opened))


def _is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def test_choices_of_the_command_line_come_from_registries():
    import gymnasium
    from activesuit.assets import JOINTS, suit_names
    from activesuit.envs.model.config import GRAVITY
    from activesuit.envs.policies import POLICIES
    from activesuit.hysteresis import MODELS
    from activesuit.identification.methods import method_names

    environments = [name for name in gymnasium.registry if name.startswith("ActiveSuit/")]
    known = {*MODELS, *method_names(), *POLICIES, *environments, *suit_names(), *GRAVITY, *JOINTS}
    for name, path in sources().items():
        if name[0] != "scripts":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Subscript) and ast.unparse(node.value).endswith("Literal"):
                listed = {one.value for one in ast.walk(node) if isinstance(one, ast.Constant)}
                assert not listed & (known - {"none"}), f"{path}:{node.lineno}"


def _is_installed(name: Name) -> bool:
    return not any(name[: len(folder)] == folder for folder in NOT_INSTALLED)


def test_installed_modules_need_no_others():
    assert not against(lambda name, one: _is_installed(name) and not _is_installed(one.target))


def test_nothing_that_is_installed_imports_an_extra():
    # `envs.extras` finds them by their names, so that this package works as without them.
    extras = PYPROJECT["project"]["entry-points"]
    rooms = {
        tuple(found.partition(":")[0].split(".")[1:-1])
        for kind in ("activesuit.scores", "activesuit.drawings")
        for found in extras[kind].values()
    }
    assert rooms
    assert not against(
        lambda name, one: (
            _is_installed(name)
            and any(name[: len(room)] != room == one.target[: len(room)] for room in rooms)
        )
    )


def test_every_folder_is_packaged():
    installed = filter(_is_installed, sources())
    folders = {".".join(("activesuit", *name[:-1])) for name in installed}
    assert sorted(folders) == sorted(PACKAGES)
    assert all(_module(tuple(package.split(".")[1:])) for package in PACKAGES)
