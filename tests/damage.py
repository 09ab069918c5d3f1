"""Damaged inputs, drawn at random: each is one sentence, and nothing changes on disk.

    python tests/damage.py --count 1000 --seed 0

A kind of damage spoils one input of a command that is whole otherwise: a curve file, a suit file,
the folder of a trained run, or an option. The command runs in this process. Damage
that is refused must end with exit code 2, one sentence on stderr and no other change on disk;
damage that is harmless (`HARMLESS`) must end with success; some may do either (`EITHER`).
"""

import argparse
import contextlib
import dataclasses
import hashlib
import io
import json
import os
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

PREFIX = "activesuit: error: "
LONGEST = 300  # characters after the prefix
JUNK = {
    "int": ["", "x", "1.5", "nan", "-99", "9" * 5000, "1e3", "\x1b[31m1", "one"],
    "float": ["", "x", "nan", "inf", "1e400", "-1e9", "9" * 5000, "1,5", "0x1p3"],
    "name": ["", "nosuch", "x" * 3000, "\x1b[31mred", "a\nb", "ä\u202eb", "../../etc", "a\0b"],
}
DEEP = "[" * 10_000 + "]" * 10_000
HUGE = "9" * 5000

Rng = np.random.Generator
Damage = Callable[[Path, Rng], list[str]]  # spoils a folder of inputs, returns the arguments


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of damage; `outcome` is "refused", "harmless" or "either"."""

    name: str
    damage: Damage
    outcome: str = "refused"

    @property
    def family(self) -> str:
        """Returns what it damages."""
        return self.name.split(":")[0]


# --- The inputs when they are whole -------------------------------------------------------------


def curve_lines() -> list[str]:
    """Returns the lines of a small curve file."""
    from activesuit.hysteresis import TABLE_2

    lines = ["curve,role,angle_rad,torque_nm"]
    for turn, role in ((0.9, "fit"), (1.2, "fit"), (1.05, "predict")):
        angle = np.concatenate([np.linspace(0.52, turn, 8), np.linspace(turn, 0.52, 8)[1:]])
        torque = TABLE_2["elbow-sa-pso"].response(angle)
        lines += [f"{turn},{role},{x:.6f},{y:.6f}" for x, y in zip(angle, torque, strict=True)]
    return lines


def make_inputs(folder: Path, *, trained: bool) -> None:
    """Makes a folder of whole inputs: elbow.csv, suit.json and run/."""
    from activesuit.assets import load_suit

    (folder / "elbow.csv").write_text("\n".join(curve_lines()) + "\n")
    (folder / "motion.csv").write_text("time_s,angle_rad\n0,0.52\n2,1.1\n4,0.7\n6,0.9\n")
    load_suit("mock-suit").save(folder / "suit.json")
    shutil.copy(folder / "suit.json", folder / "whole.json")
    shutil.copy(folder / "elbow.csv", folder / "whole.csv")
    if trained:
        from trained_runs import make_run

        make_run(folder / "run")


# --- Curve files ----------------------------------------------------------------------------


def curves(change: Callable[[list[str], Rng], str | bytes]) -> Damage:
    """Returns damage that rewrites the curve file from its lines."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        path = folder / "elbow.csv"
        content = change(path.read_text().splitlines(), rng)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return ["identify", "elbow.csv", "--out", "out", *_some(rng, ["--model", "preisach"])]

    return damage


