"""Executes the tutorials and writes their pages: `python -m activesuit.tools.tutorials [--check]`.

A tutorial is a Python program in the percent format, which Jupytext, VS Code and Spyder open as a
notebook: a line `# %% [markdown]` begins a cell of prose, and `# %%` one of code. The tutorials run
in their order in one new folder, since each one reads files of those before it. The page has the
cells, what they print, and the figures that they show, which are SVG files for light and for dark
pages. With --check nothing is written, and the pages must be what the programs print today.
"""

import argparse
import contextlib
import io
import re
import sys
import tempfile
import textwrap
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from ..errors import InputError
from ..files import write_text

FOLDER = Path(__file__).parent.parent / "docs" / "tutorials"
VARIES = 'tags=["varies"]'  # in the line of a cell whose output differs between machines
TOLERANCE = 0.01  # greatest relative difference of a number, unless its last digit differs by 1
WIDTH = 100  # of a line of output; a terminal breaks longer ones, too
INK = {"light": "#31353b", "dark": "#d5d8df"}  # colors of text and axes
STYLE: dict[Any, Any] = {
    **dict.fromkeys(
        ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"),
        INK["light"],
    ),
    "axes.prop_cycle": cycler(color=["#3b82c4", "#e0741b", "#2f9e63", "#d0458f", "#8a94a6"]),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "figure.figsize": (8.4, 3.6),
    "legend.frameon": False,
    "savefig.transparent": True,
    "svg.hashsalt": "tutorials",
}


@dataclass(frozen=True)
class Cell:
    """A cell of a tutorial.

    Attributes:
        text: Markdown or Python code.
        is_code: Whether it is code.
        varies: Whether its output may differ between machines, as after a training.
        line: Number of its first line in the program.
    """

    text: str
    is_code: bool
    varies: bool = False
    line: int = 1


def cells(script: str) -> list[Cell]:
    """Returns the cells of a program in the percent format.

    Args:
        script: Text of the program, which begins with a cell.

    Raises:
        InputError: Something stands before the first cell, or prose is no comment.
    """
    before, *parts = re.split(r"^# %%", script, flags=re.MULTILINE)
    if before.strip() or not parts:
        raise InputError(f"a tutorial begins with {before[:40]!r}: begin it with '# %%'")
    found, line = [], 1 + before.count("\n")
    for part in parts:
        head, _, text = part.partition("\n")
        is_code = "[markdown]" not in head
        if not is_code:
            lines = text.rstrip().split("\n")
            for number, one in enumerate(lines, line + 1):
                if not one.startswith("#"):
                    raise InputError(f"line {number} is no comment in a cell of prose: {one!r}")
            text = "\n".join(one[1:].removeprefix(" ") for one in lines)
        found.append(Cell(text.strip("\n"), is_code, VARIES in head, line + 1))
        line += part.count("\n")
    return found


def page(name: str, script: str, outputs: Sequence[str]) -> str:
    """Returns the page of a tutorial.

    Args:
        name: Name of the program without its ending.
        script: Text of the program.
        outputs: Markdown of what each cell of code prints and shows.
    """
    left = iter(outputs)
    parts = [f"<!-- made by tutorials.py from {name}.py -->"]
    for cell in cells(script):
        parts += [f"```python\n{cell.text}\n```", next(left)] if cell.is_code else [cell.text]
    return "\n\n".join(part for part in parts if part) + "\n"


