"""Damaged inputs, drawn at random: each is one sentence, and nothing changes on disk.

    python tests/damage.py --count 1000 --seed 0

A kind of damage mutates one file that a command reads, one option that the parser of a command
knows, or the place of the results; all else is whole. The command runs in this process.
Damage that is refused must end with exit code 2, one sentence on stderr and no other change on
disk; damage that is harmless must end with success; some may do either.
"""

import argparse
import contextlib
import functools
import importlib.util
import io
import json
import os
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import activesuit.scripts  # first: it chooses how MuJoCo draws without a display
import numpy as np
import tyro
from activesuit.assets import JOINTS, curves_path, load_suit
from activesuit.envs.policies.network import files_of, read_card, read_network
from activesuit.scripts.commands import function_of
from activesuit.scripts.main import main as activesuit
from activesuit.scripts.options import with_flags
from trained_runs import make_run

PREFIX, LONGEST = "activesuit: error: ", 300  # of a sentence; characters after the prefix
SECONDS = 5.0  # of computing, after which a command has accepted its input
CODES = {"refused": {2}, "harmless": {0, 3}, "either": {0, 2, 3}}  # 3: no model describes the data

Rng = np.random.Generator
Mutation = Callable[[bytes, Rng], bytes | None]  # of a file; None removes it
Outcomes = dict[str, dict[str, Mutation]]  # mutations by outcome and name
Damage = Callable[[Path, Rng], list[str]]  # of a folder of inputs; returns the arguments


def one_of(rng: Rng, choices: Any) -> Any:
    return choices[rng.integers(len(choices))]


# --- Files --------------------------------------------------------------------------------------

HUGE, LONG, DEEP = "9" * 5000, "x" * 5000, "[" * 10_000 + "]" * 10_000
FOLDER = b"in place of the file"


def flipped(old: bytes, rng: Rng) -> bytes:
    new = np.frombuffer(old, np.uint8).copy()
    new[rng.integers(len(new), size=rng.integers(1, 6))] = rng.integers(256)
    return new.tobytes()


FILE: dict[str, Mutation] = {
    "missing": lambda old, rng: None,
    "folder": lambda old, rng: FOLDER,
    "empty": lambda old, rng: b"",
    "binary": lambda old, rng: rng.bytes(2000),
    "NUL": lambda old, rng: bytes(int(rng.integers(1, 9999))),
    "another file": lambda old, rng: b"PK\x03\x04 nothing",
}
CUT: Mutation = lambda old, rng: old[: rng.integers(1, len(old) - 2)]  # noqa: E731
SAME_TEXT: dict[str, Mutation] = {
    "byte order mark": lambda old, rng: b"\xef\xbb\xbf" + old,
    "CRLF": lambda old, rng: old.replace(b"\n", b"\r\n"),
}
BINARY: Outcomes = {"refused": {**FILE, "cut": CUT}, "either": {"bytes replaced": flipped}}

# --- Tables -------------------------------------------------------------------------------------

CELLS = ("", "x", "nan", "inf", "-inf", "1e400", HUGE, "1,5", "--1", "0x10", "\x1b[2J", '"1')
FACTORS = (0.0, 1e-300, 180 / np.pi, 1e6, 1e300)  # of which an arm allows few


def rows(change: Callable[[list[list[str]], Rng], Any]) -> Mutation:
    """Returns a mutation of the rows of a table, the first of which is the header."""

    def mutation(old: bytes, rng: Rng) -> bytes:
        table = [line.split(",") for line in old.decode().splitlines()]
        return "".join(",".join(row) + "\n" for row in change(table, rng) or table).encode()

    return mutation


def cell(table: list[list[str]], rng: Rng) -> None:
    one_of(rng, table[1:])[rng.integers(len(table[0]))] = one_of(rng, CELLS)


def scaled(table: list[list[str]], rng: Rng) -> None:
    i, factor = rng.integers(len(table[0])), one_of(rng, FACTORS)
    for row in table[1:]:
        row[i] = repr(float(row[i]) * factor) if row[i][-1].isdigit() else row[i]


