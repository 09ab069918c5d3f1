"""Numbers in sentences that are written by hand: what they must be, from the measured results.

A test looks for each in its page; where it is missing, the result has changed, and the sentence
must follow.
"""

from collections.abc import Callable, Iterator
from itertools import chain, product
from typing import Any

import numpy as np

from ..envs.benchmark.suites import BELIEVED, Setting
from ..envs.evaluation import REFERENCES
from ..envs.policies.trained import shipped_policies
from .learners import BESIDE, LEARNERS, kept_learner
from .measure import kept
from .results import (
    BY_PPO,
    WEIGHTLESS,
    interval,
    percent,
    relief_at,
    scores,
    settings,
    signed,
    standing,
    standings,
)

AIMED = ("ReachPanel", "ObjectRelocation")
LOADED = ("ObjectRelocation", "Ratchet")
REPEATED = ("Ratchet", "Handrail", "Scoop")


def _controllers() -> Iterator[str]:
    earth = scores("earth")
    bare, suited, off = (100 * earth[name]["effort"] for name in (*REFERENCES, "none"))
    yield f"from {bare:.1f} to {suited:.1f} % of strength"
    yield f"motors off adds {off - suited:.1f} points"
    both = [one for place in (earth, scores(WEIGHTLESS)) for one in place.values()]
    apart = max(abs(one["unadapted_effort"] - one["effort"]) for one in both)
    yield f"differ by at most {100 * apart:.1f} points"
    pairs = [
        f"{1e3 * one['unadapted_tracking']:.0f} against {1e3 * one['tracking']:.0f}"
        for one in (earth["suited"], scores(WEIGHTLESS)["none"])
    ]
    yield f"{pairs[0]} mrad in the suit on Earth, {pairs[1]} with the motors off, in microgravity"
    rigid = [one["scores"] for where, one in settings().items() if "rigid" in where]
    errors = [
        1e3 * max(one[name]["tracking"] for one in rigid) for name in ("none", "compensation")
    ]
    yield f"within {errors[0]:.0f} mrad of the intention"
    yield f"one under compensation within {errors[1]:.0f}"
    stiff = kept("cuffs-weightless")["result"]["scores"]
    corrected, usual = stiff["corrected"], stiff["compensation"]
    yield f"relief is {interval(corrected['relief'])} instead of {interval(usual['relief'])}"
    errors = (f"{1e3 * one['tracking']:.0f}" for one in (corrected, usual))
    yield f"the tracking error {' instead of '.join(errors)} mrad"
    found = kept("laws-earth")["result"]["scores"]
    errors = (f"{1e3 * found[name]['tracking']:.1f}" for name in ("impedance", "compensation"))
    yield f"to {' mrad on Earth, where compensation is at '.join(errors)}"


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


def _tasks() -> Iterator[str]:
    failed = [
        f"{100 - _success('ReachPanel', level, 'emu-like', 'best-known-plan'):.0f}"
        for level in standings().levels
    ]
    yield "It fails `ReachPanel` in {}, {} and {} % of the motions".format(*failed)
    beyond = 100 - _success("Hammer", "randomized", "emu-like", "unsuited")
    yield f"are beyond the wearer even unsuited in {beyond:.0f} % of the motions"


def _model() -> Iterator[str]:
    cases = [one for one in kept("sensitivity")["result"]["cases"] if one["change"] != "nominal"]
    turned = sum("observer relieves more than compensation" in one["flipped"] for one in cases)
    yield f"{turned} of {len(cases)} changes turn their order"


def _environments() -> Iterator[str]:
    earth, space = scores("earth"), scores(WEIGHTLESS)
    pairs = {
        name: f"{earth[name]['reward']:.2f}{between}{space[name]['reward']:.2f}"
        for name, between in (("suited", " on Earth and "), ("unsuited", " and "))
    }
    both = f"{earth['compensation']['reward']:.2f} and {space['compensation']['reward']:.2f}"
    yield f"earns {pairs['suited']} in microgravity, the unsuited one {pairs['unsuited']}"
    yield f"compensation {both}"
    rows = {(one["what"], one["against"]): one for one in kept("bench-env")["result"]["rows"]}
    reset = rows["reset of 1024 rows", ""]["ours"]
    yield f"takes {reset:.2f} ms a row"
    yield f"their process {rows['memory of 1024 rows', '']['ours']:.0f} MB"


