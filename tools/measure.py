"""Measures what README and docs report: `python -m activesuit.tools.measure [NAME]`.

Each experiment is a command of this package. Its results are kept in docs/measured, from where
`tables.py` takes them; so a page never has a number that no command prints. Effort, error, success
and chatter are kept by motion, with the seeds, and of other values the mean. A finished run is
kept, or compared with what is kept, by `--keep NAME FOLDER` and `--check NAME FOLDER`;
`--intervals` computes every interval anew from the kept values by motion.
"""

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..envs.evaluation import BOUNDS, REFERENCES
from ..envs.evaluation.relief import relief_interval
from ..envs.evaluation.statistics import Interval, interval_text, mean_interval, ratio_interval
from ..envs.extras import SCORES
from ..errors import InputError
from ..files import write_text
from ..json_files import read_json

FOLDER = Path(__file__).parent.parent / "docs" / "measured"
FEWEST = 8  # length of the shortest list of one number for each motion, of which the mean is kept
DIGITS = 6  # number of significant digits that are kept
KEPT = {  # fields of a score that pages may report
    *("policy", "effort", "torque", "tracking", "reward", "beginning", "success", "cuff_peak"),
    *(
        "net_effort",
        "relief",
        "net_relief",
        "share_of_bound",
        "unadapted_effort",
        "unadapted_tracking",
        "muscles",
    ),
    *("motion", "distinct", "assisted_effort", "assisted_relief", "chatter"),
}
BY_MOTION = ("motion", "effort", "assisted_effort", "tracking", "success", "chatter")
CONVENTION = "standard"  # convention of muscles whose costs are kept by motion
TOLERANCE = 0.01  # greatest difference from a kept number, relative to it if it is above 1

_LAWS = "compensation impedance observer disturbance-observer"
_MISLED = " ".join(f"{law}:suit=mock-suit" for law in _LAWS.split())
_ALONE = "train --task ArmTracking --gravity microgravity --seeds 0-2 --steps 600000"
_SMALL = "--history 5 --hyperparameters small_exploration.yml"
_OF_MUSCLES = (
    "none transparent gravity feedforward complement compensation adaptive iterative impedance "
    "observer disturbance-observer oracle best-known-plan"
)
MUSCLE_SETTINGS = {
    f"muscles-{suit.partition('-')[0]}-{place}": (suit, place)
    for suit in ("mock-suit", "emu-like")
    for place in ("earth", "moon", "microgravity")
}
TRAININGS = {  # options of trainings, some of which name files in docs/learners
    "alone": "--history 5",
    "small": _SMALL,
    "priced": f"{_SMALL} --reward stiffening:price",
    "residual": "--residual compensation",
}
EXPERIMENTS = {
    "demo": "demo",
    "settings": "bench settings",
    "laws-earth": f"evaluate --motions 8 --policies {_LAWS}",
    "laws-weightless": (
        f"evaluate --motions 8 --suit emu-like --gravity microgravity --policies {_LAWS}"
    ),
    "laws-shift": f"evaluate --motions 8 --level shift --policies {_MISLED}",
    "cuffs-earth": "evaluate --motions 8 --coupling cuffs --policies compensation corrected",
    "cuffs-weightless": (
        "evaluate --motions 8 --coupling cuffs --suit emu-like --gravity microgravity "
        "--policies compensation corrected"
    ),
    "cuffs-shift": (
        "evaluate --motions 8 --coupling cuffs --level shift "
        "--policies compensation:suit=mock-suit corrected:suit=mock-suit"
    ),
    "validate": "validate emu-like mock-suit published-2022 --plant emu-like mock-suit",
    "validate-40kpa": "validate emu-like mock-suit --plant emu-like --pressure 40",
    "sensitivity": "bench sensitivity",
    "bound": "bench bound",
    "hindered": "bench hindered",
    "pushes": "bench pushes",
    **{f"weightless-{name}": f"{_ALONE} {options}".strip() for name, options in TRAININGS.items()},
    "bench-muscles": "bench muscles",
    **{
        name: (
            f"evaluate --score muscles --motions 8 --suit {suit} --gravity {place} --policies "
            f"{_OF_MUSCLES}"
        )
        for name, (suit, place) in MUSCLE_SETTINGS.items()
    },
    "bench-hysteresis": "bench hysteresis",
    "bench-engine": "bench engine",
    "bench-model": "bench model",
    "bench-env": "bench env",
    "bench-train": "bench train",
    "bench-device": "bench device",
    "bench-gpu-h200": "bench gpu --repeats 9",
    "bench-gpu-cpu": "bench gpu --worlds 64 1024 --repeats 49",
}
"""Command lines by the name of their result."""


