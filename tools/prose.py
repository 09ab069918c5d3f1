"""Counts unclear prose: `python -m activesuit.tools.prose [PATH]`.

Every argument, attribute and result that a docstring describes needs a noun phrase ("Unique name
of the new plugin instance.") or a clause ("Whether the wearer is tired."). So does a comment behind
code. A description that begins in the middle of a sentence ("of the plugin instance, new in the
spec"; "Hz, up to which a cycle is learned") is a fragment: only readers who guess what stands
before it can understand it.

Words that mean one thing in daily life and another one only here (the suit is `told`) are counted
in strings, comments and pages; the field has its own words for all of them. Names in code, such as
`Held`, are no prose. Pages have at most 25 words in a sentence on average.
"""

import argparse
import ast
import re
import sys
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
PARTS = ("assets", "envs", "hysteresis", "identification", "scripts", ".")
LIMIT = 0.03  # greatest share of fragments among descriptions in docstrings
COMMENT_LIMIT = 0.05  # the same among comments behind code
SENTENCE_LIMIT = 25  # words in an average sentence of a page
PRIVATE = "told worn taught led settled felt shaken growing heard held he him his".split()
"""Words that are no prose of this project."""
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
_FSTRING = getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)  # Python 3.12 has parts of its own
PROSE = {tokenize.COMMENT, tokenize.STRING, _FSTRING}


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
        """Whether the description begins in the middle of a sentence, be it after a unit."""
        text = re.sub(r"^\[[^\]]*\],? (?=\w)", "", self.text)
        after_unit = re.match(r"(?:[a-z%°]\S*|[A-Z]\S?|\S*·\S*), (?=\w)", text)
        return _is_fragment(text) or bool(after_unit and _is_fragment(text[after_unit.end() :]))


def _is_fragment(text: str) -> bool:
    words = re.findall(r"[^\W\d_]+", text.lower())
    if text.startswith("[") or (words[:1] and words[0] in NOT_FIRST):
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


def comments(path: Path) -> Iterator[Line]:
    """Yields the comments behind code of a Python file."""
    code = path.read_text(encoding="utf-8").splitlines()
    for token in _tokens(path):
        number, column = token.start
        text = token.string.lstrip("#: ")
        tool = text.startswith(("noqa", "type:", "pyright:"))
        if token.type == tokenize.COMMENT and code[number - 1][:column].strip() and not tool:
            yield Line(path, number, text)


def _tokens(path: Path) -> Iterator[tokenize.TokenInfo]:
    with tokenize.open(path) as file:
        yield from tokenize.generate_tokens(file.readline)


def private_words(path: Path) -> Iterator[Line]:
    """Yields the words of `PRIVATE` in the prose of a Python file or a page."""
    if path.suffix == ".py":
        texts = (token for token in _tokens(path) if token.type in PROSE)
        prose = [(token.start[0], token.string) for token in texts if " " in token.string]
    else:
        page = _BLOCK.sub(_blank, path.read_text(encoding="utf-8"))
        prose = list(enumerate(page.split("\n"), 1))
    for first, text in prose:
        for number, line in enumerate(text.split("\n"), first):
            plain = re.sub(r"``?[^`]*`?`|\{[^{}]*\}|[Hh]eld[- ]out\b|<!--.*?-->", "", line)
            plain = re.sub(r"^\s+\w+: ", "", plain)  # the name of an argument
            for word in re.findall(r"(?<![\w.=/#-])[A-Za-z]+(?![\w=(/<]|\.\w)", plain):
                field = word == "He" and path.suffix == ".py"  # the effective field of a model
                if word.lower() in PRIVATE and not field:
                    yield Line(path, number, word.lower())


_BLOCK = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)


def _blank(block: re.Match[str]) -> str:
    return "\n" * block[0].count("\n")


def sentence_length(page: str) -> float:
    """Returns the words in an average sentence of a page, outside code, tables and headings."""
    other = r"^```.*?^```$|<!--.*?-->|\$\$.*?\$\$"
    text = re.sub(other, "", page, flags=re.DOTALL | re.MULTILINE)
    blocks = re.split(r"\n\s*\n|\n\s*(?=[-*] |\d+\. )", text)
    sentences = [
        sentence.split()
        for block in blocks
        if block.strip() and not block.lstrip().startswith(("#", "|", "!["))
        for sentence in re.split(r"(?<=[.!?])[)*\"”]*\s+", block.strip())
    ]
    return sum(map(len, sentences)) / max(1, len(sentences))


def sources(root: Path) -> dict[str, list[Path]]:
    """Returns the files of the package below `root`, by the part that they belong to."""
    return {
        part: sorted((root / part).glob("*.py" if part == "." else "**/*.py"))
        for part in PARTS
        if (root / part).is_dir()
    }


def pages(root: Path) -> list[Path]:
    """Returns the pages below `root` that people write."""
    return sorted([*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("assets/**/*.md")])


def main(root: Path = ROOT) -> int:
    """Prints what is unclear, with its counts; returns 1 if a limit is passed, else 0."""
    found = sources(root)
    docstrings = {part: list(lines(paths)) for part, paths in found.items()}
    behind = {
        part: [one for path in paths for one in comments(path)] for part, paths in found.items()
    }
    failed = _count("descriptions", docstrings, LIMIT, root)
    failed |= _count("comments behind code", behind, COMMENT_LIMIT, root)
    everywhere = [path for paths in found.values() for path in paths] + pages(root)
    everywhere = [path for path in everywhere if path.name != Path(__file__).name]
    words = [word for path in everywhere for word in private_words(path)]
    for word in words:
        print(f"{word.path.relative_to(root)}:{word.number}: {word.text}")
    counts = Counter(word.text for word in words)
    print("private words:", ", ".join(f"{word} {counts[word]}" for word in PRIVATE))
    for path in pages(root):
        length = sentence_length(path.read_text(encoding="utf-8"))
        if length > SENTENCE_LIMIT:
            failed = True
            print(f"{path.relative_to(root)}: {length:.1f} words in a sentence on average")
    return int(failed or bool(words))


def _count(title: str, described: dict[str, list[Line]], limit: float, root: Path) -> bool:
    """Prints the fragments of each part and their share; returns whether it passes the limit."""
    for part in described.values():
        for line in filter(lambda line: line.is_fragment, part):
            print(f"{line.path.relative_to(root)}:{line.number}: {line.text}")
    print(f"fragments among {title}:")
    for part, all_lines in described.items():
        print(f"{part:16} {sum(one.is_fragment for one in all_lines):5} of {len(all_lines):5}")
    everything = [one for part in described.values() for one in part]
    fragments = sum(one.is_fragment for one in everything)
    share = fragments / max(1, len(everything))
    print(f"{'all':16} {fragments:5} of {len(everything):5}, {share:.1%}; at most {limit:.0%}")
    return share > limit


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path, nargs="?", default=ROOT, help="root of the package")
    sys.exit(main(parser.parse_args().path))
