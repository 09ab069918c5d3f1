"""Work with tools in the hand: hammer, ratchet wrench, scoop, and a tool held above the head."""

import math
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from mujoco import mjtGeom

from ...arrays import Array
from ...assets import JOINTS
from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import CARRIED, add_reaction, draw, draw_bar, grip, holder, place_of
from ..provenance import setting
from ..simulation.episode_plan import STRONGEST, Plan
from ..simulation.kinematics import Arm
from .motions import between, cycles, posture, ramped, through
from .task import LOADED, LONGEST, SUSTAINED, Task

LARGEST = 2.0  # [rad], greatest angle of a range

BOX, CAPSULE = mjtGeom.mjGEOM_BOX, mjtGeom.mjGEOM_CAPSULE
CYLINDER, ELLIPSOID = mjtGeom.mjGEOM_CYLINDER, mjtGeom.mjGEOM_ELLIPSOID
RAISED, IMPACT = posture(1.1, 1.45), posture(0.6, 0.7)  # which the anvil faces
BETWEEN_BLOWS = 1.25  # s
STEEPNESS = 1.6  # times the mean speed of the swing, at impact
HANDLE, HEAD = 0.25, 0.03  # m from the grip, and radius
HEAD_SHARE = 0.77  # share of the mass; the rest is the handle
STRIKING = 8  # bit of the contacts between hammer and anvil, which nothing else has
LEAST_REBOUND = 0.15  # a critically damped contact has exp(-2)
EARLY = 0.04  # [s], hand and speed are watched so long before the swing ends, above the anvil
ROUNDING = 1e-9  # s
THROUGH = (
    0.03  # [m], depth of the swing's end below the anvil's surface, so that the hammer strikes
)
CONTACT_TIME = 0.016  # [s], duration of the rebound; eight steps of the physics
ANVIL_SIZE = (0.06, 0.06, 0.02)  # m, half of its edges


@dataclass(frozen=True, kw_only=True)
class Hammer(Task):
    """The arm swings a hammer from a raised posture against an anvil, four times in 5 s.

    Posture and times are drawn for the episode, whose blows are all alike.

    Attributes:
        mass: Mass of the hammer [kg].
        rebound: Share of its speed with which the hammer leaves the anvil.
        shoulder: Least and greatest angle of the shoulder in the raised posture [rad].
        elbow: Least and greatest angle of the elbow there [rad].
        blow_time: Shortest and longest time of the way down [s].
        raise_time: Shortest and longest time of the way back [s]; then the arm pauses.
        wait: Shortest and longest time before the first blow [s].
    """

    mass: float = setting(1.3, "kg", 0.1, HEAVIEST_PAYLOAD)
    rebound: float = setting(0.4, "of the speed", LEAST_REBOUND, 0.9)
    shoulder: tuple[float, float] = setting((1.02, 1.18), "rad", 1.0, LARGEST)
    elbow: tuple[float, float] = setting((1.35, 1.55), "rad", 1.2, LARGEST)
    blow_time: tuple[float, float] = setting((0.42, 0.5), "s", 0.2, 0.55)
    raise_time: tuple[float, float] = setting((0.55, 0.65), "s", 0.3, 0.7)
    wait: tuple[float, float] = setting((0.0, BETWEEN_BLOWS), "s", 0, LONGEST)

    source: ClassVar[str] = (
        "geology hammer of 1.3 kg, 0.8 blows a second; rebound, postures and times assumed"
    )
    place: ClassVar[str] = "moon"
    period: ClassVar[float | None] = BETWEEN_BLOWS

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Puts a hammer in the hand, and an anvil where it strikes."""
        at = grip(spec).pos
        head = at + np.array([HANDLE, 0, 0])
        hammer = holder(spec).add_body(name="hammer", pos=at)
        hammer.mass, hammer.explicitinertial = self.mass, True
        hammer.ipos, hammer.inertia = _inertia(self.mass)
        solid = hammer.add_geom(
            name="hammer_head", size=[HEAD, 0, 0], pos=[HANDLE, 0, 0], mass=0, group=4
        )
        solid.contype, solid.conaffinity = STRIKING, 0
        draw_bar(hammer, CYLINDER, "rubber", 0.013, [-0.08, 0, 0], [HANDLE, 0, 0])
        draw_bar(hammer, CYLINDER, "exo_steel", 0.026, [HANDLE, 0, 0.05], [HANDLE, 0, -HEAD])
        place, course = _strike(spec, head)
        surface = place + (HEAD + ANVIL_SIZE[2]) * course
        anvil = spec.body("torso").add_body(name="anvil", pos=surface)
        anvil.alt.type = mujoco.mjtOrientation.mjORIENTATION_ZAXIS
        anvil.alt.zaxis = -course
        face = anvil.add_geom(name="anvil", type=BOX, size=ANVIL_SIZE, mass=0, group=4)
        face.contype, face.conaffinity, face.condim = 0, STRIKING, 1
        face.priority, face.solimp = 1, [0.99, 0.99, 0.001, 0.5, 2]
        face.solref = contact(self.rebound)
        draw(anvil, BOX, "exo_steel", size=ANVIL_SIZE)
        draw_bar(anvil, CYLINDER, "exo_frame", 0.022, [0, 0, -ANVIL_SIZE[2]], [0, 0, -0.3])

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns swings down and back; the speed is watched where the hammer strikes."""
        raised = posture(rng.uniform(*self.shoulder), rng.uniform(*self.elbow))
        swing, raising = rng.uniform(*self.blow_time), rng.uniform(*self.raise_time)
        wait = rng.uniform(*self.wait)
        since = dt * np.arange(samples) + ROUNDING - wait
        time = np.mod(since, BETWEEN_BLOWS)
        rate = STEEPNESS * (IMPACT - raised) / swing
        motion = np.zeros((3, samples, len(JOINTS)))
        still = np.zeros(len(JOINTS))
        down = (since >= 0) & (time < swing + 2 * ROUNDING)
        back = (since >= 0) & ~down & (time < swing + raising)
        motion[0] = raised
        motion[:, down] = _swing(time[down], swing, (raised, still), (IMPACT, rate))
        motion[:, back] = _swing(
            time[back] - swing, raising, (IMPACT, -self.rebound * rate), (raised, still)
        )
        blows = cycles(wait + swing - EARLY, BETWEEN_BLOWS, samples * dt)
        windows = [(blow, blow) for blow in blows]
        return Plan((motion[0], motion[1], motion[2]), watched=between(windows, samples, dt))


