"""What arms score that are hindered: frozen at their mean posture, locked, or thrown about.

Each succeeds in no task that moves the arm; a limit that one of them meets would mean nothing.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..envs.evaluation import FIRST_SEED
from ..envs.evaluation.run import run
from ..envs.plant import Plant
from ..envs.tasks import TASKS
from ..scripts.output import progress
from ..tables import Rows

SUIT, MOTIONS = "mock-suit", 8
BEGIN = 30  # control periods before a throw
STIFF = 1000.0  # N·m/rad


class Locked:
    """Holds the first posture with all the torque that the motors have."""

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self._first: Array | None = None

    def reset(self) -> None:
        """Forgets the first posture."""
        self._first = None

    def act(self, observation: NDArray[np.float32]) -> Array:
        """Returns the torque that leads back to the first posture."""
        angle = observation[:, self.plant.layout["angle"]].astype(float)[:, self.plant.assisted]
        self._first = angle if self._first is None else self._first
        return np.clip(STIFF * (self._first - angle) / self.plant.peak, -1, 1)


class Thrown:
    """Throws the arm up with all the torque that the motors have."""

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)
    way: ClassVar[float] = 1.0

    def __init__(self, plant: Plant) -> None:
        self.plant, self._period = plant, 0

    def reset(self) -> None:
        """Waits again."""
        self._period = 0

    def act(self, observation: NDArray[np.float32]) -> Array:
        """Returns the greatest torque after a short while."""
        self._period += 1
        torque = self.way * (self._period > BEGIN)
        return np.full((len(observation), self.plant.motors), torque)


class Dropped(Thrown):
    """Throws the arm down."""

    way = -1.0


HINDERED = {"locked": Locked, "thrown up": Thrown, "thrown down": Dropped}


@dataclass(frozen=True, kw_only=True)
class Hindered:
    """What hindered arms reach in a task.

    Attributes:
        task: Name of the task.
        tracking: Limit of the worst joint's tracking error [rad].
        frozen: Least error of the worst joint if it stayed at its mean angle [rad].
        success: Share of motions that succeed, by the name of what hinders.
        effort: Mean effort over strength, likewise.
    """

    task: str
    tracking: float
    frozen: float
    success: dict[str, float]
    effort: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def hindered(tasks: Sequence[str] = tuple(TASKS), motions: int = MOTIONS) -> list[Hindered]:
    """Evaluates hindered arms, which have no weight that a throw up could lift."""
    found = []
    with progress("hindering", len(tasks) * len(HINDERED)) as bar:
        for task in tasks:
            runs = {}
            for name, policy in HINDERED.items():
                runs[name] = run(
                    name,
                    policy,
                    f"ActiveSuit/{task}-v0",
                    range(FIRST_SEED, FIRST_SEED + motions),
                    suit=SUIT,
                    gravity="microgravity",
                    threads=0,
                )
                bar.advance()
            moved = [trace.target_angle.std(axis=0).max() for trace in runs["locked"].traces]
            scores = {name: one.score for name, one in runs.items()}
            found.append(
                Hindered(
                    task=task,
                    tracking=TASKS[task].tracking,
                    frozen=float(min(moved)),
                    success={name: float(np.mean(one.success)) for name, one in scores.items()},
                    effort={name: float(np.mean(one.effort)) for name, one in scores.items()},
                )
            )
    return found


def hindered_table(found: Sequence[Hindered]) -> Rows:
    """Returns the table: header and rows."""
    header = ["task", "limit of the\nworst joint [mrad]", "frozen at its\nmean [mrad]"]
    header += [f"{name}:\nsuccess, effort" for name in HINDERED]
    rows = []
    for one in found:
        cells = [f"{one.success[name]:.0%}, {one.effort[name]:.0%}" for name in HINDERED]
        rows.append([one.task, f"{1e3 * one.tracking:.0f}", f"{1e3 * one.frozen:.0f}", *cells])
    return header, rows
