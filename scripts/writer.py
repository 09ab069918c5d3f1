"""The end of a command: its result is printed, and written with a page into a folder."""

import base64
import gzip
import hashlib
import io
import json as json_module
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any

from .. import __version__
from ..plots import Plot
from ..tables import Rows, columns_of_words
from ..text import say, visible
from .columns import explained
from .folders import RunFolder, to_json
from .output import table

PACKAGES = ("mujoco", "numpy", "scipy", "numba", "gymnasium")
PAGE, RESULT = "report.html", "result.json"
DATA = (".json", ".jsonl", ".csv", ".safetensors")
MOST_ROWS = 500  # of a table of a page
DPI = 140
_HERE = __name__.rpartition(".")[0]


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a command found.

    Attributes:
        heading: What the command does, as the title of its page.
        about: What it was done with: a file, or task, place and suit.
        result: Plain values, which result.json and --json hold.
        tables: Header and rows of tables, by title; the first one is the answer.
        answer: Sentences, the most important one first.
        columns: Header and rows of CSV files, by name.
        plots: Figures, by the name of the file without its end.
        pictures: Drawings that are no plots, or pixels (height, width, 3), in the same way.
        settings: Options of the run; by default the plain values among the result.
    """

    heading: str
    about: str
    result: Mapping[str, Any]
    tables: Mapping[str, Rows]
    answer: Sequence[str] = ()
    columns: Mapping[str, tuple[Sequence[str], Iterable[Sequence[Any]]]] = field(
        default_factory=dict
    )
    plots: Mapping[str, Plot] = field(default_factory=dict)
    pictures: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, Any] | None = None

    @classmethod
    def of(cls, found: Any, heading: str, about: str, **more: Any) -> "Report":
        """Returns the report of a result, which has its tables, sentences, columns and figures.

        Args:
            found: Result with `to_dict`, `tables` and `sentences`, perhaps also `columns`,
                `plots` and `pictures`.
            heading: What the command does.
            about: What it was done with.
            **more: Attributes of the report that are not those of the result.
        """
        parts = {"result": "to_dict", "tables": "tables", "answer": "sentences"}
        parts |= {name: name for name in ("columns", "plots", "pictures") if hasattr(found, name)}
        given = {name: getattr(found, of)() for name, of in parts.items() if name not in more}
        return cls(heading=heading, about=about, **given, **more)


def conclude(report: Report, folder: RunFolder | None, json: bool = False) -> None:
    """Prints a report, as JSON or as tables and sentences; writes it if there is a folder."""
    if folder:
        write(report, folder)
    if json:
        print(to_json(report.result))
        return
    for title, rows in report.tables.items():
        table(title, *rows)
    for sentence in report.answer:
        say(sentence)
    if folder:
        say(f"wrote {folder.path}: {PAGE} has everything, {_list(report)} the parts")


def write(report: Report, folder: RunFolder) -> None:
    """Writes result.json, CSV files, figures as PNG and SVG, and the page."""
    folder.json(RESULT, report.result)
    for name, (header, rows) in report.columns.items():
        folder.csv(name, header, rows)
    for name, plot in report.plots.items():
        folder.figure(name, plot.figure())
    for name, picture in report.pictures.items():
        write_picture = folder.figure if hasattr(picture, "savefig") else folder.picture
        write_picture(name, picture)
    folder.text(PAGE, page(report, folder))


def page(report: Report, folder: RunFolder) -> str:
    """Returns the page of a run: one file that asks nothing of any other place."""
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True)
    environment.filters["data"] = environment.filters["tojson"]
    environment.globals |= {"explained": explained, "most": MOST_ROWS}
    template = environment.from_string(files(_HERE).joinpath("page.html").read_text("utf-8"))
    settings = report.settings
    if settings is None:
        settings = {
            name: one for name, one in report.result.items() if not isinstance(one, dict | list)
        }
    content = {
        "heading": report.heading,
        "lead": f"{report.about} · activesuit {__version__}",
        "tables": [_table(title, *rows) for title, rows in report.tables.items()],
        "answer": [*report.answer],
        "figures": [_figure(plot) for plot in report.plots.values()],
        "pictures": {name: _source(one) for name, one in report.pictures.items()},
        "origin": [
            _table("Options", ["option", "value"], _flat(settings)),
            _table("Versions", ["package", "version"], _versions()),
            _table("Files of data beside this page", ["file", "SHA-256"], _hashes(folder)),
        ],
    }
    plotly = _plotly() if report.plots else ""
    return template.render(**_visible(content), plotly=plotly)


def _list(report: Report) -> str:
    names = ["result.json", *report.columns, *(f"{one}.png" for one in report.plots)]
    names += [f"{one}.png" for one in report.pictures]
    return ", ".join(names)


def _figure(plot: Plot) -> dict[str, Any]:
    kinds = {"solid": "solid", "dash": "dashed", "dot": "dotted"}
    legend = {name: (color, kinds[dash]) for name, (color, dash) in plot.styles().items()}
    shown = {"title": plot.title, "columns": plot.columns}
    return {**shown, "panels": plot.plotly(), "legend": legend}


def _table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[Any]:
    """Returns a table for the page, with which of its columns hold words."""
    rows = [*rows]
    return [title, header, rows, columns_of_words(header, rows)]


@cache
def _plotly() -> str:
    """Returns the script of plotly, compressed: it is three quarters of a page otherwise."""
    import plotly

    script = files(plotly).joinpath("package_data", "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, mtime=0)).decode()


def _source(picture: Any) -> str:
    """Returns a picture as the source of an image: a drawing as PNG, pixels as JPEG."""
    content, kind = io.BytesIO(), "png" if hasattr(picture, "savefig") else "jpeg"
    if kind == "png":
        picture.savefig(content, format=kind, dpi=DPI)
    else:
        from matplotlib.image import imsave

        imsave(content, picture, format=kind)
    return f"data:image/{kind};base64,{base64.b64encode(content.getvalue()).decode()}"


def _flat(settings: Mapping[str, Any], prefix: str = "") -> list[list[str]]:
    """Returns options as rows of name and value, those inside others as outer.inner."""
    rows = []
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            rows += _flat(value, f"{prefix}{name}.")
        else:
            text = "-" if value is None else value if isinstance(value, str) else None
            plain = json_module.loads(to_json(value)) if text is None else None
            rows.append([f"{prefix}{name}", text or json_module.dumps(plain, ensure_ascii=False)])
    return rows


def _versions() -> list[list[str]]:
    found = {"activesuit": __version__, "python": platform.python_version()}
    return [*map(list, (found | {name: version(name) for name in PACKAGES}).items())]


def _hashes(folder: RunFolder) -> list[list[str]]:
    """Returns name and SHA-256 of each file of data in a run folder, in the order of names."""
    return [
        [path.name, hashlib.sha256(path.read_bytes()).hexdigest()]
        for path in sorted(folder.path.iterdir())
        if path.suffix in DATA and path.is_file() and not path.is_symlink()
    ]


def _visible(value: Any) -> Any:
    """Returns a value whose texts show their control characters."""
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, Mapping):
        return {_visible(key): _visible(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_visible(one) for one in value]
    return value