def contact(rebound: float) -> list[float]:
    """Returns MuJoCo's solref of a contact that leaves a share of the speed.

    The contact is a damped oscillator that pushes and cannot pull, so that the hammer leaves when
    the force ends. With the damping sin(x), the share is exp(-(pi - 2 x) tan(x)) (Schwager and
    Pöschel 2007).
    """
    from scipy.optimize import root_scalar  # slow to import

    def excess(x: float) -> float:
        return math.exp(-(math.pi - 2 * x) * math.tan(x)) - rebound

    x = float(root_scalar(excess, bracket=(0.0, math.pi / 2 - 1e-6)).root)
    frequency = (math.pi - 2 * x) / CONTACT_TIME / math.cos(x)
    return [-(frequency**2), -2 * math.sin(x) * frequency]


def _inertia(mass: float) -> tuple[Array, Array]:
    """Returns center of mass from the grip [m] and moments about it [kg·m²] of a hammer."""
    head, handle = HEAD_SHARE * mass, (1 - HEAD_SHARE) * mass
    middle = (HANDLE - 0.08) / 2
    center = (head * HANDLE + handle * middle) / mass
    across = head * (HANDLE - center) ** 2 + handle * (middle - center) ** 2
    across += 0.4 * head * HEAD**2 + handle * (HANDLE + 0.08) ** 2 / 12
    return np.array([center, 0, 0]), np.array([0.4 * head * HEAD**2 + 1e-5, across, across])


def _strike(spec: mujoco.MjSpec, head: Array) -> tuple[Array, Array]:
    """Returns place [m] and direction of the hammer's blow in the frame of the torso."""
    step = 1e-6 * (IMPACT - RAISED)[1:]
    place = place_of(spec, IMPACT[1:], head)
    course = place - place_of(spec, IMPACT[1:] - step, head)
    course = course / np.linalg.norm(course)
    return place - THROUGH * course, course


def _swing(
    time: Array, duration: float, begin: tuple[Array, Array], end: tuple[Array, Array]
) -> Array:
    """Returns the quintic between two pairs of angles and rates, without acceleration at its ends.

    `time` is the time since the beginning [s], shape (samples,). The motion has the shape (3,
    samples, 4).
    """
    s = (time / duration)[:, None]
    path = end[0] - begin[0]
    first, last = duration * begin[1], duration * end[1]
    a, b, c = 10 * path - 6 * first - 4 * last, -15 * path + 8 * first + 7 * last, 6 * path
    c = c - 3 * (first + last)
    angle = begin[0] + s * (first + s**2 * (a + s * (b + s * c)))
    rate = (first + s**2 * (3 * a + s * (4 * b + s * 5 * c))) / duration
    acceleration = s * (6 * a + s * (12 * b + s * 20 * c)) / duration**2
    return np.array([angle, rate, acceleration])


