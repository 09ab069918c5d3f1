"""Which columns of a table are time, angle and torque, and in which units."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from ...errors import InputError, unknown_name
from ...table_files import Cells, Table
from ...units import UNITS, Unit, is_unit, unit_of

# Names in headers, without unit and case; `_` counts as a space.
NAMES = {
    "angle": {
        *("angle", "ang", "joint angle", "angular position", "position", "pos", "rotation"),
        *("theta", "phi", "q", "winkel", "drehwinkel", "gelenkwinkel"),
    },
    "torque": {
        *("torque", "trq", "tq", "moment", "joint torque", "joint moment", "tau"),
        *("drehmoment", "gelenkmoment"),
    },
    "time": {"time", "t", "abs time", "elapsed time", "timestamp", "zeit", "messzeit"},
}
NEEDED = ("angle", "torque")
WORDS = ("curve", "role", "weight")  # columns without a unit, known by exactly these names
COLUMNS = (*NAMES, *WORDS)
USUAL = {"time": "s"}  # units that need not be named
BEHIND = (  # forms of a name with its unit
    r"(.*?)\s*[\[(<]([^\])>]*)[\])>]",
    r"(.*?)\s*/\s*(\S+)",
    r"(.*?)(?:\s+in\s+|,\s*|\s+)(\S+)",
)


class Column(NamedTuple):
    """A column of a table: its place, its name in the header, and its unit, if it has one."""

    at: int
    name: str
    unit: Unit = Unit("", 1.0)


class Wanted(NamedTuple):
    """Columns and units that a caller names; others follow from usual names and the header."""

    columns: Mapping[str, str]  # name in the header or number from 1 on, by kind
    units: Mapping[str, str]  # by "angle", "torque" and "time"

    def check(self) -> None:
        """Checks names and units."""
        for name in self.columns:
            if name not in COLUMNS:
                raise unknown_name("kind of column", name, COLUMNS)
        for name, unit in self.units.items():
            if name not in UNITS:
                raise unknown_name("quantity with a unit", name, UNITS)
            unit_of(unit, name)

    @property
    def by_number(self) -> bool:
        """Whether the columns are named by their numbers, as for a file without a header."""
        return all(self.columns.get(one, "").isdecimal() for one in NEEDED)

    def is_header(self, cells: Cells) -> bool:
        """Returns whether cells are names of columns, with an angle and a torque among them."""
        found = [_candidates(cells, one, self) for one in NEEDED]
        return all(found) and all(_candidates(cells, one, self) for one in self.columns)


def columns_of(table: Table, wanted: Wanted) -> dict[str, Column]:
    """Returns the columns of a table by their kind; angle and torque always."""
    found = {}
    for kind in COLUMNS:
        places = _candidates(table.header, kind, wanted)
        if not places:
            continue
        names = [table.header[i] for i in places]
        if len(places) > 1:
            if len({*names}) == 1:
                raise InputError(f"{table.path} has the column {names[0]!r} twice: keep one")
            raise InputError(
                f"{table.path} has {len(names)} columns for the {kind}, "
                f"{' and '.join(map(repr, names))}: name one of them, as {kind}={names[0]!r}"
            )
        unit = {} if kind in WORDS else {"unit": _unit(table, kind, places[0], wanted)}
        found[kind] = Column(places[0], names[0], **unit)
    for kind in wanted.columns:
        if kind not in found:
            raise unknown_name(f"column of {table.path}", wanted.columns[kind], table.header)
    return found


def described(table: Table, columns: Mapping[str, Column]) -> Iterator[str]:
    """Yields phrases on how a table was read; none for a file in the format of ActiveSuit."""
    yield from table.dialect
    names = {column.name for column in columns.values()}
    if not names <= {"angle_rad", "angle_deg", "torque_nm", "time_s", *WORDS}:
        for kind, column in columns.items():
            unit = f" in {column.unit.name}" if column.unit.name else ""
            yield f"{kind} from {column.name!r}{unit}"
    used = {column.at for column in columns.values()}
    left = [repr(name) for i, name in enumerate(table.header) if i not in used]
    if left:
        yield f"{', '.join(left)} left out"


def _candidates(header: Sequence[str], kind: str, wanted: Wanted) -> list[int]:
    """Returns the places of the columns that may be of a kind."""
    name = wanted.columns.get(kind)
    if name is not None:
        places = [i for i, cell in enumerate(header) if cell == name.strip()]
        at = int(name) - 1 if name.isdecimal() else -1
        return places or ([at] if 0 <= at < len(header) else [])
    taken = {*wanted.columns.values()}
    if kind in WORDS:
        return [i for i, cell in enumerate(header) if cell == kind and cell not in taken]
    return [
        i
        for i, cell in enumerate(header)
        if cell not in taken
        and any(
            name in NAMES[kind] and (not unit or is_unit(unit, kind))
            for name, unit in _readings(cell)
        )
    ]


def _readings(cell: str) -> Iterator[tuple[str, str]]:
    """Yields all pairs of name and unit that a cell of a header may mean."""
    plain = cell.casefold().lstrip("#% ")
    yield plain.replace("_", " "), ""
    for form in BEHIND:
        match = re.fullmatch(form, plain)
        if match:
            yield match[1].replace("_", " ").strip(), match[2]
    parts = plain.split("_")
    for i in range(1, len(parts)):
        yield " ".join(parts[:i]), "_".join(parts[i:])


def _unit(table: Table, kind: str, at: int, wanted: Wanted) -> Unit:
    """Returns the unit of a column."""
    name = table.header[at]
    if kind in wanted.units:
        return unit_of(wanted.units[kind], kind)
    inside = next((unit for _, unit in _readings(name) if is_unit(unit, kind)), "")
    below = table.units[at].strip("[]()<> ") if at < len(table.units) else ""
    text = inside or below or USUAL.get(kind, "")
    if not text:
        raise InputError(
            f"{table.path}: the column {name!r} names no unit: give it, as {kind}="
            f"{'deg' if kind == 'angle' else 'Nm'} among the units"
        )
    unit = unit_of(text, kind)
    if inside and below and unit_of(below, kind).factor != unit.factor:
        raise InputError(
            f"{table.path}: the column {name!r} is in {inside} by its name and in {below} by the "
            f"row of units: give the right one, as {kind}={inside} among the units"
        )
    return unit
