"""Tables of README and docs that are made from measured results.

The results are those that `measure.py` keeps in docs/measured, and docs/leaderboard.jsonl.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from ..benchmarks.muscles import ArmWork, bare_table
from ..envs.benchmark.results import read_results
from ..envs.benchmark.standings import Standing, Standings
from ..envs.evaluation import REFERENCES
from ..envs.model.cuffs import FORCE_LIMITS
from ..tables import markdown_table
from .leaderboard import RESULTS
from .measure import kept

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
            cells += [percent(one["effort"]), relief]
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
    bare, suited = ([percent(p[name]["effort"]) for p in (earth, space)] for name in REFERENCES)
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


def _matrix(columns: Mapping[str, Mapping[str, Any]]) -> str:
    """Returns relief by policy, with a column for each evaluation."""
    costs = [percent(one["suit_cost"]["value"]) for one in columns.values()]
    rows = [["the suit costs, of strength", *costs]]
    names = next(iter(columns.values()))["scores"]
    for name in names:
        if name not in REFERENCES:
            reliefs = (interval(one["scores"][name]["relief"]) for one in columns.values())
            rows.append([f"`{name}`", *reliefs])
    return markdown_table(["policy", *columns], rows)


def all_settings() -> str:
    """Returns relief in all settings, then a table of each."""
    parts = []
    for suit, coupling in dict.fromkeys(key[1:] for key in settings()):
        here = {
            PLACES[place]: one
            for (place, *rest), one in settings().items()
            if tuple(rest) == (suit, coupling)
        }
        parts += [f"## Relief: {suit}, {coupling}", _matrix(here)]
    parts.append("## Each setting")
    for (place, suit, coupling), one in settings().items():
        parts += [f"**{PLACES[place]}, {suit}, {coupling}**", _setting(one["scores"])]
    return "\n\n".join(parts)


def _setting(found: Mapping[str, Any]) -> str:
    header = ["policy", "effort", "relief", "of the bound", "shoulder, elbow [N·m]"]
    rows = []
    for name, one in found.items():
        share, torque = one["share_of_bound"], one["torque"]
        rows.append(
            [
                f"`{name}`",
                percent(one["effort"]),
                interval(one["relief"]),
                "-" if share is None else percent(share["value"], 0),
                f"{torque['shoulder_flexion']:.2f}, {torque['elbow_flexion']:.2f}",
                f"{1e3 * one['tracking']:.0f}",
                percent(one["success"], 0),
                f"{one['reward']:.2f}",
            ]
        )
    return markdown_table([*header, "error [mrad]", "success", "reward"], rows)


def spread(values: Iterable[float]) -> str:
    """Returns the least and the greatest of some values, as "0.86 to 1.00"."""
    found = list(values)
    return f"{min(found):.2f} to {max(found):.2f}"


def findings() -> str:
    """Returns what the settings show, as a list."""
    found = settings()
    named = {"unsuited": "unsuited", "suited": "suited", "none": "motors off"}
    named |= {"compensation": "compensation", "best-known-plan": "best known plan"}
    levels = (
        f"{title} {spread(one['scores'][name]['reward'] for one in found.values())}"
        for name, title in named.items()
    )
    ranks = [_rank_correlation(one["scores"]) for one in found.values()]
    same = sum(rank > 0.999 for rank in ranks)
    stiff = found[WEIGHTLESS, "emu-like", "rigid"]["scores"]["compensation"]
    cuffs = found[WEIGHTLESS, "emu-like", "cuffs"]["scores"]
    drifting, cancelled, best = (
        cuffs[n] for n in ("compensation", "feedforward", "best-known-plan")
    )
    reliefs = [one["relief"]["value"] for one in (stiff, drifting, cancelled, best)]
    shares = [list(_each(one["scores"], "beginning")) for one in found.values()]
    first = 100 * np.mean(shares, axis=1)
    lines = [
        f"**The levels of the mean reward are alike everywhere**: {', '.join(levels)}.",
        f"**The first half second** has {first.min():.1f} to {first.max():.1f} % of "
        "the return, about its share of the time.",
        f"**The reward ranks policies as relief does** in {same} of the {len(ranks)} settings. In "
        f"the others the rank correlation is at least {min(ranks):.2f}: neighbours of almost the "
        "same relief change places, since the reward also charges tracking and chatter.",
        "**A strong suit on cuffs is another matter.** The cuffs yield, so that the encoders show "
        "another angle than the arm's. In microgravity and the emu-like suit `compensation` "
        f"falls from {reliefs[0]:.2f} to {reliefs[1]:.2f}, below `feedforward` ({reliefs[2]:.2f}). "
        f"It presses up to {drifting['cuff_peak']['upper_arm']:.0f} N on the upper arm, where "
        f"{FORCE_LIMITS['upper_arm']:.0f} N is what a person should bear, and "
        f"{percent(drifting['success'], 0)} of its motions succeed. The best known plan, which "
        f"allows for the cuffs, keeps {reliefs[3]:.2f}. `corrected` estimates the arm's angles "
        "from the cuffs' forces ([Controllers](controllers.md#the-policies)).",
    ]
    return "\n".join(f"- {line}" for line in lines)


def _each(found: Mapping[str, Any], field: str) -> Iterable[float]:
    return (one[field] for one in found.values())


def _rank_correlation(found: Mapping[str, Any]) -> float:
    """Returns Kendall's tau between mean reward and relief over the policies of a setting."""
    from scipy.stats import kendalltau

    judged = [one for name, one in found.items() if name not in REFERENCES]
    reliefs = [one["relief"]["value"] for one in judged]
    rank: Any = kendalltau(reliefs, [one["reward"] for one in judged])
    return float(rank.statistic)


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


def muscle_bare() -> str:
    """Returns the table of the bare arm beside published values."""
    found = [ArmWork(**one) for one in kept("bench-muscles")["result"]["bare"]]
    header, rows = bare_table(found)
    return markdown_table([name.replace("\n", " ") for name in header], rows)


RESULT_TABLES: dict[str, dict[str, Callable[[], str]]] = {
    "../README.md": {"results": door},
    "muscles.md": {"bare": muscle_bare},
    "results.md": {"findings": findings, "settings": all_settings},
}
"""The tables by page and mark."""