def _training() -> Iterator[str]:
    result = kept("bench-train")["result"]
    first, *_, forward = result["rows"]
    yield f"{first['ratio']:.1f} times as fast as version 0.1"
    yield f"{first['reference_cpu'] / first['cpu']:.1f} times by processor time"
    share, ratio = result["training"][0]["shares"]["forward passes"], forward["ratio"]
    yield f"take {100 * share:.0f} % of the time, and NumPy does them {ratio:.1f} times as fast"
    yield f"at most {100 * share * (1 - 1 / ratio):.0f} % less time"
    levels = standings().levels
    by_level = [[float(relief_at(name, one)) for name in shipped_policies()] for one in levels]
    usual = (relief_at("compensation", one) for one in levels)
    ranges = (
        f"{min(found):.2f} to {max(found):.2f} where compensation has {compensation}"
        for found, compensation in zip(by_level, usual, strict=True)
    )
    yield ", ".join(f"{found} at {level}" for found, level in zip(ranges, levels, strict=True))


def _learning() -> Iterator[str]:
    beside = kept("learning")["result"]["beside"]
    compensation, adaptive, _ = dict.fromkeys(one["policy"] for one in beside)
    tasks = tuple(dict.fromkeys(one["task"] for one in beside))
    *unloaded, loaded = tasks
    gains = {
        (way, task): _learned(task, way)[-1]["value"] - _learned(task, compensation)[-1]["value"]
        for way, task in product(("residual", "ppo-history"), tasks)
    }
    corrected = (f"{gains['residual', task]:.2f} in `{task}`" for task in unloaded)
    yield f"correction gets {' and '.join(corrected)} more relief than compensation"
    alone, corrected = gains["ppo-history", loaded], gains["residual", loaded]
    yield f"gets {alone:.2f} in `{loaded}` (the correction {corrected:.2f})"
    both = (_succeeded(loaded, name)[-1] for name in (adaptive, "ppo-history"))
    yield "succeeds in {} of the motions, and the network in {}".format(*both)
    pairs = [
        pair
        for task in tasks
        for pair in zip(_learned(task, "ppo"), _learned(task, "ppo-history"), strict=True)
    ]
    usual, longer = (one["value"] for one in pairs[-1])
    yield f"raise its relief from {usual:.2f} to {longer:.2f}"
    better = sum(longer["low"] > usual["high"] for usual, longer in pairs)
    worse = [(usual, longer) for usual, longer in pairs if longer["high"] < usual["low"]]
    yield f"better than one in {better} of {len(pairs)} settings and worse in {len(worse)}"
    usual, longer = worse[0]
    place = f"`{longer['task']}` at `{longer['level']}`"
    yield f"{place} ({longer['value']:.2f} instead of {usual['value']:.2f})"
    for who, text in (
        ("residual", "correction succeeds in {}, {} and {} of the motions at the three levels"),
        ("ppo", "network alone in {}, {} and {}"),
        (compensation, "(compensation: {}, {} and {})"),
    ):
        yield text.format(*_succeeded(loaded, who))
    both = (_succeeded("RangeOfMotion", way)[-1] for way in ("ppo", "residual"))
    yield "network alone succeeds in {}, and the correction in {}".format(*both)


def _learned(task: str, name: str) -> list[dict[str, Any]]:
    """Returns the results of a way of training, or of a policy beside it, at each level."""
    found = [kept(one)["result"] for one in BY_PPO]
    rows = [*found[0]["beside"], *(end for one in found for end in one["ends"])]
    who = ({**one, "name": one.get("way") or one["policy"]} for one in rows)
    return [one for one in who if (one["task"], one["name"]) == (task, name)]


def _succeeded(task: str, name: str) -> list[str]:
    return [percent(one["success"]) for one in _learned(task, name)]


def _learners() -> Iterator[str]:
    for name, learner in LEARNERS.items():
        found = kept_learner(name)["result"]
        versions = (f"{title} {found['versions'][one]}" for one, title in learner.packages.items())
        yield f"(learners/{learner.program}) | {', '.join(versions)} |"
        yield " ".join(f"{n} steps: mean reward {one:.3f}" for n, one in found["rewards"].items())
        yield f"finds a relief of {interval(found['relief'][learner.policy])}"
    found = kept_learner("torch")["result"]
    beside = [signed(found["relief"][name]["value"]) for name in BESIDE]
    yield f"has {beside[0]}; `gravity` has {beside[1]} and `compensation`"
    yield f"which knows the suit, {beside[2]}"
    *seeds, last = (signed(one["my-ppo"]["value"]) for one in found["seeds"].values())
    yield f"it was {', '.join(seeds)} and {last} with the seeds"
    rewards = [f"{one:.2f}" for one in found["noise"].values()]
    yield f"earns {rewards[0]} in a control period with the usual standard deviation of 1, and"
    yield f"and {rewards[1]} with 0.08"


FACTS: dict[str, Callable[[], Iterator[str]]] = {
    "controllers.md": _controllers,
    "benchmark.md": _benchmark,
    "tasks.md": _tasks,
    "model.md": _model,
    "environments.md": _environments,
    "training.md": lambda: chain(_training(), _learning()),
    "learners.md": _learners,
}
"""Parts of sentences by the page that has them."""