HAMMER = Hammer(
    name="Hammer", duration=25.0, effort=LOADED, tracking=0.3, hand_error=0.05, slowness=0.2
)
"""Twenty blows, each in its place within 5 cm and with at least 80 % of the intended speed.

The wrist may yield to a blow, which throws it back by some 0.25 rad.
"""


FREQUENCY = 1.0  # Hz
DAMPING = 400.0  # [N·s/m], slope of the reaction, which has its limit at 0.1 m/s
BEGINNING = 1.0  # [s], rise of the strokes from rest
STROKE, STRAIGHT = JOINTS.index("elbow_flexion"), JOINTS.index("shoulder_flexion")


@dataclass(frozen=True, kw_only=True)
class Ratchet(Task):
    """The elbow flexes against a reaction at the grip and extends freely, once a second.

    Attributes:
        reaction: Greatest force that withstands the stroke [N].
        shoulder: Least and greatest angle of the shoulder [rad], which stays.
        elbow: Least and greatest angle of the elbow in the middle of the strokes [rad].
        swing: Least and greatest angle from there to the ends of the strokes [rad].
        wait: Shortest and longest time before the first stroke [s].
    """

    reaction: float = setting(40.0, "N", 0, STRONGEST)
    shoulder: tuple[float, float] = setting((0.6, 1.0), "rad", 0, LARGEST)
    elbow: tuple[float, float] = setting((1.1, 1.25), "rad", 0, LARGEST)
    swing: tuple[float, float] = setting((0.22, 0.3), "rad", 0, 0.5)
    wait: tuple[float, float] = setting((0.0, 1 / FREQUENCY), "s", 0, LONGEST)

    source: ClassVar[str] = (
        "Pistol Grip Tool (techbriefs 28401): up to 34 N·m, at most 100 N at 0.3 m; posture and "
        "stroke assumed"
    )
    place: ClassVar[str] = "microgravity"
    period: ClassVar[float | None] = 1 / FREQUENCY

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Adds the reaction, and draws the wrench."""
        add_reaction(spec, "ratchet", self.reaction, DAMPING)
        at, body = grip(spec).pos, holder(spec)
        handle = at + np.array([0, 0.07, 0]), at + np.array([0, -0.23, 0])
        head = at + np.array([-0.02, -0.25, 0]), at + np.array([0.05, -0.25, 0])
        draw_bar(body, CAPSULE, "exo_steel", 0.011, *handle)
        draw_bar(body, CYLINDER, "exo_accent", 0.028, *head)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns strokes that grow from rest; their ends are watched."""
        wait, speed = rng.uniform(*self.wait), math.tau * FREQUENCY
        time = np.maximum(dt * np.arange(samples) - wait, 0)
        wave, rate = -np.cos(speed * time), speed * np.sin(speed * time)
        grown = ramped(wave, rate, -(speed**2) * wave, time, BEGINNING)
        motion = np.zeros((3, samples, len(JOINTS)))
        motion[0, :, STRAIGHT] = rng.uniform(*self.shoulder)
        motion[:, :, STROKE] = rng.uniform(*self.swing) * np.array(grown)
        motion[0, :, STROKE] += rng.uniform(*self.elbow)
        ends = cycles(wait + 1.5 / FREQUENCY, 1 / FREQUENCY, samples * dt)
        windows = [(end, end) for end in ends]
        return Plan((motion[0], motion[1], motion[2]), watched=between(windows, samples, dt))


RATCHET = Ratchet(name="Ratchet", duration=15.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03)
"""Fifteen strokes against 40 N, the hand within 3 cm of the end of each."""


LEVEL = math.pi / 2  # rad, pitch of a hand that points forward
REST, WAYS = 0.3, 2.4  # [s], pause at either end; time of the way up and of the way down together


