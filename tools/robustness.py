"""Which policies stand suits that they have not met? `python -m activesuit.tools.robustness`.

Each draw of a level has its own motion, suit, person and sensors, and all policies have the same
draws. They believe in the suit mock-suit. Beside the policies stands `fitted-gain`: compensation
with the one factor of the believed suit's torque that gives the least mean effort in other draws,
of the level "randomized". At "beyond" only the draws count in which the best known plan succeeds.

Each trial is a file in the folder `--out`, so that the same command goes on where it was stopped.
The table is printed, and `result.json` has the values of all draws.
"""

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import __version__
from ..arrays import Array
from ..envs.domain.levels import LEVELS as ALL_LEVELS
from ..envs.evaluation import BOUNDS, FIRST_SEED, REFERENCES
from ..envs.evaluation.relief import relief, relief_interval
from ..envs.evaluation.run import run
from ..envs.evaluation.statistics import FEWEST_MOTIONS, Interval, interval_text, ratio_interval
from ..envs.making import make_arms
from ..envs.policies import policy_spec
from ..envs.policies.trained import shipped_policies
from ..errors import InputError
from ..files import write_text
from ..json_files import read_json
from ..tables import markdown_table

TASKS = ("ArmTracking", "ObjectRelocation", "RangeOfMotion")
LEVELS = ("randomized", "unseen", "beyond")
DRAWS, QUICK = 48, 8
FITTING = 40_000  # first seed of the draws on which the gain is fitted
GAINS = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
BIAS = 2.0  # [N·m], constant error of the torque between person and suit
BASELINE, FITTED, BIASED, BEST = "compensation", "fitted-gain", "adaptive-biased", BOUNDS[1]
RULES = ("none", BASELINE, FITTED, "adaptive", BIASED)
POLICIES = (*RULES, *shipped_policies(), BEST)


OF_DRAW = ("suit_spring", "suit_loop", "wearer")  # what result.json has of each draw


class Place(NamedTuple):
    """A task at a level, with the seeds of its draws."""

    task: str
    level: str
    seeds: range


class Trials:
    """Trials of policies, each a file in a folder.

    Args:
        folder: The folder.
        options: Options of all environments, such as {"gravity": "microgravity"}.
    """

    def __init__(self, folder: Path, options: Mapping[str, Any]) -> None:
        self._folder, self._options = folder, dict(options)
        folder.mkdir(parents=True, exist_ok=True)

    def of(self, place: Place, name: str, gain: float = 1.0) -> dict[str, Any]:
        """Returns effort, success and chatter of a policy by draw, from its file if there is one.

        The effort is infinite where the policy cannot act. `gain` is that of `fitted-gain`.
        """
        given, options = self._runnable(name, gain)
        first, last = place.seeds[0], place.seeds[-1]
        label = f"{name}-{gain:g}" if name == FITTED else name
        path = self._folder / f"{place.task}.{place.level}.{first}-{last}.{label}.json"
        conditions = {"version": __version__, "options": {**self._options, **options}}
        conditions["level"] = ALL_LEVELS[place.level]
        if path.is_file():
            kept = read_json(path, "trial")
            if kept["conditions"] != conditions:
                raise InputError(
                    f"{path} is of {kept['conditions']}, and this command has {conditions}: give "
                    "another --out"
                )
            return kept["result"]
        env, every = f"ActiveSuit/{place.task}-v0", {**self._options, **options}
        try:
            score = run(name, given, env, place.seeds, level=place.level, threads=1, **every).score
            found = {
                "effort": [one if math.isfinite(one) else None for one in score.effort],
                "success": list(score.success),
                "chatter": list(score.costs["chatter"]),
            }
        except InputError as error:  # the policy loses arms
            size = len(place.seeds)
            found = {"effort": [None] * size, "success": [False] * size, "chatter": [None] * size}
            found["failed"] = str(error)
        text = json.dumps({"conditions": conditions, "result": found}, indent=1, default=str)
        write_text(path, f"{text}\n")
        return found

    def fitted(self, task: str, draws: int) -> float:
        """Returns the gain of `GAINS` with the least mean effort in draws of training."""
        place = Place(task, LEVELS[0], range(FITTING, FITTING + draws))
        means = [float(np.mean(numbers(self.of(place, FITTED, gain)))) for gain in GAINS]
        return GAINS[int(np.argmin(means))]

    def draws(self, place: Place) -> dict[str, Any]:
        """Returns the factors of the suits, and the numbers of the persons, of all draws."""
        env, rows = f"ActiveSuit/{place.task}-v0", len(place.seeds)
        arms = make_arms(env, rows, level=place.level, **self._options)
        arms.reset(seed=list(place.seeds))
        found = arms.episodes.report()
        found["wearer"] = arms.episodes.simulation.state.conditions.wearer.copy()
        arms.close()
        return {name: found[name].tolist() for name in OF_DRAW}

    def _runnable(self, name: str, gain: float) -> tuple[Any, dict[str, Any]]:
        """Returns a policy for `run`, and the options that it needs beside."""
        if name in (*REFERENCES, BEST):
            return name, {}
        if name == FITTED:
            return policy_spec(f"{BASELINE}:gain={gain}"), {}
        if name == BIASED:
            return policy_spec("adaptive"), {"faults": {"torque_bias": BIAS}}
        return policy_spec(name), {}


def numbers(trial: Mapping[str, Any], what: str = "effort") -> Array:
    """Returns values by draw, shape (draws,); infinite for a failed policy."""
    return np.array([np.inf if one is None else one for one in trial[what]], float)


