"""Damaged files: a command ends with one sentence, and nothing changes on disk.

Each case damages one file at random, and runs a command that reads the file in this process.
`DAMAGES=20 python -m pytest tests/test_damage.py` draws 20 cases of each kind in place of one.
"""

import json
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from activesuit.assets import JOINTS, curves_path, load_suit
from activesuit.scripts.main import main
from helpers import content
from trained_runs import make_run

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]

LONGEST = 300 + len("activesuit: error: ")  # characters of a line on stderr
SECONDS = 5.0  # of computing, after which a command has accepted its input
REFUSED, EITHER = {2}, {0, 2, 3}  # exit codes; 3 means that no model describes the data

Rng = np.random.Generator
Mutation = Callable[[bytes, Rng], bytes | None]  # of a file; None makes the file a folder


def one_of(rng: Rng, choices: Any) -> Any:
    return choices[rng.integers(len(choices))]


def flipped(old: bytes, rng: Rng) -> bytes:
    new = np.frombuffer(old, np.uint8).copy()
    new[rng.integers(len(new), size=rng.integers(1, 6))] = rng.integers(256)
    return new.tobytes()


FILE: dict[str, Mutation] = {
    "folder": lambda old, rng: None,
    "empty": lambda old, rng: b"",
    "binary": lambda old, rng: rng.bytes(2000),
    "NUL": lambda old, rng: bytes(int(rng.integers(1, 9999))),
}
CUT: dict[str, Mutation] = {"cut": lambda old, rng: old[: rng.integers(1, len(old) - 2)]}
BYTES: dict[str, Mutation] = {"bytes replaced": flipped}

# --- Tables -------------------------------------------------------------------------------------

CELLS = ("", "x", "nan", "inf", "-inf", "1e400", "9" * 5000, "1,5", "--1", "0x10", "\x1b[2J", '"1')
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


TABLE = FILE | {
    "cell": rows(cell),
    "cell too many": rows(lambda table, rng: [*table, [*table[-1], "1"]]),
    "cell too few": rows(lambda table, rng: [*table, table[-1][1:]]),
    "huge cell": rows(lambda table, rng: [*table, ["x" * 200_000, *table[-1][1:]]]),
    "header only": rows(lambda table, rng: table[:1]),
    "one sample": rows(lambda table, rng: table[:2]),
    "no header": rows(lambda table, rng: table[1:]),
    "column twice": rows(lambda table, rng: [[table[0][-1], *table[0][1:]], *table[1:]]),
    "row twice": rows(lambda table, rng: [*table, one_of(rng, table)]),
}
PERHAPS_TABLE = CUT | BYTES | {
    "scaled": rows(scaled),
    "header": rows(lambda table, rng: [[one_of(rng, CELLS), *table[0][1:]], *table[1:]]),
    "column gone": rows(
        lambda table, rng: np.delete(table, rng.integers(len(table[0])), 1).tolist()
    ),
    "rows gone": rows(lambda table, rng: [row for row in table if rng.random() < 0.8]),
    "shuffled": rows(lambda table, rng: rng.permutation(table).tolist()),
}  # fmt: skip

# --- JSON ---------------------------------------------------------------------------------------

NUMBER = ("-1", "0", "1e308", "1e-320")
LITERALS: dict[type, tuple[str, ...]] = {
    bool: ("true",),
    int: NUMBER,
    float: NUMBER,
    str: ('"x"', '""', '"\\u001b[31m"'),
    list: ("[]", "[1]", "[{}]"),
    dict: ("{}", '{"a": 1}'),
}
NO_NUMBERS = ("NaN", "Infinity", "-Infinity", "1e400", "9" * 350)


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


JSON = FILE | CUT | {"key twice": literal(with_key)}
FREE: dict[str, Mutation] = {  # refused, except in a record of a training that holds any value
    "another type": literal(another_type),
    "no number": literal(lambda one: NO_NUMBERS if LITERALS.get(type(one)) is NUMBER else ()),
    "unknown key": literal(lambda value: with_key(value, "colour")),
}
PERHAPS_JSON = BYTES | {
    "key gone": literal(without_key),
    "any value": literal(lambda value: ["null", *(x for one in LITERALS.values() for x in one)]),
}

# --- Files and the commands that read them ------------------------------------------------------

