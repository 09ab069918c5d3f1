"""Tables of docs/changes_of_numbers.md: numbers of suite version 2 beside the present ones."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..envs.benchmark.suites import Setting
from ..envs.evaluation import REFERENCES
from ..tables import markdown_table
from .measure import kept
from .results import PLACES, interval, percent, scores, standing, standings

SHOWN = ("none", "compensation", "adaptive", "observer", "iterative", "impedance")
SHOWN += ("disturbance-observer", "best-known-plan")
AIMED = ("ReachPanel", "ObjectRelocation", "RangeOfMotion")
AIMING = ("compensation", "adaptive", "observer", "best-known-plan")


def before() -> dict[str, Any]:
    """Returns the numbers of suite version 2."""
    return kept("suite-2")


def demo() -> str:
    """Returns efforts and reliefs of the demo, before and after."""
    header = ["place", "policy", "effort before", "effort", "relief before", "relief"]
    rows = []
    for place, found in before()["demo"].items():
        for name, old in found.items():
            new = scores(place)[name]
            title = "best known plan" if name == "best-known-plan" else name
            efforts = percent(old["effort"]), percent(new["effort"])
            reliefs = ("-" if name in REFERENCES else interval(one["relief"]) for one in (old, new))
            rows.append([PLACES[place], title, *efforts, *reliefs])
    return markdown_table(header, rows)


def levels() -> str:
    """Returns success and relief of policies over all tasks, before and after."""
    rows = []
    for level, found in before()["levels"].items():
        for name in SHOWN:
            old, new = found[name], standing(name, level)
            relief = "-" if new.relief is None else interval(new.relief.to_dict())
            success = old["success"].replace("%", " %"), percent(new.success, 0)
            rows.append([level, f"`{name}`", *success, old["relief"], relief])
    header = ["level", "policy", "success before", "success", "relief before", "relief"]
    return markdown_table(header, rows)


def aim() -> str:
    """Returns success, error and effort where arms must aim, before and after."""
    old = {
        (one["task"], one["level"], one["believed"], one["policy"]): one
        for one in before()["settings"]
    }
    rows = []
    for task in AIMED:
        for level, suit in (
            ("nominal", "mock-suit"),
            ("nominal", "emu-like"),
            ("shift", "emu-like"),
        ):
            for policy in AIMING:
                cells = _pairs(old[task, level, suit, policy], Setting(task, level, suit), policy)
                rows.append([task, f"{level}, {suit}", f"`{policy}`", *cells])
    header = ["task", "setting", "policy", "success", "error [mrad]", "effort"]
    return markdown_table(header, rows)


def _pairs(old: dict[str, Any], setting: Setting, policy: str) -> Iterator[str]:
    new = standings().of(setting, policy)
    if new is None:
        raise ValueError(f"{policy} has no result in {setting}")
    yield f"{percent(old['success'], 0)} -> {percent(float(np.mean(new.success)), 0)}"
    yield f"{1e3 * old['tracking']:.0f} -> {1e3 * float(np.mean(new.tracking)):.0f}"
    yield f"{percent(old['effort'])} -> {percent(float(np.mean(new.effort)))}"


CHANGES = {"demo": demo, "levels": levels, "aim": aim}
"""The tables by mark."""