def kept(change: Callable[[list[str], Rng], str | bytes]) -> Damage:
    """Returns harmless damage of a curve file, with a command that is fast where it succeeds."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        curves(change)(folder, rng)
        return ["identify", "elbow.csv", "--model", "prandtl-ishlinskii"]

    return damage


def cell(column: int, *values: str) -> Damage:
    """Returns damage that puts one of some values into a random row of a column."""

    def change(lines: list[str], rng: Rng) -> str:
        i = int(rng.integers(1, len(lines)))
        cells = lines[i].split(",")
        cells[column] = values[rng.integers(len(values))]
        return joined([*lines[:i], ",".join(cells), *lines[i + 1 :]])

    return curves(change)


def column(number: int, value: Callable[[float], float]) -> Damage:
    """Returns damage that changes a whole column of numbers."""

    def change(lines: list[str], rng: Rng) -> str:
        del rng
        rows = [line.split(",") for line in lines]
        for row in rows[1:]:
            row[number] = repr(value(float(row[number])))
        return joined([",".join(row) for row in rows])

    return curves(change)


def header(*columns: str) -> Damage:
    """Returns damage that replaces the header."""
    return curves(lambda lines, rng: joined([columns[rng.integers(len(columns))], *lines[1:]]))


def joined(lines: Sequence[str]) -> str:
    """Returns lines as a text."""
    return "\n".join(lines) + "\n"


def truncated(text: str, rng: Rng) -> str:
    """Returns the beginning of a text."""
    return text[: int(rng.integers(1, len(text) - 2))]


def flipped(text: str, rng: Rng) -> bytes:
    """Returns the bytes of a text, some of them replaced."""
    content = bytearray(text.encode())
    for i in rng.integers(len(content), size=int(rng.integers(1, 6))):
        content[i] = rng.integers(256)
    return bytes(content)


def without_a_line(lines: list[str], rng: Rng) -> str:
    """Returns a text without some of its lines."""
    gone = set(rng.integers(len(lines), size=int(rng.integers(1, 10))).tolist())
    return joined([line for i, line in enumerate(lines) if i not in gone])


CURVES = [
    Kind("curves: empty", curves(lambda lines, rng: "")),
    Kind("curves: header only", curves(lambda lines, rng: joined(lines[:1]))),
    Kind("curves: no header", curves(lambda lines, rng: joined(lines[1:]))),
    Kind(
        "curves: columns", header("curve,role,angle,torque_nm", "a,b,c,d", "curve,role,torque_nm,x")
    ),
    Kind("curves: column twice", header("curve,curve,angle_rad,torque_nm")),
    Kind("curves: both angles", header("curve,angle_deg,angle_rad,torque_nm")),
    Kind("curves: text for a number", cell(3, "x", "", "1,5", "--1", "1e", "0x10", "\x1b[2J")),
    Kind("curves: not finite", cell(3, "nan", "inf", "-inf", "1e999", HUGE)),
    Kind("curves: angle not finite", cell(2, "nan", "inf", "1e999", "", "x")),
    Kind("curves: huge torque", cell(3, "1e9", "-1e300", "1e308")),
    Kind("curves: degrees as radians", column(2, np.degrees)),
    Kind("curves: tiny torques", column(3, lambda value: value * 1e-300)),
    Kind("curves: zero torques", column(3, lambda value: 0.0)),
    Kind("curves: no motion", column(2, lambda value: 0.52)),
    Kind("curves: unknown role", cell(1, "test", "", "FIT", "x" * 2000)),
    Kind(
        "curves: nothing to fit",
        curves(lambda lines, rng: joined(lines).replace(",fit", ",predict")),
    ),
    Kind("curves: no name", cell(0, "", "  ")),
    Kind("curves: strange name", cell(0, "\x1b[31mred", "x" * 3000, "a\tb")),
    Kind("curves: few samples", curves(lambda lines, rng: joined(lines[:4]))),
    Kind("curves: ragged row", curves(lambda lines, rng: joined([*lines, "0.9,fit,1.0"]))),
    Kind("curves: open quote", curves(lambda lines, rng: joined([*lines, '"0.9,fit,1.0,2.0']))),
    Kind(
        "curves: huge cell", curves(lambda lines, rng: joined([*lines, "x" * 200_000 + ",fit,1,2"]))
    ),
    Kind("curves: binary", curves(lambda lines, rng: rng.bytes(2000))),
    Kind("curves: zero bytes", curves(lambda lines, rng: joined(lines).replace("0.52", "0\0", 1))),
    Kind(
        "curves: weight",
        curves(
            lambda lines, rng: joined(
                [
                    lines[0] + ",weight",
                    *(f"{line},{('-1', 'nan', 'x', '0')[rng.integers(4)]}" for line in lines[1:]),
                ]
            )
        ),
    ),
    Kind(
        "curves: time",
        curves(
            lambda lines, rng: joined(
                [
                    lines[0] + ",time_s",
                    *(f"{line},{('-1', 'nan', 'x', '0')[rng.integers(4)]}" for line in lines[1:]),
                ]
            )
        ),
    ),
    Kind("curves: byte order mark", kept(lambda lines, rng: "\ufeff" + joined(lines)), "harmless"),
    Kind("curves: CRLF", kept(lambda lines, rng: joined(lines).replace("\n", "\r\n")), "harmless"),
    Kind("curves: spaces", kept(lambda lines, rng: joined(lines).replace(",", " , ")), "harmless"),
    Kind(
        "curves: comments",
        kept(lambda lines, rng: joined(["# \x1b[31m", "", *lines, "#", ""])),
        "harmless",
    ),
    Kind("curves: truncated", kept(lambda lines, rng: truncated(joined(lines), rng)), "either"),
    Kind("curves: lines lost", kept(without_a_line), "either"),
    Kind("curves: bytes replaced", kept(lambda lines, rng: flipped(joined(lines), rng)), "either"),
    Kind(
        "curves: shuffled",
        kept(lambda lines, rng: joined([lines[0], *rng.permutation(lines[1:]).tolist()])),
        "either",
    ),
]


# --- Motion files ---------------------------------------------------------------------------


def motion(change: Callable[[list[str], Rng], str | bytes]) -> Damage:
    """Returns damage that rewrites the motion file from its lines."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        path = folder / "motion.csv"
        write(path, change(path.read_text().splitlines(), rng))
        if rng.random() < 0.5:
            return ["measure", "rig", "--motion", "motion.csv", "--out", "out"]
        return ["identify", "whole.csv", "--for", "motion.csv", "--model", "prandtl-ishlinskii"]

    return damage


