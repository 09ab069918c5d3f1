"""Hands that go from place to place: along a panel, with objects, and along a rail."""

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
from .motions import between, cycles, minimum_jerk, posture, through
from .task import LONGEST, SUSTAINED, Task

BOX, CAPSULE = mjtGeom.mjGEOM_BOX, mjtGeom.mjGEOM_CAPSULE
CYLINDER = mjtGeom.mjGEOM_CYLINDER
# Points of the panel relative to the shoulder, forward, outward and up, in lengths of the straight
# arm to its grip: two columns of four, which shoulder and elbow reach within their measured ranges.
PANEL = np.array(
    [(0.80, across, up) for across in (0.0, 0.12) for up in (-0.48, -0.37, -0.26, -0.15)]
)
BENT = posture(0.6, 1.2)  # start of the search for a posture of the first point
ACROSS, SHELVES = PANEL[:, 1].max(), np.unique(PANEL[:, 2])  # in lengths of the arm
DWELL, GRASP = 0.5, 0.5  # s
QUICKEST = 0.2  # [s], least time of a reach
BLOCK_SIZE = 0.05  # m, half of its edge
BEHIND, RIM = 0.1, 0.09  # [m], extent of the drawn panel behind and around its points


@dataclass(frozen=True, kw_only=True)
class ReachPanel(Task):
    """Straight reaches to random points of a panel, with half a second at each.

    Attributes:
        reach_time: Shortest and longest time of a reach [s], drawn for each.
    """

    reach_time: tuple[float, float] = setting((1.3, 1.7), "s", QUICKEST, LONGEST)

    source: ClassVar[str] = (
        "Anderson and Newman 2015 (12 repeats, functional tasks); MVL work envelope; points and "
        "times assumed"
    )
    place: ClassVar[str] = "moon"

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the panel with a button at each of its points."""
        for x, y, z in draw_panel(spec):
            ends = [x - 0.018, y, z], [x + 0.018, y, z]
            draw_bar(spec.body("torso"), CYLINDER, "exo_accent", 0.02, *ends)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns reaches from point to point; the rests there are watched."""
        stops, windows, now, point = [], [], 0.0, int(rng.integers(len(PANEL)))
        while not stops or stops[-1][0] < samples * dt:
            place = arm.length * PANEL[point]
            stops += [(now, place), (now + DWELL, place)]
            windows.append((now, now + DWELL))
            now += DWELL + rng.uniform(*self.reach_time)
            other = int(rng.integers(len(PANEL) - 1))
            point = other + (other >= point)
        motion = through_places(arm, through(stops, samples, dt)[0], BENT, dt)
        return Plan(motion, watched=between(windows, samples, dt))


@dataclass(frozen=True, kw_only=True)
class ObjectRelocation(Task):
    """Objects are taken from a low shelf, carried to one of two high ones, and left there.

    Each object has places and times of its own.

    Attributes:
        load: Least and greatest mass of an object [kg]; the exoskeleton does not know the mass.
        across: Least and greatest distance of a place outward from the shoulder, in lengths of the
            straight arm.
        carry_time: Shortest and longest time of the way up [s].
        return_time: Shortest and longest time of the way down [s].
    """

    load: tuple[float, float] = setting((1.0, 5.0), "kg", 0, LONGEST)
    across: tuple[float, float] = setting((0.0, 0.04), "of the arm", 0, ACROSS)
    carry_time: tuple[float, float] = setting((1.6, 2.2), "s", QUICKEST, LONGEST)
    return_time: tuple[float, float] = setting((1.2, 1.6), "s", QUICKEST, LONGEST)

    source: ClassVar[str] = (
        "LSDA 13587 (upper-body object relocation); masses, places and times assumed"
    )
    place: ClassVar[str] = "moon"
    carries: ClassVar[bool] = True

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the shelves, and the object in the hand while there is one."""
        draw_panel(spec)
        edge = BLOCK_SIZE
        place, name = grip(spec).pos - np.array([0, 0, edge]), f"{CARRIED}_block"
        draw(holder(spec), BOX, "exo_accent", pos=place, size=[edge] * 3, name=name)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns cycles of grasp, carry, release and return; arrivals are watched."""
        loads, stops, windows, now = rng.spawn(1)[0], [], [], 0.0
        mass, time = np.zeros(samples), dt * np.arange(samples)
        while not stops or stops[-1][0] < samples * dt:
            low, high = (
                arm.length * np.array([PANEL[0, 0], rng.uniform(*self.across), up])
                for up in (SHELVES[0], rng.choice(SHELVES[2:]))
            )
            there = now + GRASP + rng.uniform(*self.carry_time)
            stops += [(now, low), (now + GRASP, low), (there, high), (there + GRASP, high)]
            windows += [(begin, begin + GRASP / 2 - dt) for begin in (now, there)]
            carried = (now + GRASP / 2 <= time) & (time < there + GRASP / 2)
            mass[carried] = loads.uniform(*self.load)
            now = there + GRASP + rng.uniform(*self.return_time)
        motion = through_places(arm, through(stops, samples, dt)[0], BENT, dt)
        return Plan(motion, mass, watched=between(windows, samples, dt))


