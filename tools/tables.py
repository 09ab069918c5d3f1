"""Remakes tables of the docs: `python -m activesuit.tools.tables`.

They come from code and from kept results. Each stands between two marks of its page, so that the
text around it is written by hand.
"""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ..assets import JOINTS
from ..envs.domain.levels import LEVELS
from ..envs.interface.observation import BELIEF, SUITES
from ..envs.person import control
from ..envs.provenance import Quantity
from ..envs.simulation.measurements import COLUMNS
from ..envs.tasks import TASKS, Task
from ..envs.tasks.task import FARTHEST
from ..errors import InputError, unknown_name
from ..files import write_text
from ..scripts.training.hyperparameters import ALGORITHMS, DEFAULT, hyperparameters
from ..tables import markdown_table
from .results import door, muscle_bare, pushes, reliefs

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]
MARK = re.compile("<!-- made by tables.py: (.+) -->")

_GAINS = {
    "stiffness.base": "stiffness without torque, $K_0$",
    "stiffness.slope": "its growth with torque, $K_1$",
    "contraction": "co-contraction, $c$",
    "damping": "damping over stiffness, $T_D$",
    "delay": "delay of the reflex",
    "reflex": "gain of the reflex, $g$",
    "reflex.lead": "what a rate counts beside an error, $T_r$",
    "reflex.lag": "lag of the muscles behind the reflex",
    "correction": "share of an error that one correction removes",
    "correction.interval": "time between two corrections, and of each",
    "correction.least": "least error that is corrected",
    "correction.late": "time by which the intention may be late",
    "correction.delay": "age of the error that is seen",
    "persistence.felt": "age of the error that is felt",
    "persistence.window": "time over which its rate is felt",
    "persistence.still": "persistent: rate below which a joint does not give",
    "persistence.wait": "persistent: time without approach before a push",
    "persistence.rest": "persistent: time of rest before a push",
    "persistence.pace": "persistent: pace of a push",
    "persistence.most": "persistent: greatest torque of a push",
    "persistence.ahead": "persistent: time by which letting go precedes the arrival",
    "persistence.release": "persistent: pace of letting go",
    "persistence.fade": "persistent: time in which a push fades as the intention moves on",
    "persistence.calm": "persistent: share of the corrections that a swing leaves",
    "persistence.recovery": "persistent: time in which corrections recover",
    "persistence.stiffening": "persistent: co-contraction that an error adds",
    "persistence.relaxing": "persistent: time in which it relaxes",
    "learning": "learning from one motion to the next, $a$",
    "forgetting": "forgetting, $f$",
    "learning.pace": "learning within episodes that differ",
    "learning.credit": "how much earlier an answer is given the next time",
    "stiffening": "learning of co-contraction, $a_c$",
    "relaxing": "its forgetting, $g_c$",
    "contraction.most": "greatest co-contraction beyond the usual one",
    "noise": "noise, its standard deviation over torque at `noise=1`",
    "noise.corner": "its corner",
    "tremor.center": "tremor, its middle",
    "tremor.width": "its width",
}


def sensor_suites() -> str:
    """Returns the table of the sensor suites."""
    header = ["suite", "part in `layout`", "it adds", "numbers", "limit", "unit"]
    rows = []
    for suite, parts in SUITES.items():
        for i, part in enumerate(parts):
            columns = COLUMNS.get(part.measurement, BELIEF)
            name = "" if i else f"`{suite}`"
            size, limit, scale = columns.stop - columns.start, _number(part.limit), part.scale
            cells = [name, f"`{part.name}`", part.shows, str(size), limit, part.unit]
            rows.append([*cells, _number(scale)])
    return markdown_table([*header, "1 when normalized"], rows)


