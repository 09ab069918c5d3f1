"""Golden results: what the package computes must not change while its code is rearranged.

`python tests/golden/golden.py` computes all of them, and says what is not as golden.json has it;
`--write` keeps today's. It ends with code 1 if a number differs by more than rounding. A result is
kept as a hash of its bits and as a few of its numbers.
"""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from activesuit.assets import load_suit
from activesuit.envs.benchmark import BASELINE, run_trial, suite
from activesuit.envs.domain.levels import LEVELS
from activesuit.envs.evaluation import rollout, validate
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.tasks import TASKS
from activesuit.hysteresis import TABLE_2, model_from_dict
from activesuit.identification import Curve, Search, fit_curves
from activesuit.identification.fits.registry import FITS

FILE = Path(__file__).with_name("golden.json")
POLICIES = ("none", "compensation", "adaptive")
ROUNDING = 1e-6  # greatest difference on another processor, relative and absolute
DURATION = 2.0  # [s], of a closed loop
SEARCHES = ("pso", "sa-pso", "mpso", "rank-distance-mpso")
Numbers = Mapping[str, Any]


def kept(numbers: Numbers) -> dict[str, Any]:
    """Returns what is kept of a result: a hash of its bits, and the last number of each series."""
    series = {name: np.ascontiguousarray(value, float) for name, value in numbers.items()}
    bits = sha256(b"".join(one.tobytes() for one in series.values())).hexdigest()[:16]
    return {"bits": bits, **{name: float(one.ravel()[-1]) for name, one in series.items()}}


def walk(low: float, high: float) -> np.ndarray:
    """Returns angles of random reversals between two angles, in short steps."""
    turns = np.random.default_rng(5).uniform(low, high, 12)
    return np.concatenate([np.linspace(a, b, 25)[1:] for a, b in pairwise(turns)])


def responses(models: Mapping[str, Any]) -> Iterator[tuple[str, Callable[[], Numbers]]]:
    for name, one in models.items():
        angle = walk(one["low"], one["high"])
        time = 0.01 * np.arange(angle.size)
        model = model_from_dict(one["model"])
        yield (
            f"response of {name}",
            lambda model=model, angle=angle, time=time: {
                "torque": model.response(angle, time=time)
                if "Viscoelastic" in type(model).__name__
                else model.response(angle)
            },
        )


def record() -> Curve:
    """Returns a small record of an elbow with loops inside, and noise."""
    rng = np.random.default_rng(0)
    turns = [0.5, 1.5, 0.9, 1.3, 0.5, 1.5, 0.5]
    angle = np.concatenate([np.linspace(a, b, 40)[:-1] for a, b in pairwise(turns)])
    torque = TABLE_2["elbow-sa-pso"].response(angle) + 0.02 * rng.standard_normal(angle.size)
    return Curve(angle, torque, "record")


def fits() -> Iterator[tuple[str, Callable[[], Numbers]]]:
    for name in FITS:
        yield f"fit of {name}", lambda name=name: fitted(record(), model=name)
    for name in SEARCHES:
        search = Search(name, trials=1, max_iterations=20)
        yield f"search by {name}", lambda search=search: fitted(record(), method=search)
    yield (
        "fit of magnetics",
        lambda: fitted(magnetization(), method="magnetic", initial_torque="measured"),
    )


def magnetization() -> Curve:
    """Returns a major loop of a magnetization, which lags behind its field."""
    field = np.concatenate([np.linspace(-2, 2, 60)[:-1], np.linspace(2, -2, 60)])
    lag = np.where(np.arange(field.size) < 59, -0.3, 0.3)
    return Curve(field, np.tanh((field + lag) / 0.5), "loop")


def fitted(curve: Curve, **options: Any) -> Numbers:
    fit = fit_curves([curve], workers=1, seed=0, **options)
    return {"torque": fit.model.response(walk(0.5, 1.5))}


def loops() -> Iterator[tuple[str, Callable[[], Numbers]]]:
    for task in TASKS:
        for level in LEVELS:
            for policy in POLICIES:
                yield (
                    f"{task} at {level} with {policy}",
                    lambda task=task, level=level, policy=policy: loop(task, level, policy, 2),
                )
    yield "a vector of 8", lambda: loop("ArmTracking", "randomized", "compensation", 8)


def loop(task: str, level: str, policy: str, rows: int) -> Numbers:
    options = {"task": replace(TASKS[task], duration=DURATION), "level": level}
    arms = make_arms(f"ActiveSuit/{task}-v0", rows, threads=1, **options, **needed_options(policy))
    traces = rollout(arms, make_policy(policy, arms), range(rows))
    arms.close()
    names = ("angle", "human_torque", "suit_torque", "assist_torque", "effort", "rewards")
    return {name: np.concatenate([getattr(one, name) for one in traces]) for name in names}


def row() -> Numbers:
    chosen = suite("quick")
    trial = next(
        one for one in chosen.trials if one.label == BASELINE and one.setting.task == "ElbowFlexion"
    )
    found = run_trial(chosen, trial)
    return {name: getattr(found, name) for name in ("effort", "assisted_effort", "tracking")}


def validated() -> Numbers:
    believed = {"mock-suit": load_suit("mock-suit")}
    task = replace(TASKS["ElbowFlexion"], duration=DURATION)
    options = {"motions": 8, "gravity": "earth", "task": task}
    found = validate("ActiveSuit/ElbowFlexion-v0", believed, ["emu-like"], **options)
    one = found.cells["mock-suit", "emu-like"]
    numbers = {"nrmse": one.torque.together.nrmse, "relief": one.relief, "share": one.share_of_true}
    return {name: [value.value, value.low, value.high] for name, value in numbers.items()}


def results(models: Mapping[str, Any]) -> Iterator[tuple[str, Callable[[], Numbers]]]:
    """Yields each result by name, as a function that computes it."""
    yield from responses(models)
    yield from fits()
    yield from loops()
    yield "a row of the leaderboard", row
    yield "a validation", validated


def examples() -> dict[str, Any]:
    """Returns the models whose response is kept, as plain data."""
    from activesuit.benchmarks.references import EXAMPLES

    every = [one for examples in EXAMPLES.values() for one in examples]
    return {
        one.name: {"model": one.model.to_dict(), "low": one.low, "high": one.high} for one in every
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="keep today's results")
    given = parser.parse_args()
    models = examples() if given.write else json.loads(FILE.read_text())["models"]
    found = {}
    for name, compute in results(models):
        found[name] = kept(compute())
        print(name, found[name]["bits"], flush=True)
    if given.write:
        text = json.dumps({"models": models, "results": found}, indent=1)
        FILE.write_text(f"{text}\n", encoding="utf-8")
        return
    known = json.loads(FILE.read_text())["results"]
    differing = [name for name in {**known, **found} if known.get(name) != found.get(name)]
    for name in differing:
        print(f"{name}: {found.get(name)}, and golden.json has {known.get(name)}")
    print(f"{len(found) - len(differing)} of {len(known)} golden results are equal bit for bit")
    sys.exit(any(apart(known.get(name), found.get(name)) for name in differing))


def apart(one: Numbers | None, other: Numbers | None) -> bool:
    """Returns whether results differ by more than another processor's rounding explains."""
    if one is None or other is None or one.keys() != other.keys():
        return True
    numbers = [[value for name, value in each.items() if name != "bits"] for each in (one, other)]
    return not np.allclose(*numbers, rtol=ROUNDING, atol=ROUNDING)


if __name__ == "__main__":
    main()