def _cell(*values: str) -> Damage:
    def change(lines: list[str], rng: Rng) -> str:
        i, j = int(rng.integers(1, len(lines))), int(rng.integers(2))
        cells = lines[i].split(",")
        cells[j] = values[rng.integers(len(values))]
        return joined([*lines[:i], ",".join(cells), *lines[i + 1 :]])

    return motion(change)


MOTIONS = [
    Kind("motion: empty", motion(lambda lines, rng: "")),
    Kind("motion: header only", motion(lambda lines, rng: joined(lines[:1]))),
    Kind("motion: columns", motion(lambda lines, rng: joined(["time,angle", *lines[1:]]))),
    Kind("motion: text for a number", _cell("x", "", "1,5", "--1", "\x1b[2J", HUGE)),
    Kind("motion: not finite", _cell("nan", "inf", "-inf", "1e999")),
    Kind("motion: time runs back", motion(lambda lines, rng: joined([*lines, lines[1]]))),
    Kind("motion: ragged row", motion(lambda lines, rng: joined([*lines, "9999"]))),
    Kind("motion: binary", motion(lambda lines, rng: rng.bytes(2000))),
    Kind(
        "motion: bytes replaced", motion(lambda lines, rng: flipped(joined(lines), rng)), "either"
    ),
    Kind("motion: truncated", motion(lambda lines, rng: truncated(joined(lines), rng)), "either"),
]


# --- JSON files -----------------------------------------------------------------------------


def _deep(text: str, rng: Rng) -> str:
    return DEEP if rng.random() < 0.5 else text.replace("{", '{"x": ' + DEEP + ", ", 1)


def _twice(text: str, rng: Rng) -> str:
    name = next(iter(json.loads(text)))
    return text.replace("{", f'{{"{name}": 1, ', 1)


