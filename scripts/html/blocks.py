"""The parts of a report, which hold data and no HTML."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A figure that plotly draws.

    Attributes:
        title: Caption.
        text: What it shows, for who cannot see it.
        data: Traces of plotly; names in them are escaped by `charts.label`.
        layout: Layout of plotly.
    """

    title: str
    text: str
    data: list[dict[str, Any]]
    layout: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG file of the run folder.

    Attributes:
        name: Name of the file.
        title: Caption.
        instead: Whether it stands for charts, on a page without plotly.
    """

    name: str
    title: str
    instead: bool = False


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table.

    Attributes:
        title: Caption.
        header: Names of the columns.
        rows: Cells; a line break in one stays.
    """

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, kw_only=True)
class Loop:
    """Torques over the angle of a joint during a motion.

    Attributes:
        joint: Name of the joint.
        angle: Angle [rad], shape (samples,).
        torques: Torques [N·m] by what they are, shape (samples,) each.
    """

    joint: str
    angle: Array
    torques: dict[str, Array]


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A motion of the arm with its loops.

    Attributes:
        name: Policy, and what was simulated.
        time: Time [s], shape (samples,).
        frames: Samples of the pictures, shape (pictures,).
        places: Places of the four joints and the grip in the world [m], shape (pictures, 5, 3).
        intended: The same places as intended.
        body: Places of shoulder, neck, hip and the middle of the head [m], shape (4, 3).
        loops: Loops of the joints with motors.
    """

    name: str
    time: Array
    frames: NDArray[np.intp]
    places: Array
    intended: Array
    body: Array
    loops: list[Loop]


@dataclass(frozen=True, kw_only=True)
class Player:
    """Motions that one slider shows, arm and loops together; a list chooses one of them."""

    title: str
    motions: list[Motion]


Block = Chart | Picture | Table | Player


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the page with a heading.

    Attributes:
        title: Heading.
        sentences: Sentences below it.
        blocks: Figures and tables.
    """

    title: str
    sentences: Sequence[str] = ()
    blocks: Sequence[Block] = field(default_factory=list)
