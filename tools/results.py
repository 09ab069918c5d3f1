"""Tables of README and docs from the results in docs/measured and docs/leaderboard.jsonl."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from ..benchmarks.muscles import ArmWork, bare_table
from ..benchmarks.pushes import pushes_table
from ..envs.benchmark.results import read_results
from ..envs.benchmark.standings import Standing, Standings
from ..envs.evaluation import REFERENCES
from ..tables import markdown_table
from .leaderboard import RESULTS
from .measure import kept, mean

WEIGHTLESS = "microgravity"
PLACES = {"earth": "Earth", "mars": "Mars", "moon": "Moon", WEIGHTLESS: "microgravity"}


def percent(share: float, digits: int = 1) -> str:
    """Returns a share in percent, as "6.7 %"."""
    return f"{100 * share:.{digits}f} %"


def interval(found: Mapping[str, float] | None) -> str:
    """Returns a value with its 95 % interval, as "0.70 (0.66 to 0.73)"."""
    if found is None:
        return "-"
    value, low, high = (signed(found[name]) for name in ("value", "low", "high"))
    return f"{value} ({low} to {high})"


def signed(value: float) -> str:
    """Returns a number with two digits, and never as -0.00."""
    return f"{value:.2f}".replace("-0.00", "0.00")


# The demo.


def scores(place: str) -> dict[str, Any]:
    """Returns the scores of the demo at a place, by policy."""
    return kept("demo")["result"]["evaluation"][place]["scores"]


def _effects(names: Mapping[str, str]) -> str:
    header = ["", "effort, Earth", "relief, Earth", "effort, microgravity", "relief, microgravity"]
    rows = []
    for name, title in names.items():
        cells = [title]
        for place in ("earth", WEIGHTLESS):
            one = scores(place)[name]
            relief = {"unsuited": "1", "suited": "0"}.get(name) or interval(one["relief"])
            cells += [percent(mean(one["effort"])), relief]
        rows.append(cells)
    return markdown_table(header, rows)


def door() -> str:
    """Returns README's table, and what it says in words."""
    table = _effects(
        {
            "suited": "suit, no exoskeleton",
            "none": "exoskeleton, motors off",
            "feedforward": "suit torque cancelled (`feedforward`)",
            "compensation": "suit, weight and friction (`compensation`)",
            "best-known-plan": "best known plan (`best-known-plan`)",
        }
    )
    earth, space = scores("earth"), scores(WEIGHTLESS)
    bare, suited = (
        [percent(mean(place[name]["effort"])) for place in (earth, space)] for name in REFERENCES
    )
    return (
        f"{table}\n\nThe suit raises effort from {bare[0]} to {suited[0]} of strength on Earth, "
        f"and from {bare[1]} to {suited[1]} in microgravity.\n"
        "Motors that are off add weight and gear friction, "
        "and on Earth cancelling the suit alone does not make up for that weight."
    )


# Sixteen settings.


@cache
def settings() -> dict[tuple[str, str, str], dict[str, Any]]:
    """Returns the evaluations by place, suit and coupling."""
    found = kept("settings")["result"]["settings"]
    return {(one["gravity"], one["suit"], one["coupling"]): one for one in found}


def reliefs() -> str:
    """Returns relief in all settings: a row for each setting, a column for each policy."""
    first = next(iter(settings().values()))["scores"]
    policies = [name for name in first if name not in REFERENCES]
    rows = []
    for (place, suit, coupling), one in settings().items():
        found = (signed(one["scores"][name]["relief"]["value"]) for name in policies)
        rows.append([suit, coupling, PLACES[place], percent(one["suit_cost"]["value"]), *found])
    header = ["suit", "coupling", "place", "cost of the suit", *(f"`{name}`" for name in policies)]
    return markdown_table(header, rows)


# The leaderboard.


@cache
def standings() -> Standings:
    """Returns the standings of the committed results."""
    return Standings(read_results([RESULTS]))


@cache
def standing(policy: str, level: str) -> Standing:
    """Returns how a policy stands at a level, over all tasks and both beliefs."""
    return standings().standing(policy, standings().settings_at(level))


def relief_at(policy: str, level: str) -> str:
    """Returns the mean relief of a policy at a level of the leaderboard, as "0.87"."""
    found = standing(policy, level).relief
    return "-" if found is None else signed(found.value)


def pushes() -> str:
    """Returns the table of pushed arms of usual and of persistent wearers."""
    return markdown_table(*pushes_table(kept("pushes")["result"]["wearers"]))


def muscle_bare() -> str:
    """Returns the table of the bare arm beside published values."""
    found = [ArmWork(**one) for one in kept("bench-muscles")["result"]["bare"]]
    header, rows = bare_table(found)
    return markdown_table([name.replace("\n", " ") for name in header], rows)
