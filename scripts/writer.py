"""The end of a command: prints its result, and writes files and a page into a folder."""

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
from .folders import RunFolder, to_json
from .output import table

PACKAGES = ("mujoco", "numpy", "scipy", "numba", "gymnasium")
PAGE, RESULT = "report.html", "result.json"
DATA = (".json", ".jsonl", ".csv", ".safetensors")
MOST_ROWS = 500  # of a table of a page
DPI = 140
MEANINGS = {  # of columns of tables whose names alone are not clear
    "relief, 95 % interval": "share of the suit's cost in effort that is given back",
    "of the bound": "relief over the relief of the best known plan, which knows the whole motion",
    "went well": "share of motions within all limits of success",
    "late by [ms]": "delay of the believed torque behind the true torque",
    "RMS of the peak [%]": "root mean square of the error over the largest true torque",
    "over fit noise": "root mean square of the error over the residual of the fit",
    "smoothness SPARC": "spectral arc length, nearer to 0 is smoother",
    "hand SPARC": "spectral arc length of the hand's motion, nearer to 0 is smoother",
    "predicts: NRMSE": "error on data left out of the fit, over the largest torque",
    "fits: NRMSE": "error on the fitted data, over the largest torque",
    "weight in band": "share of the model in the band and the samples over kinds of model",
    "starts that agree": "number of starts of the fit that ended at this model",
}
_HERE = __name__.rpartition(".")[0]


@dataclass(frozen=True, kw_only=True)
class Report:
    """Result of a command.

    Attributes:
        heading: Title of the page.
        about: Subject of the command: a file, or task, place and suit.
        result: Plain values, which result.json and --json hold.
        tables: Header and rows of tables, by title; the first table is the answer.
        answer: Sentences, the most important sentence first.
        columns: Header and rows of CSV files, by name.
        plots: Figures, by the name of the file without its suffix.
        pictures: Figures of matplotlib that are no plots, or pixels (height, width, 3), by name.
        settings: Options of the run; by default the plain values of the result.
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
        """Returns the report of a result that has methods for the parts of a report.

        These are `to_dict`, `tables`, `sentences` and perhaps `columns`, `plots` and `pictures`.
        `more` has attributes of the report in place of the parts of the result.
        """
        parts = {"result": "to_dict", "tables": "tables", "answer": "sentences"}
        parts |= {name: name for name in ("columns", "plots", "pictures") if hasattr(found, name)}
        given = {name: getattr(found, of)() for name, of in parts.items() if name not in more}
        return cls(heading=heading, about=about, **given, **more)


def conclude(report: Report, folder: RunFolder | None, json: bool = False) -> None:
    """Prints a report, as JSON or as tables and sentences; writes the report into a folder."""
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
        names = [RESULT, *report.columns]
        names += [f"{one}.png" for one in (*report.plots, *report.pictures)]
        say(f"wrote {folder.path}: {PAGE} has everything, {', '.join(names)} the parts")


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
    """Returns the page of a run: one file of HTML that loads no other file."""
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True)
    environment.filters["data"] = environment.filters["tojson"]
    environment.globals |= {"explained": explained, "most": MOST_ROWS}
    template = environment.from_string(files(_HERE).joinpath("page.html").read_text("utf-8"))
    plain = {name: one for name, one in report.result.items() if not isinstance(one, dict | list)}
    settings = plain if report.settings is None else report.settings
    versions = {"activesuit": __version__, "python": platform.python_version()}
    versions |= {name: version(name) for name in PACKAGES}
    content = {
        "heading": report.heading,
        "lead": f"{report.about} · activesuit {__version__}",
        "tables": [_table(title, *rows) for title, rows in report.tables.items()],
        "answer": [*report.answer],
        "figures": [_figure(plot) for plot in report.plots.values()],
        "pictures": {name: _source(one) for name, one in report.pictures.items()},
        "origin": [
            _table("Options", ["option", "value"], _flat(settings)),
            _table("Versions", ["package", "version"], [*map(list, versions.items())]),
            _table("Data files of the run", ["file", "SHA-256"], _hashes(folder)),
        ],
    }
    plotly = _plotly() if report.plots else ""
    return template.render(**_visible(content), plotly=plotly)


def explained(header: Sequence[str]) -> str:
    """Returns the meanings of the columns of a table whose names alone are not clear."""
    names = [" ".join(name.split()) for name in header]
    return "; ".join(f"{name}: {MEANINGS[name]}" for name in names if name in MEANINGS)


def _figure(plot: Plot) -> dict[str, Any]:
    kinds = {"solid": "solid", "dash": "dashed", "dot": "dotted"}
    legend = {name: (color, kinds[dash]) for name, (color, dash) in plot.styles().items()}
    shown = {"title": plot.title, "columns": plot.columns}
    return {**shown, "panels": plot.plotly(), "legend": legend}


def _table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[Any]:
    """Returns a table for the page, and for each column whether the column holds words."""
    rows = [*rows]
    return [title, header, rows, columns_of_words(header, rows)]


@cache
def _plotly() -> str:
    """Returns the script of plotly, compressed: uncompressed it takes three quarters of a page."""
    import plotly

    script = files(plotly).joinpath("package_data", "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, mtime=0)).decode()


def _source(picture: Any) -> str:
    """Returns a picture as the source of an image: a figure as PNG, pixels as JPEG."""
    content, kind = io.BytesIO(), "png" if hasattr(picture, "savefig") else "jpeg"
    if kind == "png":
        picture.savefig(content, format=kind, dpi=DPI)
    else:
        from matplotlib.image import imsave

        imsave(content, picture, format=kind)
    return f"data:image/{kind};base64,{base64.b64encode(content.getvalue()).decode()}"


def _flat(settings: Mapping[str, Any], prefix: str = "") -> list[list[str]]:
    """Returns options as rows of name and value; a nested option has the name outer.inner."""
    rows = []
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            rows += _flat(value, f"{prefix}{name}.")
            continue
        text = "-" if value is None else value
        if not isinstance(text, str) or not text:
            text = json_module.dumps(json_module.loads(to_json(value)), ensure_ascii=False)
        rows.append([f"{prefix}{name}", text])
    return rows


def _hashes(folder: RunFolder) -> list[list[str]]:
    """Returns name and SHA-256 of each file of data in a run folder, in the order of names."""
    return [
        [path.name, hashlib.sha256(path.read_bytes()).hexdigest()]
        for path in sorted(folder.path.iterdir())
        if path.suffix in DATA and path.is_file() and not path.is_symlink()
    ]


def _visible(value: Any) -> Any:
    """Returns a value with visible control characters in its texts."""
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, Mapping):
        return {_visible(key): _visible(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_visible(one) for one in value]
    return value