def kept(name: str) -> dict[str, Any]:
    """Returns the kept result of an experiment.

    Args:
        name: Name of the experiment, one of `EXPERIMENTS`.
    """
    return read_json(FOLDER / f"{name}.json", "kept result")["result"]


def condensed(value: Any) -> Any:
    """Returns a result with the mean in place of each list of one number for each motion.

    Of a score the series `BY_MOTION` stay, and of muscles the costs under the standard convention.
    """
    if isinstance(value, Mapping):
        if value.keys() >= {"policy", "effort", "torque"}:
            value = {**value, "chatter": value.get("costs", {}).get("chatter")}
            series = {name: _each(value[name]) for name in BY_MOTION if value.get(name)}
            kept = {name: value[name] for name in value if name in {*KEPT} - {*BY_MOTION}}
            return {**series, **{name: condensed(one) for name, one in kept.items()}}
        return {
            name: _each(one) if name == CONVENTION and _is_series(one) else condensed(one)
            for name, one in value.items()
        }
    if isinstance(value, Sequence) and not isinstance(value, str):
        if _is_series(value):
            return _rounded(mean(value))
        return [condensed(one) for one in value]
    return _rounded(value) if isinstance(value, float) else value


def _is_series(value: Any) -> bool:
    """Returns whether a value is a list of one number for each motion."""
    listed = isinstance(value, Sequence) and not isinstance(value, str)
    return listed and len(value) >= FEWEST and all(isinstance(one, Real) for one in value)


def _each(values: Sequence[Any]) -> list[Any]:
    return [_rounded(one) if isinstance(one, float) else one for one in values]


def mean(value: Any) -> float:
    """Returns the mean of values by motion, or the kept mean of results of 0.2."""
    return float(np.mean(value))


def intervals(result: Any, place: str = "") -> Iterator[tuple[str, Interval | None, Any]]:
    """Yields each interval of kept scores: its place, computed from values by motion, and as kept.

    Results of 0.2 have means alone, and yield nothing.
    """
    if isinstance(result, Sequence) and not isinstance(result, str):
        for i, one in enumerate(result):
            yield from intervals(one, f"{place}.{i}".lstrip("."))
    if not isinstance(result, Mapping):
        return
    if _has_motions(result):
        for name, one in result.items():
            for what, found in _of_score(result, one).items():
                where, _, last = what.rpartition(".")
                kept = (one[where] if where else one).get(last)
                yield f"{place}.{name}.{what}".lstrip("."), found, kept
        return
    if _has_motions(scores := result.get("scores", {})) and "suit_cost" in result:
        unsuited, suited = (np.array(scores[name]["effort"]) for name in REFERENCES)
        found = mean_interval(suited - unsuited, motion=scores[REFERENCES[0]]["motion"])
        yield f"{place}.suit_cost".lstrip("."), found, result["suit_cost"]
    for name, one in result.items():
        yield from intervals(one, f"{place}.{name}".lstrip("."))


def _has_motions(scores: Any) -> bool:
    """Returns whether these are scores by policy, with references and values by motion."""
    if not isinstance(scores, Mapping) or not scores.keys() >= {*REFERENCES}:
        return False
    return all(
        isinstance(scores[name], Mapping) and "motion" in scores[name] for name in REFERENCES
    )


def _of_score(scores: Mapping[str, Any], one: Mapping[str, Any]) -> dict[str, Interval | None]:
    """Returns the intervals of one score beside the references and the bound."""
    unsuited, suited = (scores[name] for name in REFERENCES)
    motion, bound = unsuited["motion"], scores.get(BOUNDS[1])
    found = {
        what: relief_interval(*(x[of] for x in (unsuited, suited, one)), motion=motion)
        for what, of in (("relief", "effort"), ("assisted_relief", "assisted_effort"))
    }
    found["share_of_bound"] = None
    if bound is not None and found["relief"] is not None:
        over, under = (np.subtract(suited["effort"], x["effort"]) for x in (one, bound))
        found["share_of_bound"] = ratio_interval(over, under, motion=motion)
    for cost, least in (SCORES.find("muscles").least if "muscles" in one else {}).items():
        series = [x["muscles"][cost][CONVENTION] for x in (unsuited, suited, one)]
        found[f"muscles.{cost}_relief"] = relief_interval(*series, least=least, motion=motion)
    return found


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def result_of(folder: Path) -> dict[str, Any]:
    """Returns the condensed results of the folder of a run, by the names of its JSON files."""
    found = {path.stem: condensed(read_json(path, "result")) for path in folder.glob("*.json")}
    if not found:
        raise InputError(f"{folder} has no result: give the folder of a run")
    return dict(sorted(found.items()))


