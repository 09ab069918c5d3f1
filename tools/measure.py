"""Measures what README and docs report: `python -m activesuit.tools.measure [NAME]`.

Each experiment is a command of this package. The means of its results are kept in docs/measured,
from where `tables.py` takes them; so a page never has a number that no command prints. A finished
run is kept, or compared with what is kept, by `--keep NAME FOLDER` and `--check NAME FOLDER`.
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

from .. import __version__
from ..errors import InputError
from ..files import write_text
from ..json_files import read_json

FOLDER = Path(__file__).parent.parent / "docs" / "measured"
FEWEST = 8  # length of the shortest list of one number for each motion, of which the mean is kept
DIGITS = 6  # number of significant digits that are kept
KEPT = {  # fields of a score that pages may report
    *("policy", "effort", "torque", "tracking", "reward", "beginning", "success", "cuff_peak"),
    *("relief", "share_of_bound", "unadapted_effort", "unadapted_tracking", "muscles"),
}
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
    """Returns a result with the mean in place of each list of one number for each motion."""
    if isinstance(value, Mapping):
        is_score = value.keys() >= {"policy", "effort", "torque"}
        kept = {name: one for name, one in value.items() if not is_score or name in KEPT}
        return {name: condensed(one) for name, one in kept.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        numbers = [one for one in value if isinstance(one, Real)]
        if len(value) >= FEWEST and len(numbers) == len(value):
            return _rounded(sum(map(float, numbers)) / len(value))
        return [condensed(one) for one in value]
    return _rounded(value) if isinstance(value, float) else value


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
    given = parser.parse_args()
    if given.keep:
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