def compared(trials: Mapping[str, Mapping[str, Any]], level: str) -> dict[str, dict[str, Any]]:
    """Returns the comparison of all policies in one place, by name; the references are among them.

    Each has relief with its interval, by draw, and of the worst quarter of the draws, its paired
    difference to compensation, success, chatter and the number of draws that count.
    """
    effort = {name: numbers(one) for name, one in trials.items()}
    success = {name: np.array(one["success"], bool) for name, one in trials.items()}
    if BEST in effort:  # commands of a policy that succeeds are a known plan, too
        for name, one in effort.items():
            better = success[name] & (one < effort[BEST]) & (name not in REFERENCES)
            effort[BEST] = np.where(better, one, effort[BEST])
            success[BEST] = success[BEST] | better
    counted = np.ones(len(effort[REFERENCES[0]]), bool)
    if level == LEVELS[2] and BEST in effort:
        counted = success[BEST]
    unsuited, suited = (effort[name][counted] for name in REFERENCES)
    found = {}
    for name in (name for name in trials if name not in REFERENCES):
        mine, base = effort[name][counted], effort[BASELINE][counted]
        each = relief(unsuited, suited, mine) if np.isfinite(mine).all() and mine.size else None
        found[name] = {
            "draws": int(counted.sum()),
            "relief": interval(unsuited, suited, mine),
            "difference": difference(suited - unsuited, base, mine),
            "success": float(success[name][counted].mean()) if counted.any() else math.nan,
            "worst_quarter": None if each is None else worst_quarter(each),
            "chatter": float(numbers(trials[name], "chatter")[counted].mean()),
            "each": None if each is None else each.tolist(),
        }
    return found


def interval(unsuited: Array, suited: Array, effort: Array) -> dict[str, float] | None:
    """Returns relief with its interval over draws; None where there is none."""
    if effort.size < FEWEST_MOTIONS or not np.isfinite(effort).all():
        return None
    one = relief_interval(unsuited, suited, effort)
    return None if one is None else one.to_dict()


def difference(cost: Array, base: Array, effort: Array) -> dict[str, float] | None:
    """Returns the paired difference of relief to compensation, with its interval over draws."""
    if effort.size < FEWEST_MOTIONS or not np.isfinite([base, effort]).all():
        return None
    return ratio_interval(base - effort, cost).to_dict()


def worst_quarter(each: Array) -> float:
    """Returns the mean of the smallest quarter of values."""
    return float(np.sort(each)[: max(1, each.size // 4)].mean())


def row(place: Place, name: str, one: Mapping[str, Any], gain: float) -> list[str]:
    """Returns a line of the table."""
    relieved, apart = (
        interval_text(Interval(**one[what]) if one[what] else None)
        for what in ("relief", "difference")
    )
    worst = "-" if one["worst_quarter"] is None else f"{one['worst_quarter']:.2f}"
    shown = f"{name} ({gain:g})" if name == FITTED else name
    start = [place.task, place.level, shown, str(one["draws"]), relieved]
    return [*start, apart, worst, f"{one['success']:.0%}", f"{one['chatter']:.2f}"]


HEADER = ["task", "level", "policy", "draws", "relief", "less compensation", "worst quarter"]
HEADER += ["success", "chatter"]


def measured(
    trials: Trials, places: Sequence[Place], policies: Sequence[str]
) -> tuple[dict[str, Any], list[list[str]]]:
    """Runs the trials that are left; returns the values by task and level, and the table's rows."""
    found: dict[str, Any] = {}
    rows: list[list[str]] = []
    for place in places:
        gain = trials.fitted(place.task, len(place.seeds)) if FITTED in policies else 1.0
        names = (*REFERENCES, *policies)
        here = {name: trials.of(place, name, gain) for name in names}
        scores = compared(here, place.level)
        found.setdefault(place.task, {})[place.level] = {
            **{"seeds": list(place.seeds), "gain": gain, "drawn": trials.draws(place)},
            **{"trials": here, "scores": scores},
        }
        rows += [row(place, name, one, gain) for name, one in scores.items()]
    return found, rows


def main() -> None:
    """Compares policies in drawn suits, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the trials")
    parser.add_argument("--tasks", nargs="+", default=TASKS, choices=TASKS)
    parser.add_argument("--levels", nargs="+", default=LEVELS, choices=LEVELS)
    parser.add_argument(
        "--policies", nargs="+", default=POLICIES, help=f"of {POLICIES}, or folders"
    )
    parser.add_argument("--draws", type=int, default=DRAWS, help="number of draws, at least 8")
    parser.add_argument("--gravity", help="place; by default that of the task")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} draws of rules in one task")
    given = parser.parse_args()
    tasks, draws, policies = given.tasks, given.draws, tuple(given.policies)
    if given.quick:
        tasks, draws, policies = TASKS[:1], QUICK, RULES
    if BASELINE not in policies:
        parser.error(f"--policies lacks {BASELINE}, with which all others are compared: add it")
    if draws < FEWEST_MOTIONS:
        parser.error(f"--draws is {draws}: give at least {FEWEST_MOTIONS}, for an interval")
    trials = Trials(given.out, {"gravity": given.gravity} if given.gravity else {})
    seeds = range(FIRST_SEED, FIRST_SEED + draws)
    places = [Place(task, level, seeds) for task in tasks for level in given.levels]
    found, rows = measured(trials, places, policies)
    content = {"version": __version__, "gravity": given.gravity, "result": found}
    write_text(given.out / "result.json", f"{json.dumps(content, indent=1)}\n")
    print(markdown_table(HEADER, rows))


if __name__ == "__main__":
    main()