TABLE: Outcomes = {
    "refused": {
        **FILE,
        "cell": rows(cell),
        "cell too many": rows(lambda table, rng: [*table, [*table[-1], "1"]]),
        "cell too few": rows(lambda table, rng: [*table, table[-1][1:]]),
        "huge cell": rows(lambda table, rng: [*table, ["x" * 200_000, *table[-1][1:]]]),
        "header only": rows(lambda table, rng: table[:1]),
        "one sample": rows(lambda table, rng: table[:2]),
        "no header": rows(lambda table, rng: table[1:]),
        "column twice": rows(lambda table, rng: [[table[0][-1], *table[0][1:]], *table[1:]]),
        "row twice": rows(lambda table, rng: [*table, one_of(rng, table)]),
    },
    "either": {
        "cut": CUT,
        "bytes replaced": flipped,
        "scaled": rows(scaled),
        "header": rows(lambda table, rng: [[one_of(rng, CELLS), *table[0][1:]], *table[1:]]),
        "column gone": rows(
            lambda table, rng: np.delete(table, rng.integers(len(table[0])), 1).tolist()
        ),
        "rows gone": rows(lambda table, rng: [row for row in table if rng.random() < 0.8]),
        "shuffled": rows(lambda table, rng: rng.permutation(table).tolist()),
    },
    "harmless": {
        **SAME_TEXT,
        "UTF-16": lambda old, rng: old.decode().encode("utf-16"),
        "spaces": lambda old, rng: old.replace(b",", b" , "),
        "semicolons": lambda old, rng: old.replace(b",", b";"),
        "comments": lambda old, rng: b"# \x1b[31m\n\n" + old.replace(b"\n", b"\n\n#\n", 3) + b"\n",
    },
}

# --- JSON ---------------------------------------------------------------------------------------

NUMBER = ("-1", "0", "1e308", "1e-320")
LITERALS: dict[type, tuple[str, ...]] = {
    bool: ("true",),
    int: NUMBER,
    float: NUMBER,
    str: ('"x"', '""', '"\\u001b[31m"', f'"{LONG}"'),
    list: ("[]", "[1]", "[{}]"),
    dict: ("{}", '{"a": 1}', f'{{"{LONG}": 1}}'),
}
NO_NUMBERS = ("NaN", "Infinity", "-Infinity", "1e400", "9" * 350, HUGE)


def places(inner: Any) -> Iterator[tuple[Any, Any]]:
    """Yields every place of a document: a list or an object, and an index or a key of it."""
    for key in [*inner] if isinstance(inner, dict) else range(len(inner)):
        yield inner, key
        if isinstance(inner[key], dict | list):
            yield from places(inner[key])


def literal(choose: Callable[[Any], tuple[str, ...] | list[str]]) -> Mutation:
    """Returns a mutation of one value, which becomes one of the literals chosen for it."""

    def mutation(old: bytes, rng: Rng) -> bytes:
        root = [json.loads(old)]
        inner, key = one_of(rng, [(one, key) for one, key in places(root) if choose(one[key])])
        new, inner[key] = one_of(rng, choose(inner[key])), "\0"
        return json.dumps(root[0]).replace(json.dumps("\0"), new).encode()

    return mutation


def another_type(value: Any) -> list[str]:
    own = LITERALS.get(type(value))  # null may become anything
    return [one for kind in LITERALS.values() if own not in (None, kind) for one in kind]


def with_key(value: Any, name: str = "") -> list[str]:
    text = json.dumps(value) if isinstance(value, dict) else ""
    return [text.replace("{", f'{{"{name or key}": 1, ', 1) for key in value] if text else []


def without_key(value: Any) -> list[str]:
    keys = value if isinstance(value, dict) else ()
    return [json.dumps({key: value[key] for key in keys if key != gone}) for gone in keys]