BROKEN: dict[str, Callable[[str, Rng], str | bytes]] = {
    "empty": lambda text, rng: "",
    "truncated": truncated,
    "a list": lambda text, rng: f"[{text}]",
    "a number": lambda text, rng: ("3", "null", '"x"', "true", "NaN")[rng.integers(5)],
    "deep": _deep,
    "5000 digits": lambda text, rng: text.replace("{", f'{{"x": {HUGE}, ', 1),
    "key twice": _twice,
    "UTF-16": lambda text, rng: text.encode("utf-16"),
    "binary": lambda text, rng: rng.bytes(500),
    "unknown key": lambda text, rng: text.replace("{", '{"colour": "white", ', 1),
}


def write(path: Path, content: str | bytes) -> None:
    """Writes text or bytes over a file."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())


def _some(rng: Rng, arguments: list[str]) -> list[str]:
    return arguments if rng.random() < 0.3 else []


# --- Suit files -----------------------------------------------------------------------------


def suit_command(rng: Rng) -> list[str]:
    """Returns a command that reads suit.json."""
    commands = [
        ["suits", "suit.json"],
        ["suits", "suit.json", "--out", "out", "--export", "new.json"],
        ["measure", "rig", "--suit", "suit.json", "--out", "out"],
        ["simulate", "--suit", "suit.json", "--out", "out"],
        ["evaluate", "--suit", "suit.json", "--policies", "none", "--out", "out"],
        ["validate", "suit.json", "--out", "out"],
        ["view", "--suit", "suit.json", "--snapshot", "new.png"],
        [
            "identify",
            "whole.csv",
            "--joint",
            "elbow_flexion",
            "--base",
            "suit.json",
            "--out",
            "out",
        ],
        ["train", "--suit", "suit.json", "--out", "out"],
    ]
    return commands[rng.integers(len(commands))]


def suit(change: Callable[[str, Rng], str | bytes]) -> Damage:
    """Returns damage that rewrites the suit file from its text."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        path = folder / "suit.json"
        write(path, change(path.read_text(), rng))
        return suit_command(rng)

    return damage


