"""The tables of what motions cost the muscles, from the results in docs/measured."""

from collections.abc import Callable, Mapping
from typing import Any

from ..assets import JOINTS
from ..benchmarks.muscles import (
    ArmWork,
    Pushed,
    Strength,
    bare_table,
    pushed_table,
    strength_table,
)
from ..envs.evaluation import REFERENCES
from ..tables import markdown_table
from .measure import MUSCLE_SETTINGS, kept
from .results import PLACES, interval, percent, signed


def _muscle_scores(name: str) -> dict[str, Any]:
    """Returns the policies of an experiment of muscles, without references."""
    found = kept(name)["result"]["scores"]
    return {policy: one for policy, one in found.items() if policy not in REFERENCES}


def _setting_of(name: str) -> str:
    suit, place = MUSCLE_SETTINGS[name]
    return f"{suit}, {PLACES[place]}"


RELIEFS: dict[str, Callable[[dict[str, Any]], Mapping[str, float]]] = {
    "torque": lambda one: one["relief"],
    "activation": lambda one: one["muscles"]["effort_relief"],
    "power": lambda one: one["muscles"]["power_relief"],
}


def agreement(name: str, one: str, other: str) -> float:
    """Returns Kendall's tau between two reliefs over the policies of an experiment."""
    from scipy.stats import kendalltau  # slow to import

    scores = _muscle_scores(name).values()
    values = [[RELIEFS[what](score)["value"] for score in scores] for what in (one, other)]
    found: Any = kendalltau(*values)
    return float(found.statistic)


def disagreements(name: str, other: str) -> list[tuple[str, str]]:
    """Returns pairs of policies, better by torque and worse by muscles, by intervals apart."""
    scores = _muscle_scores(name)

    def better(one: str, two: str, what: str) -> bool:
        first, second = (RELIEFS[what](scores[policy]) for policy in (one, two))
        return first["low"] > second["high"]

    return [
        (one, two)
        for one in scores
        for two in scores
        if better(one, two, "torque") and better(two, one, other)
    ]


def muscle_agreement() -> str:
    """Returns the table of Kendall's tau in six settings."""
    header = ["setting", "torque, activation", "torque, power", "activation, power"]
    header += ["pairs turned round by activation", "by power"]
    pairs = (("torque", "activation"), ("torque", "power"), ("activation", "power"))
    rows = []
    for name in MUSCLE_SETTINGS:
        taus = [f"{agreement(name, *pair):.2f}" for pair in pairs]
        turned = [_turned(disagreements(name, other)) for other in ("activation", "power")]
        rows.append([_setting_of(name), *taus, *turned])
    return markdown_table(header, rows)


def _turned(pairs: list[tuple[str, str]]) -> str:
    return ", ".join(f"`{one}` and `{two}`" for one, two in pairs) or "-"


def muscle_power() -> str:
    """Returns the table of metabolic power in six settings."""
    header = ["setting", "unsuited", "suited", "compensation", "relief of power", "its range"]
    header += ["relief of activation", "of torque", "most loaded in the suit"]
    rows = []
    for name in MUSCLE_SETTINGS:
        found = kept(name)["result"]["scores"]
        watts = [
            f"{found[policy]['muscles']['power']['standard']:.0f} W"
            for policy in (*REFERENCES, "compensation")
        ]
        one = found["compensation"]
        low, high = one["muscles"]["power_relief_range"]
        loaded = found["suited"]["muscles"]["loaded"]
        rows.append(
            [
                *(_setting_of(name), *watts, interval(one["muscles"]["power_relief"])),
                f"{signed(low)} to {signed(high)}",
                *(interval(one["muscles"]["effort_relief"]), interval(one["relief"])),
                ", ".join(f"{muscle} {percent(value, 0)}" for muscle, value in loaded.items()),
            ]
        )
    return markdown_table(header, rows)


def muscle_conventions() -> str:
    """Returns the table of metabolic power under each convention, on Earth and weightless."""
    shown = ("muscles-mock-earth", "muscles-mock-microgravity", "muscles-emu-microgravity")
    header = ["convention"]
    for name in shown:
        header += [f"{_setting_of(name)}: suited less unsuited", "compensation gives back"]
    found = [kept(name)["result"]["scores"] for name in shown]
    rows = []
    for convention in found[0]["suited"]["muscles"]["power"]:
        cells = [convention]
        for one in found:
            unsuited, suited, helped = (
                one[policy]["muscles"]["power"][convention]
                for policy in (*REFERENCES, "compensation")
            )
            share = (suited - helped) / (suited - unsuited)
            cells += [f"{suited - unsuited:.1f} W", signed(share)]
        rows.append(cells)
    return markdown_table(header, rows)


def muscle_map() -> str:
    """Returns the table of errors of MyoArm in our posture."""
    found = kept("bench-muscles")["result"]["map"]
    rows = [[name, *(f"{value:.1f}" for value in values)] for name, values in found.items()]
    return markdown_table(["error", "mean", "largest"], rows)


def muscle_bare() -> str:
    """Returns the table of the bare arm beside published values."""
    found = [ArmWork(**one) for one in kept("bench-muscles")["result"]["bare"]]
    header, rows = bare_table(found)
    return markdown_table([name.replace("\n", " ") for name in header], rows)


def muscle_pushes() -> str:
    """Returns the table of pushed elbows."""
    found = [Pushed(**one) for one in kept("bench-muscles")["result"]["pushes"]]
    header, rows = pushed_table(found)
    return markdown_table([name.replace("\n", " ") for name in header], rows)


def muscle_strength() -> str:
    """Returns the table of strengths, those of one joint and way below each other."""
    found = kept("bench-muscles")["result"]["strength"]
    found = sorted(found, key=lambda one: (JOINTS.index(one["joint"]), one["way"]))
    fields = [{name: value for name, value in one.items() if name != "apart"} for one in found]
    strengths = [Strength(**one) for one in fields]
    header, rows = strength_table(strengths)
    sources = [one.source if one.apart else "" for one in strengths]
    rows = [[*row, source] for row, source in zip(rows, sources, strict=True)]
    return markdown_table([*header, "source of ours, where apart"], rows)


MUSCLE_TABLES: dict[str, Callable[[], str]] = {"bare": muscle_bare}
"""The tables of muscles.md by mark."""