JSON: Outcomes = {
    "refused": {
        **FILE,
        "cut": CUT,
        "UTF-16": lambda old, rng: old.decode().encode("utf-16"),
        "another type": literal(another_type),
        "no number": literal(lambda one: NO_NUMBERS if LITERALS.get(type(one)) is NUMBER else ()),
        "deep": literal(lambda value: (DEEP,)),
        "unknown key": literal(functools.partial(with_key, name="colour")),
        "key twice": literal(with_key),
    },
    "either": {
        "bytes replaced": flipped,
        "key gone": literal(without_key),
        "any value": literal(
            lambda value: ["null", *(x for one in LITERALS.values() for x in one)]
        ),
    },
    "harmless": SAME_TEXT,
}
FREE = ("another type", "no number", "unknown key")  # records that only --resume reads hold any
CARD: Outcomes = {
    "refused": {name: one for name, one in JSON["refused"].items() if name not in FREE},
    "either": {**JSON["either"], **{name: JSON["refused"][name] for name in FREE}},
    "harmless": SAME_TEXT,
}

# --- Files and the commands that read them ------------------------------------------------------

ACTING = (
    "export run --onnx --out new.onnx",
    "simulate --policy run --out out",
    "evaluate --policies run --unadapted --motions 8 --out out",
)
FILES: dict[str, tuple[Outcomes, tuple[str, ...]]] = {  # the first command is fast
    "elbow.csv": (TABLE, (
        "identify elbow.csv --model prandtl-ishlinskii",
        "identify elbow.csv --out out --workers 1",
        "design elbow.csv --out new.csv",
        "validate whole.json --held-out elbow.csv --joint elbow_flexion --out out",
    )),
    "motion.csv": (TABLE, (
        "rig --motion motion.csv --out out",
        "identify whole.csv --for motion.csv --model prandtl-ishlinskii",
    )),
    "arm.csv": (TABLE, ("simulate --task arm.csv --out out", "evaluate --task arm.csv")),
    "suit.json": (JSON, (
        "list suits suit.json",
        "rig --suit suit.json --out out",
        "simulate --suit suit.json --out out",
        "evaluate --suit suit.json --policies none --out out",
        "validate suit.json --out out",
        "view --suit suit.json --snapshot new.png",
        "identify whole.csv --joint elbow_flexion --base suit.json --out out --workers 1",
        "train --suit suit.json --out out",
        "export suit.json --c --out new.h",
    )),
    "policy.json": (JSON, (
        "export policy.json --c --out new.h", "simulate --policy policy.json --out out"
    )),
    "run/policy.json": (CARD, ACTING),
    "run/policy.safetensors": (BINARY, ACTING),
    "run/model.zip": (BINARY, ("train --resume --trust --steps 64 --out run",)),
}  # fmt: skip


def file_damage(name: str, mutation: Mutation, commands: tuple[str, ...]) -> Damage:
    def damage(folder: Path, rng: Rng) -> list[str]:
        path = folder / name
        new = mutation(path.read_bytes(), rng)
        path.unlink()
        if new is FOLDER:
            path.mkdir()
        elif new is not None:
            path.write_bytes(new)
        return one_of(rng, commands).split()

    return damage


def not_finite(folder: Path, rng: Rng) -> list[str]:
    """Makes a weight of the network not finite."""
    run = folder / "run"
    network = read_network(run, card := read_card(run))
    weights = one_of(rng, [*network.weights.values()])
    weights.flat[rng.integers(weights.size)] = one_of(rng, (np.nan, np.inf))
    for name, new in files_of(card, network).items():
        (run / name).write_bytes(new)
    return one_of(rng, ACTING).split()


# --- Options ------------------------------------------------------------------------------------

JUNK: dict[str, tuple[list[str], list[str]]] = {  # by kind: what is refused, and what may be
    "INT": (["", "x", "1.5", "nan", "-99", HUGE, "1e3", "\x1b[31m1"], ["-1", "0", "9" * 15]),
    "FLOAT": (["", "x", "nan", "inf", "1e400", HUGE, "1,5", "0x1p3"], ["-1e9", "0", "1e-300"]),
    "PATH": (["", LONG, "a\0b", "whole.csv/a"], ["nosuch", "run"]),
    "": (["", "nosuch", LONG, "\x1b[31m", "a\nb", "ä\u202eb", "../../etc", "a\0b"], ["none"]),
}
WHOLE = {  # command lines that are whole; the last word is the place of the results
    "demo": "--out out",
    "identify": "whole.csv --workers 1 --out out",
    "design": "whole.csv --out new.csv",
    "rig": "--out out",
    "simulate": "--out out",
    "view": "--snapshot new.png",
    "evaluate": "--out out",
    "validate": "whole.json --out out",
    "train": "--out out",
    "export": "whole.json --c --out new.h",
    "benchmark": "run --workers 1 --out out",
}
LINES = """nosuch; identfy whole.csv; --nosuch; identify; validate; simulate extra;
    identify whole.csv --base mock-suit; identify whole.csv --method mpso --model preisach;
    identify whole.csv --method auto --trials 3; simulate --out out --suit none --pressure 30;
    list fly; list suits nosuch; view --film new.txt;
    view --film n.gif --snapshot n.png; view --snapshot new.jpg; train --coupling none --out out;
    export compensation --onnx --out new.onnx; export adaptive --c --out new.h"""


