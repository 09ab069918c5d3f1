"""Makes the pictures of the docs: `python -m activesuit.tools.pictures [NAME ...]`.

Without a name it makes those that are older than their program or their data. The programs are in
docs/figures, examples and docs/tutorials. An example makes its page in docs/numbers/examples too,
and the tutorials make theirs (`tutorials.py`). docs/figures/pictures.json keeps a hash of the code
and of the data of each picture, and a test compares the hashes. `--same NAME ...` keeps the new
hashes without drawing, for a change of code that changes no picture, such as another import.
"""

import argparse
import ast
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from ..files import write_text
from ..json_files import read_json
from . import tutorials

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
FIGURES, EXAMPLES, TUTORIALS = DOCS / "figures", ROOT / "examples", DOCS / "tutorials"
EXAMPLE_PAGES = DOCS / "numbers" / "examples"
KEPT = FIGURES / "pictures.json"
ENDINGS = (".png", ".gif")

# `make test-all` compares a fresh demo with the kept one, so that demo.json changes where the
# simulation does.
SIMULATION = ("assets/mjcf/arm.xml", "assets/suits/*.json", "docs/measured/demo.json")
DATA: dict[str, tuple[str, ...]] = {
    "environments": (),
    "models": (),
    "stribeck": (),
    "three_joints": ("docs/figures/arm.xml",),
    "identification": ("assets/curves/elbow.csv",),
    "suits": ("assets/suits/*.json",),
    "results": ("docs/measured/settings.json",),
    "leaderboard": ("docs/leaderboard.jsonl", "plots.py"),
    "measured_loop": (),
    "optimizers": ("assets/curves/elbow.csv",),
}
"""Data of a program as patterns below the root, where it is not `SIMULATION`."""


def programs() -> dict[str, Path]:
    """Returns the programs that make pictures or pages, by name."""
    folders = (FIGURES, EXAMPLES, TUTORIALS)
    return {path.stem: path for folder in folders for path in sorted(folder.glob("[!_]*.py"))}


def hashes(name: str) -> dict[str, str]:
    """Returns the hashes of the code and of the data of a program."""
    data = [path for one in DATA.get(name, SIMULATION) for path in sorted(ROOT.glob(one))]
    return {"program": _hash([programs()[name]]), "data": _hash(data)}


def _hash(paths: Iterable[Path]) -> str:
    """Returns the hash of files; of Python files that of the code, without comments and text."""
    found = hashlib.sha256()
    for path in paths:
        text = path.read_text(encoding="utf-8")
        found.update((_code(text) if path.suffix == ".py" else text).encode())
    return found.hexdigest()[:16]


def _code(text: str) -> str:
    body = ast.parse(text).body
    begin = body[1].lineno - 1 if ast.get_docstring(ast.parse(text)) else 0
    lines = (line.rstrip() for line in text.splitlines()[begin:])
    return "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))


def stale() -> list[str]:
    """Returns the names of the programs that have changed, or whose data have."""
    kept = read_json(KEPT, "hashes")
    return [name for name in programs() if kept.get(name) != hashes(name)]


def introduction(name: str) -> str:
    """Returns the beginning of an example's page: title, first paragraph, command."""
    title, begin, _ = _docstring(name)
    return f"# {title.rstrip('.')}\n\n{begin}\n\n```bash\npython examples/{name}.py\n```\n"


def _docstring(name: str) -> list[str]:
    """Returns title, first paragraph and rest of an example's docstring."""
    text = ast.get_docstring(ast.parse((EXAMPLES / f"{name}.py").read_text(encoding="utf-8")))
    title, begin, *rest = (text or "").split("\n\n")
    return [title, begin, "\n\n".join(rest)]


def make(name: str) -> None:
    """Runs a program in an empty folder, and keeps its picture, its page and its hashes."""
    program, data = programs()[name], FIGURES / "arm.xml"
    is_example = program.parent == EXAMPLES
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(data, folder)
        done = subprocess.run(
            [sys.executable, str(program)],
            cwd=folder,
            env={**os.environ, "MPLBACKEND": "agg"},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        drawn = sorted(path for path in Path(folder).iterdir() if path.suffix in ENDINGS)
        for path in drawn:
            shutil.copy(path, EXAMPLE_PAGES if is_example else FIGURES)
    if is_example:
        page = f"{introduction(name)}\n```text\n{done.stdout.strip()}\n```\n"
        page += "".join(f"\n![Figure of this program]({path.name})\n" for path in drawn)
        write_text(EXAMPLE_PAGES / f"{name}.md", f"{page}\n{_docstring(name)[2]}".rstrip() + "\n")
    keep([name])


def keep(names: Iterable[str]) -> None:
    """Keeps the hashes of programs, and forgets those of programs that are gone."""
    kept = read_json(KEPT, "hashes") if KEPT.exists() else {}
    found = {**kept, **{name: hashes(name) for name in names}}
    content = {name: found[name] for name in programs() if name in found}
    write_text(KEPT, json.dumps(content, indent=1) + "\n")


def main() -> None:
    """Makes the named pictures, or those that are old."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="programs to run")
    parser.add_argument("--same", nargs="+", metavar="NAME", default=[], help="draw nothing")
    given = parser.parse_args()
    keep(given.same)
    names = given.names or ([] if given.same else stale())
    of_tutorials = [name for name, path in programs().items() if path.parent == TUTORIALS]
    for name in (one for one in names if one not in of_tutorials):
        print(name, flush=True)
        make(name)
    if set(names) & set(of_tutorials):  # each one reads files of those before it
        tutorials.write()
        keep(of_tutorials)


if __name__ == "__main__":
    main()