def gains() -> str:
    """Returns the table of the gains of the wearer's control."""
    groups: dict[str, list[Quantity]] = {}
    for quantity in control.PROVENANCE:
        name = quantity.name.removeprefix("control.")
        for joint in JOINTS:
            name = name.removesuffix(f".{joint}")
        groups.setdefault(name, []).append(quantity)
    header = ["gain", "value", "unit", "grade"]
    rows = [[_GAINS[name], *_gain(group)] for name, group in groups.items()]
    return markdown_table(header, rows)


def tasks() -> str:
    """Returns the table of the tasks."""
    header = ["task", "motion and load", "lasts", "place", "limits"]
    rows = []
    for name, task in TASKS.items():
        limits = [*_limits(task)]
        rows.append(
            [f"`{name}`", task.about, f"{task.duration:g} s", task.place, ", ".join(limits)]
        )
    return markdown_table(header, rows)


def _limits(task: Task) -> Iterator[str]:
    """Yields the limits of joints and effort, then those of the hand."""
    yield f"{1e3 * task.tracking:.0f} mrad"
    yield f"{100 * task.effort:.0f} %"
    for value, text in (
        (task.hand_error, f"{100 * task.hand_error:.0f} cm"),
        (task.tilt, f"tilt {task.tilt:g} rad"),
        (task.slowness, f"{100 * task.slowness:.0f} % too slow"),
    ):
        if value < FARTHEST:
            yield text


def levels() -> str:
    """Returns the table of the levels."""
    rows = []
    for name, options in LEVELS.items():
        terms = {**options, **options.get("randomize", {}), **options.get("faults", {})}
        for nested in ("randomize", "faults"):
            terms.pop(nested, None)
        shown = (f"`{term}={value!r}`" for term, value in terms.items())
        rows.append([f"`{name}`", ", ".join(shown) or "nothing"])
    return markdown_table(["level", "differs by"], rows)


def algorithms() -> str:
    """Returns the table of the learning algorithms."""
    rows = []
    for name, (package, kind) in ALGORITHMS.items():
        usual, learner = hyperparameters(name, DEFAULT), f"{kind} of {package.replace('_', '-')}"
        counts = (f"{usual[count]:,.0f}" for count in ("n_envs", "n_timesteps"))
        rows.append([f"`{name}`", learner, *counts])
    return markdown_table(["`--algo`", "learner", "usual `--rows`", "usual `--steps`"], rows)


def _gain(group: Sequence[Quantity]) -> Iterator[str]:
    values = [f"{quantity.value:g}" for quantity in group]
    yield ", ".join(values if len(set(values)) > 1 else values[:1])
    yield group[0].unit
    yield ", ".join(dict.fromkeys(quantity.grade for quantity in group))


def _number(value: float) -> str:
    return "π" if value == math.pi else f"{value:,g}"


TABLES: dict[str, Callable[[], str]] = {
    "results": door,
    "settings": reliefs,
    "bare": muscle_bare,
    "gains": gains,
    "pushes": pushes,
    "algorithms": algorithms,
    "tasks": tasks,
    "sensor suites": sensor_suites,
    "levels": levels,
}
"""The tables by the name in their marks."""


def marks(path: Path) -> list[str]:
    """Returns the names of the tables in a page."""
    return MARK.findall(path.read_text(encoding="utf-8"))


def page(path: Path) -> str:
    """Returns the text of a page with its tables as the code has them.

    Raises:
        InputError: No table has that name, or its second mark is missing.
    """
    text = path.read_text(encoding="utf-8")
    for name in marks(path):
        if name not in TABLES:
            raise unknown_name("table", name, [*TABLES])
        begin, end = f"<!-- made by tables.py: {name} -->\n", f"<!-- end: {name} -->"
        before, rest = text.split(begin)
        if rest.count(end) != 1:
            raise InputError(f"{path.name} has the mark {begin!r}: put {end!r} below it, once")
        text = f"{before}{begin}\n{TABLES[name]()}\n\n{end}{rest.split(end)[1]}"
    return text


if __name__ == "__main__":
    for path in PAGES:
        if marks(path):
            write_text(path, page(path))
            print(f"wrote {path}")