@functools.cache
def options(command: str) -> list[argparse.Action]:
    """Returns the options and positional arguments that the parser of a command knows."""
    without, config = with_flags(function_of(command)), (tyro.conf.FlagCreatePairsOff,)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # tyro has no other way to ask
        parser = tyro.extras.get_parser(without, config=config)
    return [one for one in parser._actions if one.dest != "help"]


def value(folder: Path, rng: Rng, command: str, refused: bool) -> list[str]:
    """Gives junk to an option, or in place of the first argument."""
    option, given = one_of(rng, options(command)), WHOLE[command].split()
    kind = next(kind for kind in JUNK if kind in str(option.metavar))
    junk = [one_of(rng, JUNK[kind][not refused])] * (2 if option.nargs == 2 else 1)
    if option.option_strings:
        return [*command.split(), *given, option.option_strings[0], *junk]
    return [*command.split(), *junk, *given[1:]]


def unknown(folder: Path, rng: Rng, command: str) -> list[str]:
    """Adds an unknown option, or a known one without its value."""
    known = [one.option_strings for one in options(command) if one.nargs in (1, 2)]
    name = one_of(rng, ["--nosuch", *(names[0] for names in known if names)])
    return [*command.split(), *WHOLE[command].split(), name]


def taken(folder: Path, rng: Rng, command: str) -> list[str]:
    """Puts something else where the results should go."""
    arguments = [*command.split(), *WHOLE[command].split()]
    place, what = folder / arguments[-1], rng.integers(3)
    if what == 0:
        place.write_text("a file")
    elif what == 1:
        place.mkdir()
        (place / "thesis.txt").write_text("mine")
    else:
        place.symlink_to(one_of(rng, ["whole.csv", "nosuch", "."]))
    return arguments


def kinds(trained: bool) -> dict[str, tuple[Damage, str]]:
    """Returns all kinds of damage, each with its outcome."""
    found: dict[str, tuple[Damage, str]] = {
        "command line": (lambda folder, rng: one_of(rng, LINES.split(";")).split(), "refused"),
        "run/policy.safetensors: not finite": (not_finite, "refused"),
    }
    for name, (outcomes, commands) in FILES.items():
        for outcome, mutations in outcomes.items():
            for kind, mutation in mutations.items():
                readers = commands[:1] if outcome == "harmless" else commands
                found[f"{name}: {kind}"] = (file_damage(name, mutation, readers), outcome)
    for name in WHOLE:
        one = functools.partial
        found[f"{name}: value"] = (one(value, command=name, refused=True), "refused")
        found[f"{name}: strange value"] = (one(value, command=name, refused=False), "either")
        found[f"{name}: option"] = (one(unknown, command=name), "refused")
        found[f"{name}: place taken"] = (one(taken, command=name), "refused")
    return {name: kind for name, kind in found.items() if trained or "run/" not in name}


# --- Running ------------------------------------------------------------------------------------


