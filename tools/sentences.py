"""Numbers in sentences that are written by hand: what they must be, from the measured results.

A test looks for each in its page; where it is missing, the result has changed, and the sentence
must follow.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from scipy.stats import kendalltau

from ..envs.benchmark.suites import BELIEVED, Setting
from ..envs.evaluation import REFERENCES
from .learners import LEARNERS, kept_learner
from .measure import MUSCLE_SETTINGS, kept
from .results import interval, relief_at, signed, standing, standings

AIMED = ("ReachPanel", "ObjectRelocation")
LOADED = ("ObjectRelocation", "Ratchet")
REPEATED = ("Ratchet", "Handrail", "Scoop")
RELIEFS: dict[str, Callable[[dict[str, Any]], Mapping[str, float]]] = {
    "torque": lambda one: one["relief"],
    "activation": lambda one: one["muscles"]["effort_relief"],
    "power": lambda one: one["muscles"]["power_relief"],
}


def _benchmark() -> Iterator[str]:
    best = [relief_at("best-known-plan", level) for level in standings().levels]
    yield f"most relief at every level: {best[0]}, {best[1]} and {best[2]}"
    alike = standing("predictive", "nominal").compared
    if alike is not None:
        yield f"about as much relief in {100 * alike[1]:.0f} % of the motions at nominal"
    adaptive = standing("adaptive", "shift").compared
    if adaptive is not None:
        yield f"in {100 * adaptive[0]:.0f} % of the motions, and less in {100 * adaptive[2]:.0f} %"
    usual, sees = (
        [_success(task, "nominal", suit, policy) for task in AIMED for suit in BELIEVED]
        for policy in ("compensation", "impedance")
    )
    yield f"succeeds in {min(usual):.0f} to {max(usual):.0f} % of these motions at nominal"
    yield f"sees the intention, in {min(sees):.0f} to {max(sees):.0f} %"
    harm, less = (
        " and ".join(_relief(task, "randomized", "mock-suit", policy) for task in LOADED)
        for policy in ("disturbance-observer", "observer")
    )
    yield f"(relief {harm} in the mock suit at randomized), and so does `observer` ({less})"
    learned, fixed = (
        "{}, {} and {}".format(*(_relief(task, "nominal", "emu-like", one) for task in REPEATED))
        for one in ("iterative", "compensation")
    )
    yield f"`iterative` gives back {learned} where compensation gives {fixed}"
    gains = [one["gain"] for one in kept("bound")["result"]["attacks"] if one["gain"] is not None]
    yield f"The largest gain is {max(gains):.3f}"


def _success(task: str, level: str, suit: str, policy: str) -> float:
    """Returns the share of motions that succeed [%]."""
    found = standings().of(Setting(task, level, suit), policy)
    return np.nan if found is None else 100 * float(np.mean(found.success))


def _relief(task: str, level: str, suit: str, policy: str) -> str:
    found = standings().relief(Setting(task, level, suit), policy)
    return "-" if found is None else f"{found.mean():.2f}"


def _model() -> Iterator[str]:
    cases = [one for one in kept("sensitivity")["result"]["cases"] if one["change"] != "nominal"]
    turned = sum("observer relieves more than compensation" in one["flipped"] for one in cases)
    yield f"{turned} of {len(cases)} changes turn their order"


def _training() -> Iterator[str]:
    for name, learner in LEARNERS.items():
        found = kept_learner(name)["result"]
        versions = (f"{title} {found['versions'][one]}" for one, title in learner.packages.items())
        scored = "scores" in found  # results of 0.2 have the interval alone
        one = (
            found["scores"][learner.policy]["relief"] if scored else found["relief"][learner.policy]
        )
        relief = interval(one)
        yield f"(learners/{learner.program}) | {', '.join(versions)} | {relief} |"


def _gpu() -> Iterator[str]:
    rows = kept("bench-gpu-h200")["result"]["rows"]
    more = [100 * (1 / one["ratio"] - 1) for one in rows]
    yield f"adds {min(more):.1f} to {max(more):.1f} % to the time of a step"
    yield f"16,384 worlds take {1e3 / rows[-1]['ours']:.1f} million steps per second"


def _device() -> Iterator[str]:
    rows = {one["model"]: one for one in kept("bench-device")["result"]["rows"]}
    preisach = rows["preisach"]
    others = [one for name, one in rows.items() if name != "preisach"]
    state, tables = ([4 * one[name] for one in others] for name in ("state", "constants"))
    yield f"has {min(state)} to {max(state)} bytes in float, and the tables (flash) {min(tables)}"
    yield f"to {max(tables)}; a Preisach model has {4 * preisach['state']} and"
    yield f"{4 * preisach['constants']:,}, since it remembers 64 nested turning points"
    worst = (max(one[kind]["difference"] for one in rows.values()) for kind in ("float", "double"))
    single, double = (f"{one:.0e}".replace("e-0", "e-") for one in worst)
    yield f"float differs by at most {single} of the peak torque, and double by {double}"


def _muscles() -> Iterator[str]:
    pairs = (("torque", "activation"), ("torque", "power"), ("activation", "power"))
    least = min(_agreement(name, *pair) for name in MUSCLE_SETTINGS for pair in pairs)
    yield f"Kendall's tau is {least:.2f} or more in each of six settings"
    earth = [_compensation(f"muscles-{suit}-earth") for suit in ("mock", "emu")]
    torque = " and ".join(signed(one["relief"]["value"]) for one in earth)
    activation = " and ".join(signed(one["muscles"]["effort_relief"]["value"]) for one in earth)
    yield f"relief of compensation by torque is {torque}. By activation it is {activation}"
    low, high = _compensation("muscles-mock-microgravity")["muscles"]["power_relief_range"]
    yield f"the range goes from {signed(low)} to {signed(high)}"
    yield f"wrists are {kept('bench-muscles')['result']['map']['wrist [mm]'][0]:.0f} mm apart"


def _agreement(name: str, one: str, other: str) -> float:
    """Returns Kendall's tau between two reliefs over the policies of an experiment."""
    scores = kept(name)["result"]["scores"]
    found = [score for policy, score in scores.items() if policy not in REFERENCES]
    values = [[RELIEFS[what](score)["value"] for score in found] for what in (one, other)]
    tau: Any = kendalltau(*values)
    return float(tau.statistic)


def _compensation(name: str) -> dict[str, Any]:
    return kept(name)["result"]["scores"]["compensation"]


FACTS: dict[str, Callable[[], Iterator[str]]] = {
    "benchmark.md": _benchmark,
    "model.md": _model,
    "training.md": _training,
    "gpu.md": _gpu,
    "device.md": _device,
    "muscles.md": _muscles,
}
"""Parts of sentences by the page that has them."""