def command_line(name: str) -> str:
    """Returns what a user types to repeat an experiment."""
    program = "python -m activesuit.benchmarks" if is_bench(name) else "activesuit"
    return f"{program} {EXPERIMENTS[name].removeprefix('bench ')}"


def is_bench(name: str) -> bool:
    """Returns whether an experiment is one of `benchmarks`, which are not installed."""
    return EXPERIMENTS[name].startswith("bench ")


def keep(name: str, result: Mapping[str, Any]) -> None:
    """Writes the result of an experiment to `FOLDER`."""
    content = {"command": command_line(name), "version": __version__}
    FOLDER.mkdir(exist_ok=True)
    text = json.dumps({**content, "result": result}, indent=1, ensure_ascii=False)
    write_text(FOLDER / f"{name}.json", f"{text}\n")


def differences(old: Any, new: Any, place: str = "") -> Iterator[str]:
    """Yields a sentence for each number of a result that is not what was kept."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for name in sorted({*old, *new}):
            yield from differences(old.get(name), new.get(name), f"{place}.{name}".lstrip("."))
    elif _is_series(old) and _is_series(new) and len(old) == len(new):
        for i, pair in enumerate(zip(old, new, strict=True)):
            yield from differences(*pair, f"{place}.{i}")
    elif isinstance(old, Real) and isinstance(new, Real):
        if abs(float(old) - float(new)) > TOLERANCE * max(1.0, abs(float(old))):
            yield f"{place} is {new}, and {old} is kept"
    elif type(old) is not type(new):
        yield f"{place} is {new!r}, and {old!r} is kept"


def run(name: str) -> dict[str, Any]:
    """Runs the command of an experiment; returns its condensed result."""
    words = shlex.split(EXPERIMENTS[name])
    module = "activesuit.benchmarks" if is_bench(name) else "activesuit.scripts.main"
    command = [sys.executable, "-m", module, *(words[1:] if is_bench(name) else words)]
    if is_bench(name):
        done = subprocess.run([*command, "--json"], stdout=subprocess.PIPE, check=True)
        return {"result": condensed(json.loads(done.stdout))}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [*command, "--out", f"{folder}/run"],
            stdout=subprocess.DEVNULL,
            check=True,
            cwd=FOLDER.parent / "learners" if words[0] == "train" else None,
        )
        return result_of(Path(folder, "run"))


def main() -> None:
    """Runs the named experiments, all by default, and keeps their results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[*EXPERIMENTS, []], help="experiments to run")
    parser.add_argument("--keep", nargs=2, metavar=("NAME", "FOLDER"), help="keep a finished run")
    parser.add_argument("--check", nargs=2, metavar=("NAME", "FOLDER"), help="compare a run")
    parser.add_argument("--intervals", action="store_true", help="compute all intervals anew")
    given = parser.parse_args()
    if given.intervals:
        for name in given.names or EXPERIMENTS:
            for place, found, _ in intervals(kept(name)):
                print(f"{name}: {place} {interval_text(found)}")
    elif given.keep:
        keep(given.keep[0], result_of(Path(given.keep[1])))
    elif given.check:
        name, folder = given.check
        old, new = kept(name), result_of(Path(folder))
        parts = (one["result"].get("evaluation", one["result"]) for one in (old, new))
        found = list(differences(*parts))  # the fits of a demo vary with its trials
        if found:
            sys.exit(f"{name} is not what docs/measured has: {'; '.join(found[:20])}")
        print(f"{name}: as docs/measured has it")
    else:
        for name in given.names or EXPERIMENTS:
            print(command_line(name), flush=True)
            keep(name, run(name))


if __name__ == "__main__":
    main()