def shown_suit(change: Callable[[str, Rng], str | bytes]) -> Damage:
    """Returns damage of the suit file that may be harmless, with a fast command."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        suit(change)(folder, rng)
        return ["suits", "suit.json", *_some(rng, ["--json"])]

    return damage


def field(place: str, *values: Any) -> Damage:
    """Returns damage that gives a field of the suit one of some values; "elbow" is the joint."""
    *parents, last = place.replace("elbow", "joints.elbow_flexion").split(".")

    def change(text: str, rng: Rng) -> str:
        content = inner = json.loads(text)
        for name in parents:
            inner = inner[name]
        inner[last] = values[rng.integers(len(values))]
        return json.dumps(content)

    return suit(change)


def without(place: str) -> Damage:
    """Returns damage that removes a field of the suit."""
    *parents, last = place.replace("elbow", "joints.elbow_flexion").split(".")

    def change(text: str, rng: Rng) -> str:
        del rng
        content = inner = json.loads(text)
        for name in parents:
            inner = inner[name]
        del inner[last]
        return json.dumps(content)

    return suit(change)


def any_value(text: str, rng: Rng) -> str:
    """Returns a suit file in which one value, anywhere, is something else."""
    content = json.loads(text)
    places = []

    def collect(inner: Any) -> None:
        for name in inner if isinstance(inner, dict) else range(len(inner)):
            places.append((inner, name))
            if isinstance(inner[name], (dict, list)):
                collect(inner[name])

    collect(content)
    inner, name = places[rng.integers(len(places))]
    junk = [None, True, -1, 0, 1e308, 1e-320, "x", "", [], {}, [1], {"a": 1}, "\x1b[31m", 10**300]
    inner[name] = junk[rng.integers(len(junk))]
    return json.dumps(content)


SUITS = [
    *(Kind(f"suit: {name}", suit(change)) for name, change in BROKEN.items()),
    Kind("suit: version", field("schema_version", 2.0, "2", 1, 3, None, True, [2], 10**300)),
    Kind("suit: no version", without("schema_version")),
    Kind("suit: name", field("name", "", 3, None, ["x"])),
    Kind("suit: joints", field("joints", [], 3, None, "elbow", {"knee": {}}, {"\x1b[31m": {}})),
    Kind("suit: joint", field("elbow", [], 3, None, {}, {"x" * 3000: 1})),
    Kind("suit: model", field("elbow.model", "preisach", None, [], {}, {"model": "x" * 3000})),
    Kind(
        "suit: model name",
        field("elbow.model.model", "preisac", "", 3, None, ["clipped"]),
    ),
    Kind("suit: parameter", field("elbow.model.Ms", -1, 0, "x", None, True, [1], 1e400, 10**350)),
    Kind("suit: parameter missing", without("elbow.model.k")),
    Kind("suit: parameter unknown", field("elbow.model.kk", 1)),
    Kind("suit: range", field("elbow.range", [1.0, 0.5], [30, 90], [1], "x", None, [0, 1e400])),
    Kind("suit: range missing", without("elbow.range")),
    Kind("suit: start", field("elbow.start_angle", 99, "x", None, float("nan"), [1])),
    Kind("suit: start torque", field("elbow.start_torque", "x", None, float("inf"), {})),
    Kind("suit: grade", field("elbow.grade", "guess", 3, None, "")),
    Kind("suit: samples", field("elbow.samples", [{}], [1], "x", {"a": 1}, [None])),
    Kind("suit: pressure", field("pressure_kpa", 0, -1, 29600, "x", float("nan"), [1])),
    Kind("suit: label", field("label", "real", 3, "", [])),
    Kind("suit: missing", lambda folder, rng: [*_gone(folder / "suit.json"), *suit_command(rng)]),
    Kind(
        "suit: a folder", lambda folder, rng: [*_folder(folder / "suit.json"), *suit_command(rng)]
    ),
    Kind("suit: byte order mark", shown_suit(lambda text, rng: "\ufeff" + text), "harmless"),
    Kind("suit: bytes replaced", shown_suit(flipped), "either"),
    Kind("suit: any value", shown_suit(any_value), "either"),
]


def _gone(path: Path) -> list[str]:
    path.unlink()
    return []


def _folder(path: Path) -> list[str]:
    path.unlink()
    path.mkdir()
    return []


# --- Run folders ----------------------------------------------------------------------------


def run_command(rng: Rng) -> list[str]:
    """Returns a command that reads run/."""
    commands = [
        ["evaluate", "--policies", "run", "--unadapted", "--episodes", "8", "--out", "out"],
        ["simulate", "--policy", "run", "--out", "out"],
        ["train", "--resume", "--out", "run", "--steps", "1"],
    ]
    return commands[rng.integers(len(commands))]


def run_config(change: Callable[[str, Rng], str | bytes]) -> Damage:
    """Returns damage that rewrites policy.json of the run from its text."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        path = folder / "run" / "policy.json"
        write(path, change(path.read_text(), rng))
        return run_command(rng)

    return damage


def run_option(name: str, *values: Any) -> Damage:
    """Returns damage that gives an option of the run one of some values."""

    def change(text: str, rng: Rng) -> str:
        card = json.loads(text)
        part = "training" if name in card["training"] else "environment"
        card[part][name] = values[rng.integers(len(values))]
        return json.dumps(card)

    return run_config(change)


EXPORT = ("export", "run", "--onnx", "--out", "new.onnx")


def network(change: Callable[[Path, Rng], None]) -> Damage:
    """Returns damage of the file of the weights."""

    def damage(folder: Path, rng: Rng) -> list[str]:
        change(folder / "run" / "policy.safetensors", rng)
        return run_command(rng) if rng.integers(4) else [*EXPORT]

    return damage


def not_a_number(path: Path, rng: Rng) -> None:
    """Makes one weight of the network not a number."""
    from activesuit.envs.policies.network import files_of, read_card, read_network

    card = read_card(path.parent)
    network = read_network(path.parent, card)
    names = sorted(network.weights)
    network.weights[names[rng.integers(len(names))]].flat[0] = (np.nan, np.inf)[rng.integers(2)]
    for name, content in files_of(card, network).items():
        (path.parent / name).write_bytes(content)