def draw_panel(spec: mujoco.MjSpec) -> Array:
    """Draws a frame with four bars before the right shoulder; returns its points [m], (8, 3)."""
    torso = spec.body("torso")
    places = spec.body("shoulder").pos + straight_arm(spec) * PANEL * np.array([1, -1, 1])
    places = places + np.array([BEHIND, 0, 0])
    low, high = places.min(axis=0) - RIM, places.max(axis=0) + RIM
    x = places[0, 0]
    corners = [(low[1], low[2]), (high[1], low[2]), (high[1], high[2]), (low[1], high[2])]
    for (y, z), (next_y, next_z) in zip(corners, [*corners[1:], corners[0]], strict=True):
        draw_bar(torso, CAPSULE, "bearing", 0.012, [x, y, z], [x, next_y, next_z])
    for z in np.unique(places[:, 2]):
        draw_bar(torso, CAPSULE, "bearing", 0.005, [x, low[1], z], [x, high[1], z])
    return places


REACH_PANEL = ReachPanel(
    name="ReachPanel", duration=24.0, effort=SUSTAINED, tracking=0.1, hand_error=0.02
)
"""Some twelve reaches; the hand stays within 2 cm of each point for half a second."""

OBJECT_RELOCATION = ObjectRelocation(
    name="ObjectRelocation", duration=27.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03
)
"""Six objects, each placed in time and within 3 cm."""


FAR, NEAR = posture(1.1, 0.6), posture(0.45, 1.4)  # postures at the ends of the way
CYCLE = 4.0  # [s], of a pull and the way back
RISE = 0.3  # [s], rise and fall of the pull


@dataclass(frozen=True, kw_only=True)
class Handrail(Task):
    """The hand pulls along a straight rail for about two seconds of four, and reaches out again.

    Force and places are drawn for each cycle, times for the episode.

    Attributes:
        pull: Least and greatest force along the rail [N].
        grip: Least and greatest place of the grip on the rail, as a share of the way from its far
            to its near end.
        release: Least and greatest place of the release, likewise.
        pull_time: Shortest and longest time of a pull [s], of the 4 s of a cycle.
        wait: Shortest and longest time before the first pull [s].
    """

    pull: tuple[float, float] = setting((30.0, 50.0), "N", 0, LONGEST)
    grip: tuple[float, float] = setting((0.0, 0.3), "of the way", 0, 1)
    release: tuple[float, float] = setting((0.7, 1.0), "of the way", 0, 1)
    pull_time: tuple[float, float] = setting((1.6, 2.4), "s", 2 * RISE, CYCLE - 2 * RISE)
    wait: tuple[float, float] = setting((0.0, CYCLE), "s", 0, LONGEST)

    source: ClassVar[str] = (
        "BVAD (translation takes 12 to 34 % of suited time); forces, places and times assumed"
    )
    place: ClassVar[str] = "microgravity"
    period: ClassVar[float | None] = CYCLE

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
        forces, duration = rng.spawn(1)[0], rng.uniform(*self.pull_time)
        starts = cycles(rng.uniform(*self.wait), CYCLE, samples * dt)
        far, near = arm.places(np.array([FAR, NEAR]))
        time, force, stops = dt * np.arange(samples, dtype=float), np.zeros(samples), []
        for start in starts:
            begin, end = (far + rng.uniform(*at) * (near - far) for at in (self.grip, self.release))
            stops += [(start, begin), (start + duration, end)]
            force += forces.uniform(*self.pull) * _pulse(time - start, duration)
        along = (far - near) / np.linalg.norm(far - near)
        motion = through_places(arm, through(stops, samples, dt)[0], FAR, dt)
        windows = [(start, start + duration) for start in starts]
        return Plan(motion, push=force[:, None] * along, watched=between(windows, samples, dt))


def _pulse(time: Array, duration: float) -> Array:
    """Returns a smooth rise to 1 and fall to 0 within a duration [s]."""
    rise = minimum_jerk(np.clip(time / RISE, 0, 1))[0]
    return rise - minimum_jerk(np.clip((time - duration + RISE) / RISE, 0, 1))[0]


HANDRAIL = Handrail(name="Handrail", duration=20.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03)
"""Five pulls; the hand stays within 3 cm of the rail while it pulls."""