def execute(name: str, script: str) -> tuple[list[str], dict[str, str]]:
    """Runs a tutorial in the working folder.

    Args:
        name: Name of the program without its ending.
        script: Text of the program.

    Returns:
        Markdown of what each cell of code prints and shows, and the SVG files of its figures by
        their names.

    Raises:
        InputError: A figure has no name, which its page needs for those who cannot see it.
    """
    outputs, figures = [], {}
    names = {"__name__": "__main__"}
    plt.switch_backend("agg")
    with mpl.rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "FigureCanvasAgg is non-interactive")
        for cell in cells(script):
            if not cell.is_code:
                continue
            code = compile("\n" * (cell.line - 1) + cell.text, f"{name}.py", "exec")
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(code, names)
            parts = [_block(printed.getvalue(), cell.varies)]
            for number in plt.get_fignums():
                figure = plt.figure(number)
                if not figure.get_label():
                    raise InputError(f"{name}.py, line {cell.line}: give the figure a name, num=")
                stem = f"{name}-{len(figures) // 2 + 1}"
                drawn = _drawn(figure)
                figures |= {f"{stem}-{mode}.svg": text for mode, text in drawn.items()}
                parts += [
                    f"![{figure.get_label()}](figures/{stem}-{mode}.svg#gh-{mode}-mode-only)"
                    for mode in drawn
                ]
            plt.close("all")
            outputs.append("\n\n".join(part for part in parts if part))
    return outputs, figures


def _block(printed: str, varies: bool) -> str:
    lines = (textwrap.fill(line, WIDTH, **_WRAP) for line in printed.rstrip().split("\n"))
    text = "\n".join(line.rstrip() for line in lines)
    kind = "varies" if varies else "output"
    return f"``` {{ .text .{kind} }}\n{text}\n```" if text else ""


_WRAP: dict[str, Any] = {"break_long_words": False, "replace_whitespace": False}


def _drawn(figure: Figure) -> dict[str, str]:
    """Returns a figure as SVG for light and for dark pages, which differ in the ink."""
    file = io.StringIO()
    figure.savefig(file, format="svg", metadata={"Date": None})
    text = re.sub(r"[ \t]+$", "", file.getvalue(), flags=re.MULTILINE)
    return {mode: text.replace(INK["light"], ink) for mode, ink in INK.items()}


def differences(old: str, new: str) -> Iterator[str]:
    """Yields a sentence for each line of a page that differs, but for outputs that vary."""
    ours, theirs = (_VARYING.sub("", text).splitlines() for text in (old, new))
    if len(ours) != len(theirs):
        yield f"it has {len(theirs)} lines of what does not vary, and {len(ours)} are kept"
    for one, other in zip(ours, theirs, strict=False):
        if not _alike(one, other):
            yield f"{other!r}, and {one!r} is kept"


_VARYING = re.compile(r"^``` \{ \.text \.varies \}\n.*?^```$", re.DOTALL | re.MULTILINE)
_NUMBER = re.compile(r"-?\d+(?:\.(\d+))?(?:e[+-]?\d+)?")
_SPACES = re.compile(r"[\s─]+")  # the widths of columns follow their numbers


def _alike(old: str, new: str) -> bool:
    near = all(
        abs(float(one[0]) - float(other[0]))
        <= max(TOLERANCE * abs(float(one[0])), 1.01 * 10 ** -len(one[1] or ""))
        for one, other in zip(_NUMBER.finditer(old), _NUMBER.finditer(new), strict=False)
    )
    plain = [_SPACES.sub(" ", _NUMBER.sub("0", line)).strip() for line in (old, new)]
    return near and plain[0] == plain[1]


def write(folder: Path = FOLDER, check: bool = False) -> None:
    """Executes all tutorials, and writes or checks their pages."""
    with tempfile.TemporaryDirectory() as work, contextlib.chdir(work):
        for path in sorted(folder.glob("*.py")):
            begin, script = time.monotonic(), path.read_text(encoding="utf-8")
            outputs, figures = execute(path.stem, script)
            print(f"{path.stem}: {time.monotonic() - begin:.0f} s", flush=True)
            text, place = page(path.stem, script, outputs), path.with_suffix(".md")
            if check:
                found = list(differences(place.read_text(encoding="utf-8"), text))
                if found:
                    sys.exit("\n".join([f"{place.name} is not what {path.name} prints:", *found]))
                continue
            write_text(place, text)
            (folder / "figures").mkdir(exist_ok=True)
            for name, drawing in figures.items():
                write_text(folder / "figures" / name, drawing)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, compare the pages")
    write(check=parser.parse_args().check)