RUNS = [
    *(Kind(f"run: config {name}", run_config(change)) for name, change in BROKEN.items()),
    Kind(
        "run: config missing",
        lambda folder, rng: [*_gone(folder / "run" / "policy.json"), *run_command(rng)],
    ),
    Kind(  # a policy acts without it, only a resume needs it
        "run: algorithm",
        run_option("algo", "dqn", "", 3, None, ["ppo"], "__class__", "x" * 3000),
        "either",
    ),
    Kind(
        "run: environment",
        run_option("env", "Nosuch-v0", "", 3, None, ["x"], "\x1b[31m", "os:system"),
    ),
    Kind("run: suit", run_option("suit", "nosuch", "", 3, None, ["x"], "x" * 3000)),
    Kind("run: gravity", run_option("gravity", "pluto", "", 3, None, ["moon"])),
    Kind(
        "run: wearer", run_option("wearer", {"stature": 9}, 3, None, [], {"x": 1}, {"mass": "80"})
    ),
    Kind("run: payload", run_option("payload", {"mass": -1}, 3, {"mass": None}, {"mas": 1})),
    Kind("run: network missing", network(lambda path, rng: path.unlink())),
    Kind("run: network empty", network(lambda path, rng: write(path, b""))),
    Kind("run: network is text", network(lambda path, rng: write(path, "PK\x03\x04 nothing"))),
    Kind(
        "run: network truncated",
        network(lambda path, rng: write(path, path.read_bytes()[: rng.integers(9, 9999)])),
    ),
    Kind("run: network a folder", network(lambda path, rng: _folder(path) and None)),
    Kind("run: weights not finite", network(not_a_number)),
]


# --- Options --------------------------------------------------------------------------------

IDENTIFY = ("identify", "whole.csv", "--out", "out", "--joint", "elbow_flexion")
SIMULATE = ("simulate", "--out", "out")
OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "identify": (
        IDENTIFY,
        {
            "--model": "name", "--method": "name", "--objective": "name", "--normalize": "name",
            "--initial-torque": "name", "--trials": "int", "--seed": "int", "--workers": "int",
            "--samples": "int", "--joint": "name", "--base": "name", "--for": "name",
            "--tare": "name", "--rate": "name", "--play": "name", "--softening": "name",
        },
    ),
    "design": (
        ("measure", "design", "whole.csv", "--out", "new.csv"),
        {"--min-rate": "float", "--max-rate": "float", "--sample-rate": "float"},
    ),
    "simulate": (
        SIMULATE,
        {
            "--env": "name", "--policy": "name", "--suit": "name", "--gravity": "name",
            "--seed": "int", "--pressure": "float", "--coupling": "name", "--side": "name",
            "--stature": "float", "--mass": "float", "--sex": "name", "--strength": "float",
            "--payload": "float",
        },
    ),
    "evaluate": (
        ("evaluate", "--out", "out"),
        {
            "--env": "name", "--policies": "name", "--suit": "name", "--seed": "int",
            "--episodes": "int",
        },
    ),
    "validate": (
        ("validate", "whole.json", "--out", "out"),
        {"--plant": "name", "--episodes": "int", "--env": "name", "--seed": "int"},
    ),
    "train": (
        ("train", "--out", "out"),
        {"--env": "name", "--algo": "name", "--steps": "int", "--seed": "int", "--suit": "name"},
    ),
    "rig": (
        ("measure", "rig", "--out", "out"),
        {
            "--suit": "name", "--joint": "name", "--turns": "float", "--start-angle": "float",
            "--repeats": "int", "--rate": "float", "--sample-rate": "float", "--noise": "float",
            "--seed": "int", "--torque-resolution": "float",
        },
    ),
    "view": (
        ("view", "--snapshot", "new.png"),
        {
            "--camera": "name", "--pose": "name", "--suit": "name", "--gravity": "name",
            "--width": "int",
        },
    ),
    "animate": (
        ("animate", "--out", "new.gif"),
        {"--camera": "name", "--suit": "name", "--policy": "name"},
    ),
    "suits": (("suits", "whole.json"), {"--pressure": "float"}),
}  # fmt: skip


