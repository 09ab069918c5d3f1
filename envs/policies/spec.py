"""A policy as plain data: its name and its options, from text, a dict or a JSON file."""

import os
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ...errors import InputError, shown
from ...json_files import read_json

_FIXES: dict[Any, str] = {
    int: "give a whole number",
    float: "give a number",
    float | None: "give a number",
    bool: "use true or false",
}


@dataclass(frozen=True)
class PolicySpec:
    """A policy as plain data: its name, and the options that are not the default ones.

    The name is one of `POLICIES` or `shipped_policies`, the folder of a training run, or
    "package.module:Class" for a class of your own.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        flat = ",".join(f"{name}={given}" for name, given in _flat(self.options))
        return f"{self.name}:{flat}" if flat else self.name

    def to_dict(self) -> dict[str, Any]:
        """Returns plain values: the name, and each option by name."""
        return {"name": self.name, **self.options}


AnyPolicy = str | Mapping[str, Any] | PolicySpec
"""A policy by its name, as "name:option=value,option=value", or as a dict of name and options."""


def is_saved(text: str) -> bool:
    """Returns whether a text names a JSON file of a policy, and not a policy with options."""
    return text.endswith(".json") and "=" not in text


def parsed(given: AnyPolicy, names: Container[str], *, trust: bool) -> PolicySpec:
    """Returns a policy as data, with unchecked options; `given` and `trust` as in `policy_spec`.

    After one of `names` a colon begins options; after other names a colon begins a class.
    """
    if isinstance(given, PolicySpec):
        return given
    if isinstance(given, Mapping) and isinstance(given.get("name"), str):
        return PolicySpec(given["name"], {k: v for k, v in given.items() if k != "name"})
    if not isinstance(given, str):
        raise InputError(
            f"the policy is {shown(given)}: give a name, such as 'compensation', or a dict with one"
        )
    if os.path.isdir(given):
        return PolicySpec(given)
    if is_saved(given):
        return _read(given, trust)
    head, *rest = given.split(":")
    if rest and "=" not in rest[0] and head not in names:
        head, rest = f"{head}:{rest[0]}", rest[1:]
    options: dict[str, Any] = {}
    for option in filter(None, ":".join(rest).split(",")):
        name, equal, value = option.partition("=")
        if not equal:
            raise InputError(
                f"policy {given!r} has {shown(option)}: give options as option=value, with commas "
                "between them"
            )
        *outer, last = name.strip().split(".")
        place: Any = options
        for part in outer:
            place = place.setdefault(part, {}) if isinstance(place, dict) else None
        if not isinstance(place, dict):
            raise InputError(
                f"policy {given!r} has {'.'.join(outer)!r} with a value and with fields: give one"
            )
        if last in place:
            raise InputError(f"policy {given!r} has the option {name!r} twice: give it once")
        place[last] = _number(value.strip()) if outer else value.strip()
    return PolicySpec(head, options)


def _read(file: str, trust: bool) -> PolicySpec:
    found = read_json(file, "policy")
    if not isinstance(found, dict) or not isinstance(found.get("name"), str):
        raise InputError(f"{file!r} is no policy: it must be an object with a name")
    name = found.pop("name")
    if ":" in name and not os.path.isdir(name) and not trust:
        raise InputError(
            f"{file!r} names {shown(name)}, and importing that would run its code: use a file "
            "with a policy of this package or the folder of a training run, or, if you trust "
            "the file, add --trust (in Python policy_spec(file, trust=True))"
        )
    return PolicySpec(name, found)


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _flat(options: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in options.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield before + name, value


def typed(what: str, value: Any, kind: Any) -> Any:
    """Returns a value, or a text of that value, as the type of its option."""
    if isinstance(value, bool) and kind in (int, float):
        raise InputError(f"{what} is {value}: give a number")
    try:
        adapter = TypeAdapter(kind, config=ConfigDict(arbitrary_types_allowed=True))
        return adapter.validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise InputError(f"{what} is {shown(value)}: {_FIXES.get(kind, problem)}") from None