def make_inputs(folder: Path, *, trained: bool) -> None:
    """Makes a folder of whole inputs."""
    elbow = ["curve,role,angle_rad,torque_nm,time_s,weight"]
    lines = [line for line in curves_path("elbow").read_text().splitlines() if line[0].isdigit()]
    elbow += [f"{line},{i},1" for i, line in enumerate(lines[::40])]
    arm = [",".join(["time", *JOINTS]), *(f"{0.1 * i:.1f},0,0.5,0.6,0" for i in range(12))]
    motion = ["time_s,angle_rad", "0,0.52", "2,1.1", "4,0.7", "6,0.9"]
    tables = {"elbow.csv": elbow, "whole.csv": elbow, "arm.csv": arm, "motion.csv": motion}
    for name, table in tables.items():
        (folder / name).write_text("\n".join(table) + "\n")
    for name in ("suit.json", "whole.json"):
        load_suit("mock-suit").save(folder / name)
    policy = {"name": "compensation", "suit": "mock-suit", "lead": 0.03}
    (folder / "policy.json").write_text(json.dumps(policy))
    if trained:
        make_run(folder / "run")


class AcceptedError(BaseException):
    """The command has computed for so long that it must have accepted its input."""


def accept(*given: object) -> None:
    raise AcceptedError


def call(folder: Path, arguments: list[str]) -> tuple[int, str]:
    """Runs a command in this process and a folder; returns its exit code and stderr."""
    err = io.StringIO()
    signal.signal(signal.SIGPROF, accept)
    with (
        contextlib.chdir(folder),
        patch.dict(os.environ, XDG_STATE_HOME=str(folder / ".state")),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(err),
    ):
        try:
            signal.setitimer(signal.ITIMER_PROF, SECONDS, 1.0)
            activesuit(arguments)
        except SystemExit as end:
            return end.code if isinstance(end.code, int) else 1, err.getvalue()
        except AcceptedError:
            return 0, err.getvalue()
        except BaseException:
            return 1, traceback.format_exc()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
    return 0, err.getvalue()


def disk(folder: Path) -> set[tuple[Path, int, object]]:
    """Returns path, mode and content of everything in a folder."""
    found = set()
    for path in folder.rglob("*"):
        link = path.is_symlink()
        content = path.readlink() if link else path.is_file() and path.read_bytes()
        found.add((path, path.lstat().st_mode, content))
    return found


def problem(folder: Path, arguments: list[str], outcome: str) -> str:
    """Runs a command; returns what was wrong."""
    before = disk(folder)
    code, text = call(folder, arguments)
    if code not in CODES[outcome]:
        return f"exit code {code} of what is {outcome}: {text[-600:]}"
    if code != 2:
        return ""
    lines = [line for line in text.splitlines() if line.strip()]
    if len(lines) != 1 or not lines[0].startswith(PREFIX):
        return f"stderr is no single sentence: {text[:600]!r}"
    if len(lines[0]) > len(PREFIX) + LONGEST or not lines[0].isprintable():
        return f"the sentence is too long or does not print: {lines[0]!r}"
    changed = sorted({path.name for path, *_ in before ^ disk(folder)})
    return f"changed on disk: {changed}" if changed else ""


def attack(count: int | None, seed: int, report: Callable[[str], object]) -> Counter[str]:
    """Does `count` damages, or one of each kind; reports what was wrong."""
    trained = importlib.util.find_spec("stable_baselines3") is not None
    known, rng = kinds(trained), np.random.default_rng(seed)
    drawn = [*rng.permutation([*known]), *rng.choice([*known], count or 0)][: count or len(known)]
    with tempfile.TemporaryDirectory() as place:
        whole, folder = Path(place) / "whole", Path(place) / "case"
        whole.mkdir()
        make_inputs(whole, trained=trained)
        for i, kind in enumerate(drawn):
            shutil.copytree(whole, folder)
            damage, outcome = known[kind]
            arguments = damage(folder, np.random.default_rng([seed, i]))
            if wrong := problem(folder, arguments, outcome):
                report(f"{kind}, case {i}: {[one[:60] for one in arguments]}\n    {wrong}")
            shutil.rmtree(folder)
    return Counter(drawn)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Commands on damaged inputs.")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    begin, wrong = time.perf_counter(), []
    done = attack(given.count, given.seed, wrong.append)
    print("\n".join(wrong))
    spent = time.perf_counter() - begin
    print(f"{done.total()} damages of {len(done)} kinds, {len(wrong)} wrong, {spent:.0f} s")
    sys.exit(bool(wrong))