def option(command: str) -> Damage:
    """Returns damage that gives an option of a command a value that cannot be used."""
    arguments, options = OPTIONS[command]

    def damage(folder: Path, rng: Rng) -> list[str]:
        del folder
        name = list(options)[rng.integers(len(options))]
        junk = JUNK[options[name]]
        return [*arguments, name, junk[rng.integers(len(junk))]]

    return damage


def said(*choices: Sequence[str]) -> Damage:
    """Returns damage that is one of some command lines."""
    return lambda folder, rng: list(choices[rng.integers(len(choices))])


def foreign_out(folder: Path, rng: Rng) -> list[str]:
    """Puts something else where the results should go."""
    out = folder / "out"
    match rng.integers(3):
        case 0:
            out.write_text("a file")
        case 1:
            out.mkdir()
            (out / "thesis.txt").write_text("mine")
        case _:
            (folder / "elsewhere").mkdir()
            out.symlink_to(folder / "elsewhere")
    return list((IDENTIFY, SIMULATE, OPTIONS["rig"][0], OPTIONS["train"][0])[rng.integers(4)])


OPTION_KINDS = [
    *(Kind(f"options: value of {name}", option(name)) for name in OPTIONS),
    Kind("options: no command", said([], ["nosuch"], [""], ["identfy", "whole.csv"], ["--nosuch"])),
    Kind("options: nothing given", said(["identify"], ["validate"])),
    Kind(
        "options: unknown",
        said([*IDENTIFY, "--nosuch", "1"], ["suits", "--x"], [*SIMULATE, "extra"]),
    ),
    Kind(
        "options: without a value",
        said([*IDENTIFY, "--seed"], [*SIMULATE, "--gravity"], ["suits", "--pressure"]),
    ),
    Kind(
        "options: contradictions",
        said(
            ["identify", "whole.csv", "--base", "mock-suit"],
            [*IDENTIFY, "--method", "mpso", "--model", "preisach"],
            [*IDENTIFY, "--method", "auto", "--trials", "3"],
            [*SIMULATE, "--suit", "none", "--pressure", "30"],
            ["suits", "--export", "new.json"],
            ["view", "--web", "--snapshot", "new.png"],
            ["train", "--coupling", "none", "--out", "out"],
        ),
    ),
    Kind(
        "options: names of files",
        said(
            ["identify", "nosuch.csv"],
            ["identify", "."],
            ["identify", "x" * 5000],
            ["identify", ""],
            ["animate", "--out", "new.txt"],
            ["view", "--snapshot", "new.jpg"],
            ["identify", "a\0b"],
            ["suits", "suit.json", "--export", "nosuch/new.json"],
            ["export", "nosuch", "--onnx", "--out", "new.onnx"],
            ["export", "compensation", "--onnx", "--out", "new.onnx"],
            ["export", "nosuch", "--c", "--out", "new.h"],
            ["export", "adaptive", "--c", "--out", "new.h"],
            ["export", "suit.json", "--c", "--out", "nosuch/new.h"],
            [*IDENTIFY[:3], "elbow.csv/out"],
        ),
    ),
    Kind("options: a place that is taken", foreign_out),
]

KINDS = [*CURVES, *MOTIONS, *SUITS, *RUNS, *OPTION_KINDS]