@dataclass(frozen=True, kw_only=True)
class Scoop(Task):
    """The arm lifts a level scoop full of soil forward and lowers it empty, every three seconds.

    Soil, depth and height are drawn for each cycle, times for the episode.

    Attributes:
        load: Least and greatest mass of the soil [kg].
        depth: Least and greatest angle of the shoulder when the scoop is low [rad].
        height: Least and greatest angle of the shoulder when the scoop is high [rad].
        lift_time: Shortest and longest time of the way up [s], of 2.4 s up and down.
        wait: Shortest and longest time before the first scoop [s].
    """

    load: tuple[float, float] = setting((2.0, 5.0), "kg", 0, LONGEST)
    depth: tuple[float, float] = setting((0.36, 0.58), "rad", 0, LEVEL)
    height: tuple[float, float] = setting((0.82, 1.04), "rad", 0, LEVEL)
    lift_time: tuple[float, float] = setting((1.05, 1.35), "s", 0.4, WAYS - 0.4)
    wait: tuple[float, float] = setting((0.0, 2 * REST + WAYS), "s", 0, LONGEST)

    source: ClassVar[str] = (
        "sampling on Apollo and IST-2; 3 s, 2 to 5 kg, postures and times assumed"
    )
    place: ClassVar[str] = "moon"
    carries: ClassVar[bool] = True
    period: ClassVar[float | None] = 2 * REST + WAYS

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the scoop, and the soil while there is some."""
        at, body = grip(spec).pos, holder(spec)
        back = at + np.array([-0.03, 0, -0.12])
        draw(body, BOX, "exo_steel", pos=back, size=[0.003, 0.055, 0.08])
        for across in (-0.055, 0.055):
            side = at + np.array([-0.015, across, -0.12])
            draw(body, BOX, "exo_steel", pos=side, size=[0.018, 0.003, 0.08])
        soil, size = at + np.array([-0.015, 0, -0.125]), [0.032, 0.048, 0.068]
        draw(body, ELLIPSOID, "rubber", pos=soil, size=size, name=f"{CARRIED}_soil")

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns lifts and descents; place and tilt are watched while there is a load."""
        loads, up = rng.spawn(1)[0], REST + rng.uniform(*self.lift_time)
        mass, time = np.zeros(samples), dt * np.arange(samples)
        stops, windows = [], []
        for start in cycles(rng.uniform(*self.wait), 2 * REST + WAYS, samples * dt):
            low, high = (
                posture(shoulder, LEVEL - shoulder)
                for shoulder in (rng.uniform(*self.depth), rng.uniform(*self.height))
            )
            stops += [(start, low), (start + REST, low)]
            stops += [(start + up, high), (start + up + REST, high)]
            full, empty = start + REST / 2, start + up + REST / 2
            mass[(full <= time) & (time < empty)] = loads.uniform(*self.load)
            windows.append((full + dt, empty - dt))
        return Plan(through(stops, samples, dt), mass, watched=between(windows, samples, dt))


SCOOP = Scoop(name="Scoop", duration=30.0, effort=SUSTAINED, tracking=0.1, hand_error=0.1, tilt=0.2)
"""Ten scoops; the tilt of the loaded hand differs from the intended tilt by at most 0.2 rad."""


MOVE = 1.5  # [s], from place to place
SETTLING = 0.5  # [s], time at a place before the hand counts


@dataclass(frozen=True, kw_only=True)
class OverheadHold(Task):
    """The raised arm holds a tool still for about six seconds, at one place after the other.

    Attributes:
        load: Mass of the tool [kg].
        lower: Least and greatest angle of the shoulder at every other place [rad].
        higher: Least and greatest angle of the shoulder at the places between [rad].
        elbow: Least and greatest angle of the elbow [rad].
        stay_time: Shortest and longest time at a place [s].
    """

    load: float = setting(1.0, "kg", 0, HEAVIEST_PAYLOAD)
    lower: tuple[float, float] = setting((0.85, 0.95), "rad", 0, LARGEST)
    higher: tuple[float, float] = setting((1.1, 1.2), "rad", 0, LARGEST)
    elbow: tuple[float, float] = setting((1.1, 1.3), "rad", 0, LARGEST)
    stay_time: tuple[float, float] = setting((5.0, 7.0), "s", 2 * SETTLING, LONGEST)

    source: ClassVar[str] = (
        "shoulder injuries in the EMU (Hilbert 2015); postures, times and load assumed"
    )
    place: ClassVar[str] = "mars"
    carries: ClassVar[bool] = True
    fatigue: ClassVar[bool] = True

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the tool."""
        at = grip(spec).pos
        ends = at + np.array([-0.04, 0, 0]), at + np.array([0.14, 0, 0])
        draw_bar(holder(spec), CAPSULE, "exo_steel", 0.02, *ends)

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns a lower and a higher place in turn; the hand is watched at each."""
        stops, windows, now, shoulder, other = [], [], 0.0, self.lower, self.higher
        while not stops or stops[-1][0] < samples * dt:
            place = posture(rng.uniform(*shoulder), rng.uniform(*self.elbow))
            end = now + rng.uniform(*self.stay_time)
            stops += [(now, place), (end, place)]
            windows.append((now + SETTLING * (now > 0), end))
            now, shoulder, other = end + MOVE, other, shoulder
        return Plan(
            through(stops, samples, dt),
            mass=np.full(samples, self.load),
            watched=between(windows, samples, dt),
        )


OVERHEAD_HOLD = OverheadHold(name="OverheadHold", duration=120.0, effort=SUSTAINED, hand_error=0.03)
"""A tool of 1 kg, kept within 3 cm at each place, for 120 s, by muscles that tire."""
