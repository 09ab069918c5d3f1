"""Builds the page: sections become HTML here, and every text of a run is escaped here."""

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

from ...errors import InputError, install_line
from ...files import content_of
from ..text import visible
from .blocks import Chart, Picture, Player, Section, Table
from .columns import explained
from .player import player_parts

PLOTLY = ("package_data", "plotly.min.js")  # in the folder of the package plotly
NO_PLOTLY = (
    "Figures are still pictures here, because plotly was not installed when this page was made: "
    f"{install_line('report')} in the clone of the repository, then run the command again."
)
# The page takes nothing from anywhere: a browser that reads this refuses what would.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; base-uri 'none'; form-action 'none'"
)
NUMBER = re.compile(r"[-+−]?\d[\d,]*\.?\d*(e[-+]?\d+)?(?![\w-])")
LARGEST_PICTURE = 16 * 2**20  # bytes
MOST_ROWS = 500  # of a table


def plotly_source() -> str | None:
    """Returns the script of plotly; None if the package is not installed."""
    spec = find_spec("plotly")
    if spec is None or spec.origin is None:
        return None
    path = Path(spec.origin).parent.joinpath(*PLOTLY)
    return path.read_text(encoding="utf-8") if path.is_file() else None


def build(folder: Path, title: str, lead: str, sections: Sequence[Section]) -> str:
    """Returns the page of a run.

    Args:
        folder: The run folder, whose pictures the page holds.
        title: Title of the page.
        lead: Line below the title.
        sections: Parts of the page.
    """
    charted = any(isinstance(block, Chart) for one in sections for block in one.blocks)
    plotly = plotly_source() if charted else None
    renderer = _Renderer(folder, drawn=plotly is not None)
    shown = [(one.title, content) for one in sections if (content := renderer.section(one))]
    parts = [
        f'<section id="s{i}" aria-labelledby="h{i}"><h2 id="h{i}">{text(title)}</h2>\n{content}'
        "</section>"
        for i, (title, content) in enumerate(shown)
    ]
    links = "".join(
        f'<li><a href="#s{i}">{text(title)}</a></li>' for i, (title, _) in enumerate(shown)
    )
    note = f'<p class="note">{text(NO_PLOTLY)}</p>' if charted and plotly is None else ""
    scripts = "".join(
        f"<script>{_inside_script(source)}</script>\n"
        for source in (plotly, _own("report.js"))
        if source
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{text(title)}</title>\n<style>\n{_own('report.css')}</style>\n</head>\n<body>\n"
        f'<a class="skip" href="#main">Skip to the results</a>\n'
        f"<header><h1>{text(title)}</h1><p>{text(lead)}</p>"
        f'<nav aria-label="Sections"><ul>{links}</ul></nav></header>\n'
        f'<main id="main" tabindex="-1">\n{note}\n' + "\n".join(parts) + "\n</main>\n"
        f"{scripts}</body>\n</html>\n"
    )


def text(value: str) -> str:
    """Returns a text as HTML that shows it as it is, control characters included."""
    return escape(visible(value))


def data_script(data: Any) -> str:
    """Returns data as JSON in a script element that runs nothing and that no text can end."""
    content = json.dumps(data, allow_nan=False, separators=(",", ":"))  # ASCII only
    for char in "<>&":
        content = content.replace(char, f"\\u{ord(char):04x}")
    return f'<script type="application/json">{content}</script>'


def flat(settings: Mapping[str, Any], prefix: str = "") -> list[list[str]]:
    """Returns options as rows of name and value, those inside others as outer.inner."""
    rows = []
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            rows += flat(value, f"{prefix}{name}.")
        else:
            rows.append([f"{prefix}{name}", _value(value)])
    return rows


def hashes(folder: Path) -> list[list[str]]:
    """Returns name and SHA-256 of each file of data in a run folder, in the order of names."""
    return [
        [path.name, hashlib.sha256(path.read_bytes()).hexdigest()]
        for path in sorted(folder.iterdir())
        if path.suffix in (".json", ".jsonl", ".csv", ".safetensors")
        and path.is_file()
        and not path.is_symlink()
    ]