# --- Running --------------------------------------------------------------------------------


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Works in a folder, which is also where the state of the program goes."""
    before, state = Path.cwd(), os.environ.get("XDG_STATE_HOME")
    os.environ["XDG_STATE_HOME"] = str(folder / ".state")
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
        if state is None:
            del os.environ["XDG_STATE_HOME"]
        else:
            os.environ["XDG_STATE_HOME"] = state


def call(arguments: list[str]) -> tuple[int, str, str]:
    """Runs a command in this process; returns its exit code, stderr, and a traceback if any."""
    from activesuit.scripts.main import main

    out, err = io.StringIO(), io.StringIO()
    code, fallen = 0, ""
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main(arguments)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
        except BaseException:
            code, fallen = 1, traceback.format_exc()
    return code, err.getvalue(), fallen


def disk(folder: Path) -> dict[str, tuple[int, str]]:
    """Returns mode and content of everything in a folder."""
    found = {}
    for path in sorted(folder.rglob("*")):
        content = os.readlink(path) if path.is_symlink() else ""
        if path.is_file() and not path.is_symlink():
            content = hashlib.sha256(path.read_bytes()).hexdigest()
        found[str(path.relative_to(folder))] = (path.lstat().st_mode, content)
    return found


def problem(kind: Kind, folder: Path, rng: Rng) -> tuple[list[str], str]:
    """Does one damage in a fresh folder of inputs; returns the command and what was wrong."""
    arguments = kind.damage(folder, rng)
    before = disk(folder)
    with inside(folder):
        code, text, fallen = call(arguments)
    if fallen:
        return arguments, fallen.strip().splitlines()[-1] + " (traceback)"
    wanted = {"refused": [2], "harmless": [0], "either": [0, 2]}[kind.outcome]
    if arguments[:1] == ["identify"] and 0 in wanted:
        wanted = [*wanted, 3]  # the model may not describe the curves
    if code not in wanted:
        return arguments, f"exit code {code}, not {wanted}: {text[-300:]}"
    if code in (0, 3):
        return arguments, ""
    lines = [line for line in text.splitlines() if line.strip()]
    if len(lines) != 1 or not lines[0].startswith(PREFIX):
        return arguments, f"stderr is no single sentence: {text[:600]!r}"
    if len(lines[0]) > len(PREFIX) + LONGEST or not lines[0].isprintable():
        return arguments, f"the sentence is too long or does not print: {lines[0]!r}"
    after = disk(folder)
    if after != before:
        changed = sorted(set(after.items()) ^ set(before.items()))
        return arguments, f"changed on disk: {sorted({name for name, _ in changed})}"
    return arguments, ""


def attack(count: int, seed: int, *, trained: bool, report: Callable[[str], None]) -> Counter:
    """Does `count` damages; returns how many of each kind, and reports what was wrong."""
    kinds = [kind for kind in KINDS if trained or kind.family != "run"]
    rng = np.random.default_rng(seed)
    drawn = [*rng.permutation(len(kinds)), *rng.integers(len(kinds), size=count)][:count]
    done: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place:
        whole = Path(place) / "whole"
        whole.mkdir()
        make_inputs(whole, trained=trained)
        for i, number in enumerate(drawn):
            kind, folder = kinds[number], Path(place) / f"case-{i}"
            shutil.copytree(whole, folder)
            begin = time.perf_counter()
            arguments, wrong = problem(kind, folder, np.random.default_rng([seed, i]))
            done[kind.name] += 1
            if wrong:
                report(f"{kind.name}, case {i}: {shorter(arguments)}\n    {wrong}")
            if (spent := time.perf_counter() - begin) > 2:
                print(
                    f"{kind.name}, case {i}: {spent:.1f} s: {shorter(arguments)}", file=sys.stderr
                )
            shutil.rmtree(folder)
    return done


def shorter(arguments: list[str]) -> list[str]:
    """Returns arguments for a report."""
    return [one if len(one) < 60 else f"{one[:20]}... ({len(one)})" for one in arguments]


def main() -> None:
    """Runs the script."""
    parser = argparse.ArgumentParser(description="Commands on damaged inputs.")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    try:
        import stable_baselines3  # noqa: F401

        trained = True
    except ImportError:
        trained = False
    wrong: list[str] = []
    begin = time.perf_counter()
    done = attack(given.count, given.seed, trained=trained, report=wrong.append)
    for name, number in sorted(done.items()):
        print(f"{number:5}  {name}")
    print("\n".join(wrong))
    spent = time.perf_counter() - begin
    print(f"{sum(done.values())} damages of {len(done)} kinds, {len(wrong)} wrong, {spent:.0f} s")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
