"""Shovelling: a load on the way up only, and none on the way down."""

import math
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from ..model.workplace import CARRIED, draw, grip, holder
from ..simulation.kinematics import Arm
from ..simulation.plan import Plan
from .motions import between, posture, repeated, through
from .task import SUSTAINED, Task, check_range

LEVEL = math.pi / 2  # rad, pitch of a hand that points forward
DOWN, UP = (posture(shoulder, LEVEL - shoulder) for shoulder in (0.4, 1.02))
LIFT, PAUSE, LOWER = 1.2, 0.3, 1.2  # s


@dataclass(frozen=True, kw_only=True)
class Scoop(Task):
    """The arm lifts a level scoop full of soil forward and lowers it empty, every three seconds.

    Attributes:
        load: Least and greatest mass of the soil [kg]; each scoop has another one.
    """

    load: tuple[float, float] = (2.0, 5.0)

    source: ClassVar[str] = "sampling on Apollo and IST-2; 3 s and 2 to 5 kg assumed"
    place: ClassVar[str] = "moon"
    carries: ClassVar[bool] = True
    period: ClassVar[float | None] = 2 * PAUSE + LIFT + LOWER

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("the task's load", self.load, " kg")

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the scoop, and the soil while there is some."""
        at, body = grip(spec).pos, holder(spec)
        box = mujoco.mjtGeom.mjGEOM_BOX
        draw(
            body, box, "exo_steel", pos=at + np.array([-0.03, 0, -0.12]), size=[0.003, 0.055, 0.08]
        )
        for across in (-0.055, 0.055):
            side = at + np.array([-0.015, across, -0.12])
            draw(body, box, "exo_steel", pos=side, size=[0.018, 0.003, 0.08])
        draw(
            body,
            mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            "rubber",
            pos=at + np.array([-0.015, 0, -0.125]),
            size=[0.032, 0.048, 0.068],
            name=f"{CARRIED}_soil",
        )

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns lifts and descents; place and tilt are watched while there is a load."""
        del arm
        cycle = [(0.0, DOWN), (PAUSE, DOWN), (PAUSE + LIFT, UP), (2 * PAUSE + LIFT, UP)]
        stops = repeated(cycle, 2 * PAUSE + LIFT + LOWER, samples * dt)
        mass, time = np.zeros(samples), dt * np.arange(samples)
        windows = []
        for start, _ in stops[:: len(cycle)]:
            full, empty = start + PAUSE / 2, start + PAUSE + LIFT + PAUSE / 2
            mass[(full <= time) & (time < empty)] = rng.uniform(*self.load)
            windows.append((full + dt, empty - dt))
        return Plan(through(stops, samples, dt), mass, watched=between(windows, samples, dt))


SCOOP = Scoop(name="Scoop", duration=30.0, effort=SUSTAINED, tracking=0.1, hand_error=0.1, tilt=0.2)
"""Ten scoops; the hand tilts by at most 0.2 rad more or less than intended while it is loaded."""