class _Renderer:
    """Turns sections into HTML.

    Args:
        folder: The run folder.
        drawn: Whether plotly draws the charts.
    """

    def __init__(self, folder: Path, drawn: bool) -> None:
        self._folder, self._drawn, self._numbers = folder, drawn, count()

    def section(self, section: Section) -> str:
        """Returns what is below the heading of a section; nothing if all of it is missing."""
        parts = [f"<p>{_lines(sentence)}</p>" for sentence in section.sentences]
        for block in section.blocks:
            match block:
                case Chart():
                    parts.append(self._chart(block))
                case Picture():
                    parts.append(self._picture(block))
                case Player():
                    parts.append(self._player(block))
                case Table():
                    parts.append(self._table(block))
        return "\n".join(filter(None, parts))

    def _chart(self, chart: Chart) -> str:
        if not self._drawn:
            return ""
        figure = {"data": chart.data, "layout": chart.layout}
        return (
            f'<figure class="chart"><figcaption>{text(chart.title)}</figcaption>'
            f'<div class="plot" role="img" aria-label="{text(chart.text)}" '
            f'style="height:{int(chart.layout["height"])}px"></div>{data_script(figure)}</figure>'
        )

    def _picture(self, picture: Picture) -> str:
        path = self._folder / picture.name
        if Path(picture.name).name != picture.name or (picture.instead and self._drawn):
            return ""
        if path.is_symlink() or not path.is_file():
            return ""
        content = base64.b64encode(content_of(path, "picture", LARGEST_PICTURE)).decode()
        return (
            f"<figure><figcaption>{text(picture.title)}</figcaption>"
            f'<img alt="{text(picture.title)}, as {text(picture.name)}" '
            f'src="data:image/png;base64,{content}"></figure>'
        )

    def _player(self, player: Player) -> str:
        number = next(self._numbers)
        pictures, data = player_parts(player.motions)
        last = len(data["motions"][0]["time"]) - 1
        options = "".join(
            f'<option value="{i}">{text(one.name)}</option>' for i, one in enumerate(player.motions)
        )
        return (
            f'<figure class="player"><figcaption>{text(player.title)}</figcaption>'
            '<div class="controls">'
            f'<label for="motion{number}">motion</label>'
            f'<select id="motion{number}">{options}</select>'
            '<button type="button" class="play">Play</button>'
            f'<label for="time{number}">time</label>'
            f'<input id="time{number}" type="range" min="0" max="{last}" value="0" step="1">'
            f'<output for="time{number}">0.00 s</output></div>'
            f'<div class="pictures">{pictures}</div>{data_script(data)}</figure>'
        )

    def _table(self, table: Table) -> str:
        if not table.rows:
            return ""
        caption = text(table.title)
        rows = table.rows[:MOST_ROWS]
        left = [not _numeric([row[i] for row in rows if i < len(row)])
                for i in range(len(table.header))]  # fmt: skip
        sortable = len(rows) > 1
        head = "".join(
            f'<th scope="col"{_side(left[i])}>'
            + (f'<button type="button">{_lines(name)}</button>' if sortable and name else "")
            + ("" if sortable and name else _lines(name))
            + "</th>"
            for i, name in enumerate(table.header)
        )
        body = "".join(
            "<tr>"
            + "".join(
                f'<th scope="row"{_side(left[i])}>{_lines(cell)}</th>'
                if i == 0
                else f"<td{_side(left[i])}>{_lines(cell)}</td>"
                for i, cell in enumerate(row[: len(left)])
            )
            + "</tr>"
            for row in rows
        )
        more = len(table.rows) - len(rows)
        note = f"<p>{more} more rows are in the files of the run.</p>" if more else ""
        if meaning := explained(table.header):
            note += f"<p>{text(meaning)}.</p>"
        kind = ' class="sortable"' if sortable else ""
        return (
            f'<div class="scroll" role="region" tabindex="0" aria-label="{caption}">'
            f"<table{kind}><caption>{caption}</caption>"
            f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{note}"
        )


def _side(left: bool) -> str:
    return ' class="left"' if left else ""


def _numeric(cells: Sequence[str]) -> bool:
    """Returns whether the cells of a column are numbers, most of them beginning with one."""
    known = [cell for cell in cells if cell.strip() not in ("", "-")]
    return bool(known) and all(NUMBER.match(cell.strip()) for cell in known)


def _lines(value: str) -> str:
    return text(value).replace("\n", "<br>")


def _value(value: Any) -> str:
    if value is None:
        return "-"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _own(name: str) -> str:
    return files(__name__.rpartition(".")[0]).joinpath(name).read_text(encoding="utf-8")


def _inside_script(source: str) -> str:
    """Returns a script that is about to stand inside a page."""
    if re.search("</script|<!--", source, re.IGNORECASE):
        raise InputError("this version of plotly cannot stand in a page: install another one")
    return source
