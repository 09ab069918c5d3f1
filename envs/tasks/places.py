"""Hands that go from place to place: along a panel, with objects, and along a rail."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from mujoco import mjtGeom

from ...arrays import Array
from ..model.workplace import (
    CARRIED,
    add_pushes,
    draw,
    draw_bar,
    grip,
    holder,
    place_of,
    straight_arm,
)
from ..provenance import setting
from ..simulation.episode_plan import Plan
from ..simulation.kinematics import Arm, through_places
from .motions import between, minimum_jerk, posture, repeated, through
from .task import LONGEST, SUSTAINED, Task

BOX, CAPSULE = mjtGeom.mjGEOM_BOX, mjtGeom.mjGEOM_CAPSULE
CYLINDER = mjtGeom.mjGEOM_CYLINDER
# Points of the panel relative to the shoulder, forward, outward and up, in lengths of the straight
# arm to its grip: two columns of four, which shoulder and elbow reach within their measured ranges.
PANEL = np.array(
    [(0.80, across, up) for across in (0.0, 0.12) for up in (-0.48, -0.37, -0.26, -0.15)]
)
BENT = posture(0.6, 1.2)  # start of the search for a posture of the first point
REACH, DWELL = 1.5, 0.5  # s
CARRY, GRASP, RETURN = 2.0, 0.5, 1.5  # s
LOW, HIGH = 4, 3  # points between which an object is carried
BLOCK_SIZE = 0.05  # m, half of its edge
BEHIND, RIM = 0.1, 0.09  # [m], extent of the drawn panel behind and around its points


@dataclass(frozen=True, kw_only=True)
class ReachPanel(Task):
    """Straight reaches to random points of a panel, with half a second at each."""

    source: ClassVar[str] = (
        "Anderson and Newman 2015 (12 repeats, functional tasks); MVL work envelope; points assumed"
    )
    place: ClassVar[str] = "moon"

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the panel with its points."""
        draw_panel(spec, range(len(PANEL)))

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns reaches from point to point; the rests there are watched."""
        legs = int(np.ceil(samples * dt / (REACH + DWELL))) + 1
        points = [int(rng.integers(len(PANEL)))]
        while len(points) <= legs:
            other = int(rng.integers(len(PANEL) - 1))
            points.append(other + (other >= points[-1]))
        stops, windows, now = [], [], 0.0
        for point in points:
            place = arm.length * PANEL[point]
            stops += [(now, place), (now + DWELL, place)]
            windows.append((now, now + DWELL))
            now += DWELL + REACH
        motion = through_places(arm, through(stops, samples, dt)[0], BENT, dt)
        return Plan(motion, watched=between(windows, samples, dt))


@dataclass(frozen=True, kw_only=True)
class ObjectRelocation(Task):
    """An object is taken from a low place, carried to a high one, and left there, again and again.

    Attributes:
        load: Least and greatest mass of an object [kg], drawn anew in each cycle; the exoskeleton
            does not know the mass.
    """

    load: tuple[float, float] = setting((1.0, 5.0), "kg", 0, LONGEST)

    source: ClassVar[str] = "LSDA 13587 (upper-body object relocation); 1 to 5 kg assumed"
    place: ClassVar[str] = "moon"
    carries: ClassVar[bool] = True

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws two shelves, and the object in the hand while there is one."""
        draw_panel(spec, (LOW, HIGH))
        edge = BLOCK_SIZE
        place, name = grip(spec).pos - np.array([0, 0, edge]), f"{CARRIED}_block"
        draw(holder(spec), BOX, "exo_accent", pos=place, size=[edge] * 3, name=name)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns cycles of grasp, carry, release and return; arrivals are watched."""
        low, high = (arm.length * PANEL[point] for point in (LOW, HIGH))
        period = 2 * GRASP + CARRY + RETURN
        away = GRASP + CARRY
        cycle = [(0.0, low), (GRASP, low), (away, high), (away + GRASP, high)]
        stops = repeated(cycle, period, samples * dt)
        starts = [time for time, _ in stops[:: len(cycle)]]
        windows = [(t, t + GRASP / 2 - dt) for start in starts for t in (start, start + away)]
        mass, time = np.zeros(samples), dt * np.arange(samples)
        for start in starts:
            carried = (start + GRASP / 2 <= time) & (time < start + away + GRASP / 2)
            mass[carried] = rng.uniform(*self.load)
        motion = through_places(arm, through(stops, samples, dt)[0], BENT, dt)
        return Plan(motion, mass, watched=between(windows, samples, dt))


def draw_panel(spec: mujoco.MjSpec, points: Sequence[int]) -> None:
    """Draws an open frame in front of the right shoulder, with buttons at some of its points."""
    torso = spec.body("torso")
    places = spec.body("shoulder").pos + straight_arm(spec) * PANEL * np.array([1, -1, 1])
    places = places + np.array([BEHIND, 0, 0])
    low, high = places.min(axis=0) - RIM, places.max(axis=0) + RIM
    x = places[0, 0]
    corners = [(low[1], low[2]), (high[1], low[2]), (high[1], high[2]), (low[1], high[2])]
    for (y, z), (next_y, next_z) in zip(corners, [*corners[1:], corners[0]], strict=True):
        draw_bar(torso, CAPSULE, "bearing", 0.012, [x, y, z], [x, next_y, next_z])
    for point in points:
        y, z = places[point, 1:]
        draw_bar(torso, CAPSULE, "bearing", 0.005, [x, low[1], z], [x, high[1], z])
        draw_bar(torso, CYLINDER, "exo_accent", 0.02, [x - 0.018, y, z], [x + 0.018, y, z])


REACH_PANEL = ReachPanel(
    name="ReachPanel", duration=24.0, effort=SUSTAINED, tracking=0.1, hand_error=0.02
)
"""Twelve reaches; the hand stays within 2 cm of each point for half a second."""

OBJECT_RELOCATION = ObjectRelocation(
    name="ObjectRelocation", duration=27.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03
)
"""Six objects, each placed in time and within 3 cm."""


FAR, NEAR = posture(1.1, 0.6), posture(0.45, 1.4)  # postures at the grip and at the release
GRIP = 2.0  # [s], grip of one hand
RISE = 0.3  # [s], rise and fall of the pull


@dataclass(frozen=True, kw_only=True)
class Handrail(Task):
    """The hand pulls along a straight rail for two seconds, and reaches out again for two.

    Attributes:
        pull: Least and greatest force along the rail [N], drawn anew in each cycle.
    """

    pull: tuple[float, float] = setting((30.0, 50.0), "N", 0, LONGEST)

    source: ClassVar[str] = "BVAD (translation takes 12 to 34 % of suited time); forces assumed"
    place: ClassVar[str] = "microgravity"
    period: ClassVar[float | None] = 2 * GRIP

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Adds the motors of the pull, and draws the rail."""
        add_pushes(spec)
        hand = spec.site("hand_grip").pos
        ends = [place_of(spec, angles[1:], hand) for angles in (FAR, NEAR)]
        beyond = 0.35 * (ends[0] - ends[1])
        rail = ends[0] + beyond, ends[1] - beyond
        draw_bar(spec.body("torso"), CAPSULE, "exo_accent", 0.016, *rail)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns cycles of pull and reach; the path is watched while the hand pulls."""
        far, near = arm.places(np.array([FAR, NEAR]))
        stops = repeated([(0.0, far), (GRIP, near)], 2 * GRIP, samples * dt)
        starts = [time for time, _ in stops[::2]]
        time, force = dt * np.arange(samples), np.zeros(samples)
        for start in starts:
            force += rng.uniform(*self.pull) * _pulse(time - start)
        along = (far - near) / np.linalg.norm(far - near)
        motion = through_places(arm, through(stops, samples, dt)[0], FAR, dt)
        windows = [(start, start + GRIP) for start in starts]
        return Plan(motion, push=force[:, None] * along, watched=between(windows, samples, dt))


def _pulse(time: Array) -> Array:
    """Returns a smooth rise to 1 and fall to 0 within the grip of one hand."""
    rise = minimum_jerk(np.clip(time / RISE, 0, 1))[0]
    return rise - minimum_jerk(np.clip((time - GRIP + RISE) / RISE, 0, 1))[0]


HANDRAIL = Handrail(name="Handrail", duration=20.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03)
"""Five pulls; the hand stays within 3 cm of the rail while it pulls."""
