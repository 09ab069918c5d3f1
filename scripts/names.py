"""Names of options, read from the source text of their declarations without slow imports.

So a wrong name is reported before MuJoCo, SciPy and Numba are loaded, which takes seconds.
"""

import ast
import difflib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from ..errors import InputError
from .old_names import OLD_OPTIONS

PACKAGE = Path(__file__).parents[1]
DECLARED = {  # dataclasses whose fields are options, and their files
    "Setup": "envs/setup.py",
    **dict.fromkeys(("ArmConfig", "Payload"), "envs/model/config.py"),
    "Exo": "envs/model/exoskeleton.py",
    "Motor": "envs/model/motors.py",
    "Person": "envs/person/anthropometry.py",
    "VoluntaryControl": "envs/person/control.py",
    "Randomization": "envs/domain/randomization.py",
    "Sensing": "envs/simulation/measurements.py",
    "Faults": "envs/simulation/faults.py",
    "Corrections": "identification/corrections/corrections.py",
}
FLAT = ("arm", "corrections")  # fields and parameters whose own fields have no prefix
LIMIT, ALIAS = "max-episode-steps", "payload"  # of a task; short for payload.mass
STANDS_FOR = {  # parameters of commands that stand for many options
    "arm": ("ArmConfig", {ALIAS}),
    "environment": ("Setup", {ALIAS, LIMIT}),
    "options": ("Setup", {ALIAS, LIMIT, "level", "task", "env"}),
}


def check_names(command: str, arguments: Iterable[str]) -> None:
    """Refuses an option that a command does not have."""
    for given in arguments:
        name = given.partition("=")[0].replace("_", "-")
        known = option_names(command)
        if not name.startswith("--") or name[2:] in known or name == "--":
            continue
        if name in OLD_OPTIONS:
            raise InputError(f"{name} was an option of version 0.2: {OLD_OPTIONS[name]}")
        leaves = {path.rpartition(".")[2]: path for path in known} | {one: one for one in known}
        close = difflib.get_close_matches(name[2:], leaves, n=1)
        hint = f"did you mean --{leaves[close[0]]}?" if close else ""
        raise InputError(
            f"unknown option {name}: {hint or f'activesuit {command} --help lists all'}"
        )


@cache
def option_names(command: str) -> frozenset[str]:
    """Returns the names of the options of a command, without their two dashes."""
    words = command.split()
    (function,) = (
        node
        for node in _parsed(f"scripts/commands/{words[0]}.py").body
        if isinstance(node, ast.FunctionDef) and node.name == words[-1]
    )
    names = {"help"}
    for one in (*function.args.args, *function.args.kwonlyargs):
        kind = ast.unparse(one.annotation) if one.annotation else ""
        if one.arg in FLAT:
            names |= {*_fields(next(name for name in DECLARED if name in kind))}
        else:
            names.add("for" if kind == "Use" else one.arg.replace("_", "-"))
    if function.args.kwarg:
        declared, more = STANDS_FOR[function.args.kwarg.arg]
        names |= {*_fields(declared)} | more
    return frozenset(names)


def _fields(declared: str, prefix: str = "") -> Iterator[str]:
    """Yields the names of the options of a dataclass, whose fields are options."""
    (node,) = (
        node
        for node in _parsed(DECLARED[declared]).body
        if isinstance(node, ast.ClassDef) and node.name == declared
    )
    for one in node.body:
        if not isinstance(one, ast.AnnAssign) or not isinstance(one.target, ast.Name):
            continue
        name = one.target.id.replace("_", "-")
        kind = ast.unparse(one.annotation).removesuffix(" | None")
        if kind in DECLARED:
            yield from _fields(kind, prefix if name in FLAT else f"{prefix}{name}.")
        elif kind != "tuple[Person, ...]":  # several persons are no value of a flag
            yield prefix + name


@cache
def _parsed(file: str) -> ast.Module:
    return ast.parse((PACKAGE / file).read_text(encoding="utf-8"))
