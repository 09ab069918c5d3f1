"""Counts fragments in the docstrings: `python -m activesuit.scripts.maintenance.prose [PATH]`.

Every argument, attribute and result that a docstring describes needs a noun phrase ("Unique name
of the new plugin instance.") or a clause ("Whether the wearer is tired."). A description that
begins in the middle of a sentence ("of the plugin instance, new in the spec") is a fragment: only
readers who guess what stands before it can understand it.
"""

import argparse
import ast
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
PARTS = ("assets", "envs", "hysteresis", "identification", "scripts", ".")
LIMIT = 0.03  # share of fragments
SECTIONS = ("Args:", "Attributes:", "Returns:", "Yields:")
NAMED = ("Args:", "Attributes:")  # sections whose entries are `name: description`

PREPOSITIONS = """about above across after against along among around as at before behind below
    beneath beside between beyond by despite down during for from in inside into like near of off on
    onto out outside over past per since than through throughout till to toward towards under until
    up upon via with within without"""
CONJUNCTIONS = (
    "and because but however likewise nor or so that then therefore though while whom whose"
)
POINTERS = "see same ditto idem similarly"
PARTICIPLES = """added applied begun called computed created drawn done ended fitted found given
    held kept known made measured needed passed put run said scaled set shown started stored taken
    tried used written"""
VERBS = """begins changes chooses decides does ends fixes gets gives goes has holds is keeps makes
    maps needs takes tells was were"""
LINKS = frozenset(f"{PREPOSITIONS} {CONJUNCTIONS}".split())
NOT_FIRST = LINKS | frozenset(f"{POINTERS} {VERBS}".split())


@dataclass(frozen=True)
class Line:
    """The description of one argument, attribute or result.

    Attributes:
        path: File of the docstring.
        number: Line of the description in that file.
        text: First line of the description.
    """

    path: Path
    number: int
    text: str

    @property
    def is_fragment(self) -> bool:
        """Whether the description begins in the middle of a sentence."""
        words = re.findall(r"[^\W\d_]+", self.text.lower())
        if self.text.startswith("[") or (words[:1] and words[0] in NOT_FIRST):
            return True
        return bool(words) and words[0] in PARTICIPLES.split() and set(words[1:2]) <= LINKS


def lines(paths: Iterable[Path]) -> Iterator[Line]:
    """Yields the described arguments, attributes and results of Python files."""
    for path in paths:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
                text = ast.get_docstring(node, clean=False)
                if text:
                    first = node.body[0].lineno
                    yield from _described(path, first, text)


def _described(path: Path, first: int, docstring: str) -> Iterator[Line]:
    """Yields the entries of the sections of one docstring, which begins at the line `first`."""
    section, indent = "", 0
    for number, line in enumerate(docstring.split("\n"), first):
        text, depth = line.strip(), len(line) - len(line.lstrip())
        if text in SECTIONS:
            section, indent = text, depth
        elif text and depth <= indent:
            section = ""
        elif section in NAMED and depth == indent + 4:
            entry = re.match(r"\*{0,2}\w+(?: \([^)]*\))?: *(.*)", text)
            if entry:
                yield Line(path, number, entry[1])
        elif section and section not in NAMED and text:
            yield Line(path, number, text)
            section = ""


def sources(root: Path) -> dict[str, list[Path]]:
    """Returns the files of the package below `root`, by the part that they belong to."""
    return {
        part: sorted((root / part).glob("*.py" if part == "." else "**/*.py"))
        for part in PARTS
        if (root / part).is_dir()
    }


def main(root: Path = ROOT) -> int:
    """Prints all fragments and their share; returns 1 if the share is above the limit, else 0."""
    described, fragments = Counter(), Counter()
    for part, paths in sources(root).items():
        for line in lines(paths):
            described[part] += 1
            if line.is_fragment:
                fragments[part] += 1
                print(f"{line.path.relative_to(root)}:{line.number}: {line.text}")
    for part in described:
        print(f"{part:16} {fragments[part]:5} of {described[part]:5}")
    total, found = described.total(), fragments.total()
    share = found / max(1, total)
    print(f"{'all':16} {found:5} of {total:5}, {share:.1%}; at most {LIMIT:.0%}")
    return int(share > LIMIT)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path, nargs="?", default=ROOT, help="root of the package")
    sys.exit(main(parser.parse_args().path))