ACTING = (
    "export run --onnx --out new.onnx",
    "simulate --policy run --out out",
    "evaluate --policies run --unadapted --motions 8 --out out",
)
FILES: dict[str, tuple[dict[str, Mutation], dict[str, Mutation], tuple[str, ...]]] = {
    "elbow.csv": (TABLE, PERHAPS_TABLE, (
        "identify elbow.csv --model prandtl-ishlinskii",
        "identify elbow.csv --out out --workers 1",
        "design elbow.csv --out new.csv",
        "validate whole.json --held-out elbow.csv --joint elbow_flexion --out out",
    )),
    "motion.csv": (TABLE, PERHAPS_TABLE, (
        "rig --motion motion.csv --out out",
        "identify whole.csv --for motion.csv --model prandtl-ishlinskii",
    )),
    "arm.csv": (TABLE, PERHAPS_TABLE, (
        "simulate --task arm.csv --out out", "evaluate --task arm.csv"
    )),
    "suit.json": (JSON | FREE, PERHAPS_JSON, (
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
    "policy.json": (JSON | FREE, PERHAPS_JSON, (
        "export policy.json --c --out new.h", "simulate --policy policy.json --out out"
    )),
    "run/policy.json": (JSON, PERHAPS_JSON | FREE, ACTING),
    "run/policy.safetensors": (FILE | CUT, BYTES, ACTING),
    "run/model.zip": (FILE | CUT, BYTES, ("train --resume --trust --steps 64 --out run",)),
}  # fmt: skip
KINDS = {
    f"{name}: {kind}": (name, mutation, codes, commands)
    for name, (refused, perhaps, commands) in FILES.items()
    for codes, mutations in ((REFUSED, refused), (EITHER, perhaps))
    for kind, mutation in mutations.items()
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder of undamaged files."""
    pytest.importorskip("stable_baselines3")
    folder = tmp_path_factory.mktemp("whole") / "files"
    make_run(folder.parent / "run")
    elbow = ["curve,role,angle_rad,torque_nm,time_s,weight"]
    lines = [line for line in curves_path("elbow").read_text().splitlines() if line[0].isdigit()]
    elbow += [f"{line},{i},1" for i, line in enumerate(lines[::40])]
    arm = [",".join(["time", *JOINTS]), *(f"{0.1 * i:.1f},0,0.5,0.6,0" for i in range(12))]
    motion = ["time_s,angle_rad", "0,0.52", "2,1.1", "4,0.7", "6,0.9"]
    tables = {"elbow.csv": elbow, "whole.csv": elbow, "arm.csv": arm, "motion.csv": motion}
    folder.mkdir()
    for name, table in tables.items():
        (folder / name).write_text("\n".join(table) + "\n")
    for name in ("suit.json", "whole.json"):
        load_suit("mock-suit").save(folder / name)
    policy = {"name": "compensation", "suit": "mock-suit", "lead": 0.03}
    (folder / "policy.json").write_text(json.dumps(policy))
    shutil.move(folder.parent / "run", folder)
    return folder


class AcceptedError(BaseException):
    """The command has computed for so long that it must have accepted its input."""


def accept(*given: object) -> None:
    raise AcceptedError


def exit_code(arguments: list[str]) -> object:
    """Runs a command for at most `SECONDS` of computing."""
    signal.signal(signal.SIGPROF, accept)
    signal.setitimer(signal.ITIMER_PROF, SECONDS, 1.0)
    try:
        main(arguments)
    except SystemExit as end:
        return end.code
    except AcceptedError:
        pass
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return 0


@pytest.mark.parametrize("seed", range(int(os.environ.get("DAMAGES", "1"))))
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_one_sentence(whole, tmp_path, monkeypatch, capsys, kind, seed):
    name, mutation, codes, commands = KINDS[kind]
    rng = np.random.default_rng([seed, *kind.encode()])
    folder = tmp_path / "case"
    shutil.copytree(whole, folder)
    monkeypatch.chdir(folder)
    path = Path(name)
    new = mutation(path.read_bytes(), rng)
    path.unlink()
    path.mkdir() if new is None else path.write_bytes(new)
    before, command = content(folder), one_of(rng, commands)
    capsys.readouterr()
    code, said = exit_code(command.split()), capsys.readouterr().err
    assert code in codes, f"{command}: {said}"
    if code == 2:
        (line,) = (line for line in said.splitlines() if line.strip())
        assert line.startswith("activesuit: error: ") and line.isprintable()
        assert len(line) <= LONGEST
        assert content(folder) == before
