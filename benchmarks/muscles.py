"""MyoArm as the muscles of our arm: how well it fits, how strong it is, and what it costs."""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import mujoco
import numpy as np

from ..arrays import Array
from ..assets import JOINTS
from ..envs.evaluation import rollout
from ..envs.making import make_arms
from ..envs.model import ArmConfig, bare_arm
from ..envs.model.config import NO_SUIT
from ..envs.muscles import CONVENTIONS, STANDARD, MyoArm, muscle_scores
from ..envs.muscles.analysis import Convention, Demand, demand_of, share_among_muscles
from ..envs.muscles.elbow import MuscleElbow
from ..envs.muscles.mapping import AXES, OWN, constraint_torques
from ..envs.muscles.metabolic import LEAST_HEAT, MODELS, muscle_masses
from ..envs.muscles.myoarm import CHEST
from ..envs.person import Person, VoluntaryControl, isometric_strength, segments, strength_limits
from ..envs.person.strength import PROVENANCE
from ..envs.policies import make_policy
from ..envs.simulation.inverse_dynamics import Chain
from ..scripts.folders import to_json
from ..scripts.output import progress, table
from ..tables import Rows
from .timing import seconds

MAN = Person.percentile("male", 50)
TASK, MOTIONS = "ActiveSuit/ArmTracking-v0", 20
LOW, HIGH = (-0.1, -0.4, 0.05, -0.7), (1.4, 2.2, 2.1, 0.7)  # rad, of the postures of the map
KNUCKLE = 0.08  # m, from the wrist to the middle finger
APART = 0.3  # difference of strengths that is named
BALANCE = 1.0  # [N·m], about the other axes where muscles are balanced
SPEEDS = (60.0, 180.0)  # degrees/s, of isokinetic tests
_STANDING = {
    "shoulder_abduction": ((10, 45, 85), (0.0, 0.0, 1.57, 0.0), 45),
    "shoulder_flexion": ((0, 45, 90, 120), (0.0, 0.0, 0.5, 0.0), 45),
    "elbow_flexion": ((10, 45, 90, 130), (0.0, 0.0, 0.0, 0.0), 90),
    "wrist_flexion": ((-40, 0, 40), (0.0, 0.0, 1.57, 0.0), 0),
}
"""Of each joint: degrees of isometric tests, the other angles, and degrees of isokinetic ones."""


def map_errors(postures: int = 1000) -> dict[str, tuple[float, float]]:
    """Returns how far MyoArm in our posture is from our arm: mean and largest, by name.

    Postures are random over the whole range, and the shoulders of both arms are one. MyoArm has the
    length of the average man's upper arm and forearm together.
    """
    arm, rng = MyoArm.load(), np.random.default_rng(0)
    angle = rng.uniform(LOW, HIGH, (postures, len(JOINTS)))
    model = bare_arm(ArmConfig(wearer=MAN))
    ours, upper = _places(model, angle)
    theirs = arm.places(angle)
    length = sum(segments(MAN)[name].length for name in ("upper_arm", "forearm"))
    still = arm.places(np.zeros((1, len(JOINTS))))[0]
    theirs *= length / np.linalg.norm(np.diff(still, axis=0), axis=1)[:2].sum()
    apart = [_between(np.diff(one, axis=1)) for one in (ours, theirs)]
    ways = np.rad2deg(np.arccos(np.clip((apart[0] * apart[1]).sum(axis=2), -1, 1)))
    turned = _turned(arm, angle, ("humerus_r", "thirdmc_r"))
    found = {
        "turn of the upper arm [deg]": _angle(turned[0], upper[0]),
        "turn of the hand [deg]": _angle(turned[1], upper[1]),
        "direction of the upper arm [deg]": ways[:, 0],
        "direction of the forearm [deg]": ways[:, 1],
        "direction of the hand [deg]": ways[:, 2],
        "elbow [mm]": 1e3 * np.linalg.norm(ours[:, 1] - theirs[:, 1], axis=1),
        "wrist [mm]": 1e3 * np.linalg.norm(ours[:, 2] - theirs[:, 2], axis=1),
        "knuckle [mm]": 1e3 * np.linalg.norm(ours[:, 3] - theirs[:, 3], axis=1),
    }
    return {name: (float(values.mean()), float(values.max())) for name, values in found.items()}


def _places(model: mujoco.MjModel, angle: Array) -> tuple[Array, tuple[Array, Array]]:
    """Returns places of our arm as `MyoArm.places`, and turns of upper arm and hand."""
    data, bodies = (
        mujoco.MjData(model),
        [model.body(n).id for n in ("upper_arm", "forearm", "hand")],
    )
    to_body = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    places, turns = np.empty((len(angle), 4, 3)), np.empty((2, len(angle), 3, 3))
    for i, one in enumerate(angle):
        data.qpos[:] = one
        mujoco.mj_kinematics(model, data)
        torso = data.body("torso").xmat.reshape(3, 3)
        frames = data.xmat[bodies].reshape(-1, 3, 3)
        knuckle = data.xpos[bodies[2]] - KNUCKLE * frames[2][:, 2]
        points = np.vstack([data.xpos[bodies], knuckle]) - data.xpos[bodies[0]]
        places[i] = points @ torso @ to_body.T
        for k, link in enumerate((0, 2)):
            turns[k, i] = to_body @ torso.T @ frames[link] @ to_body.T
    return places, (turns[0], turns[1])


def _turned(arm: MyoArm, angle: Array, bodies: Sequence[str]) -> list[Array]:
    """Returns turns of MyoArm's bodies from where they are in the hanging arm."""
    data, found = mujoco.MjData(arm.model), np.empty((len(bodies), len(angle) + 1, 3, 3))
    for i, theirs in enumerate(arm.angles(np.vstack([np.zeros((1, len(JOINTS))), angle]))):
        data.qpos[:] = arm.coupled @ theirs
        mujoco.mj_kinematics(arm.model, data)
        trunk = data.body(CHEST).xmat.reshape(3, 3) @ arm.trunk
        for k, name in enumerate(bodies):
            found[k, i] = trunk.T @ data.body(name).xmat.reshape(3, 3)
    return [one[1:] @ one[0].T for one in found]


def _between(steps: Array) -> Array:
    return steps / np.linalg.norm(steps, axis=2, keepdims=True)


def _angle(one: Array, other: Array) -> Array:
    """Returns the angle between orientations [degrees]."""
    trace = np.einsum("nij,nij->n", one, other)
    return np.rad2deg(np.arccos(np.clip((trace - 1) / 2, -1, 1)))


@dataclass(frozen=True, kw_only=True)
class Strength:
    """Strength of the average man in one posture.

    Attributes:
        joint: The joint.
        degrees: Its angle.
        speed: Its rate in the direction of the torque [degrees/s].
        way: "flexion" or "extension", of abduction "abduction" or "adduction".
        muscles: Torque of all muscles that pull that way [N·m].
        balanced: The same with at most 1 N·m about the six other axes.
        ours: Torque of our wearer [N·m].
        source: Source of our peak torque.
    """

    joint: str
    degrees: float
    speed: float
    way: str
    muscles: float
    balanced: float
    ours: float
    source: str

    @property
    def apart(self) -> bool:
        """Whether muscles and our wearer differ by more than 30 %."""
        return abs(self.muscles / self.ours - 1) > APART


def strengths() -> list[Strength]:
    """Returns the strength of MyoArm beside that of our average man, at rest and at speed."""
    found = []
    for joint, (grid, base, middle) in _STANDING.items():
        still = [(degrees, 0.0) for degrees in grid]
        for degrees, speed in [*still, *((middle, one) for one in SPEEDS)]:
            found += [_strength(joint, base, degrees, speed, way) for way in (1, -1)]
    return found


def _strength(
    joint: str, base: Sequence[float], degrees: float, speed: float, way: int
) -> Strength:
    from scipy.optimize import linprog  # slow to import

    j, arm = JOINTS.index(joint), MyoArm.load()
    angle, rate = np.array([base]), np.zeros((1, len(JOINTS)))
    angle[0, j], rate[0, j] = np.deg2rad(degrees), way * np.deg2rad(speed)
    geometry = arm.geometry(angle, rate)
    lever, axis = geometry.arms[0] * geometry.full[0], OWN[j]
    others = lever[[k for k in range(len(AXES)) if k != axis]]
    limits = np.full(2 * len(others), BALANCE)
    both = np.vstack([others, -others])
    best: Any = linprog(-way * lever[axis], A_ub=both, b_ub=limits, bounds=(0, 1))
    low, high = strength_limits(isometric_strength(MAN), angle[0], rate[0])
    names = ("abduction", "adduction") if "abduction" in joint else ("flexion", "extension")
    side = "positive" if way > 0 else "negative"
    sources = {one.name: one.source for one in PROVENANCE}
    return Strength(
        joint=joint,
        degrees=degrees,
        speed=speed,
        way=names[way < 0],
        muscles=float(np.maximum(way * lever[axis], 0).sum()),
        balanced=float(-best.fun),
        ours=float(high[j] if way > 0 else -low[j]),
        source=sources[f"strength.{joint}.{side}.peak"],
    )


@dataclass(frozen=True, kw_only=True)
class ArmWork:
    """Metabolic power of the bare arm of the average man on Earth, above that of rest.

    Attributes:
        what: What the arm does.
        power: Metabolic power by the name of the model [W].
        work: Mean power of the positive work of the joints [W].
        published: Published metabolic power [W]; None where no value was found.
        source: Where it is from.
    """

    what: str
    power: dict[str, float]
    work: float
    published: float | None
    source: str


LITER = 20.1e3  # [J/L], energy of oxygen at a respiratory quotient of 0.8
_TANG = 250e-3 / 60 * LITER / 2  # W an arm
_WHO = "Tang et al. 2009, 47 men: net uptake below 250 mL/min, here for both arms"
EFFICIENCY = 0.25
_DAVIES = "Davies and Sargeant 1974, 8 men: light arm cranking has an efficiency of 0.25"
_NOTHING = "no value found"
CYCLES, DT = 2, 0.01
_POSTURES = {
    "hanging": (0.0, 0.0, 0.0, 0.0),
    "upper arm level, elbow bent by 90 degrees": (0.0, np.pi / 2, np.pi / 2, 0.0),
    "straight arm level": (0.0, np.pi / 2, 0.0, 0.0),
}


def bare_arms() -> list[ArmWork]:
    """Returns what arm work takes that others have measured, without co-contraction."""
    still = np.zeros(len(JOINTS))
    found = [
        _work(what, posture, still, 60.0, source=_NOTHING) for what, posture in _POSTURES.items()
    ]
    beat = {"published": _TANG, "source": _WHO}
    elbow, shoulder = np.array([0, 0, 0.9, 0]), np.array([0, 0.7, 0, 0])
    found.append(_work("elbow flexion, 40 a minute", (0, 0, 1.0, 0), elbow, 40.0, **beat))
    found.append(_work("shoulder flexion, 60 a minute", (0, 0.6, 0.2, 0), shoulder, 60.0, **beat))
    turning = np.array([0, 0.5, 0.6, 0])
    crank = _work("cranking, 20 W", (0, 0.9, 1.1, 0), turning, 60.0, load=20.0, source=_DAVIES)
    return [*found, replace(crank, published=crank.work / EFFICIENCY)]


def _work(
    what: str,
    posture: Sequence[float],
    swing: Array,
    beat: float,
    *,
    source: str,
    published: float | None = None,
    load: float = 0.0,
) -> ArmWork:
    """Returns what sines about a posture take, `beat` a minute, against a damper of `load` W."""
    arm, chain = MyoArm.load(), Chain.of(bare_arm(ArmConfig(wearer=MAN, gravity="earth")))
    pace = 2 * np.pi * beat / 60
    phase = pace * np.arange(0, CYCLES * 60 / beat, DT)[:, None]
    angle, rate = np.array(posture) + swing * np.sin(phase), pace * swing * np.cos(phase)
    torque, _ = constraint_torques(chain, angle, rate, -(pace**2) * swing * np.sin(phase))
    torque[:, OWN] += load / max(float((rate**2).sum(axis=1).mean()), 1e-9) * rate
    flat = np.zeros_like(angle)
    demand = Demand(1.0, torque, flat, flat, arm.geometry(angle, rate), DT)
    rest, power = LEAST_HEAT * muscle_masses(arm).sum(), {}
    for name in MODELS:
        shared = share_among_muscles(arm, demand, Convention(contraction=False, metabolic=name))
        late = shared.power[len(angle) // CYCLES :]
        power[name] = float(late.sum(axis=1).mean() - rest)
    work = float(np.maximum(torque[:, OWN] * rate, 0).sum(axis=1).mean())
    return ArmWork(what=what, power=power, work=work, published=published, source=source)


@dataclass(frozen=True, kw_only=True)
class Pushed:
    """An elbow that is pushed, weightless and without a suit.

    Attributes:
        wearer: What holds the elbow.
        contraction: Co-contraction [N·m].
        stiffness: Stiffness at rest, before any feedback [N·m/rad].
        early: Deviation when the push ends [mrad].
        peak: Largest deviation [mrad].
        later: Deviation half a second after its beginning [mrad].
    """

    wearer: str
    contraction: float
    stiffness: float
    early: float
    peak: float
    later: float


PUSH, PUSHED, WATCHED = 2.0, 0.1, 0.8  # N·m, s, s
ELBOW = JOINTS.index("elbow_flexion")


def pushes() -> list[Pushed]:
    """Returns how the elbow of muscles, and that of the net-torque wearer, answers to a push."""
    found = []
    for contraction in (0.0, 3.0, 10.0):
        env = MuscleElbow(suit=NO_SUIT, gravity="microgravity", contraction=contraction)
        away, stiffness = _deviation(env)
        found.append(_pushed("muscles", contraction, stiffness, away))
        inertia = env.inertia
        base, slope, _, relaxation, usual = VoluntaryControl().impedance(MAN)[:, ELBOW]
        stiffness = float(base + slope * (contraction - usual))
        away = _net_torque(inertia, stiffness, float(relaxation * stiffness))
        found.append(_pushed("net torque, without reflex", contraction, stiffness, away))
    return found


def _pushed(wearer: str, contraction: float, stiffness: float, away: Array) -> Pushed:
    return Pushed(
        wearer=wearer,
        contraction=contraction,
        stiffness=stiffness,
        early=1e3 * float(away[round(PUSHED / DT)]),
        peak=1e3 * float(np.abs(away).max()),
        later=1e3 * float(away[round(0.5 / DT)]),
    )


def _deviation(env: MuscleElbow) -> tuple[Array, float]:
    """Returns where a push moves the elbow of muscles [rad], and its stiffness before."""
    ways = []
    stiffness = 0.0
    for push in (0.0, PUSH):
        env.push = push
        env.reset(seed=0)
        angle = []
        for step in range(round((1.0 + WATCHED) / DT)):
            if step == round(1.0 / DT):
                stiffness = env.stiffness()
            env.step(np.zeros(1, np.float32))
            angle.append(env.data.qpos[0])
        ways.append(np.array(angle[round(1.0 / DT) - 1 :]))
    return ways[1] - ways[0], stiffness


def _net_torque(inertia: float, stiffness: float, damping: float) -> Array:
    """Returns where the push moves a spring and damper with an inertia [rad]."""
    from scipy.integrate import solve_ivp  # slow to import

    def change(time: float, state: Array) -> list[float]:
        push = PUSH if time < PUSHED else 0.0
        return [state[1], (push - stiffness * state[0] - damping * state[1]) / inertia]

    time = np.arange(round(WATCHED / DT) + 1) * DT
    found = solve_ivp(change, (0.0, time[-1]), [0.0, 0.0], t_eval=time, max_step=DT / 5)
    return np.asarray(found.y[0])


def pushed_table(found: Sequence[Pushed]) -> Rows:
    """Returns the table of pushes."""
    header = ["wearer", "co-contraction\n[N·m]", "stiffness\n[N·m/rad]", "after 0.1 s\n[mrad]"]
    rows = [
        [
            *(one.wearer, f"{one.contraction:.0f}", f"{one.stiffness:.1f}"),
            *(f"{value:.0f}" for value in (one.early, one.peak, one.later)),
        ]
        for one in found
    ]
    return [*header, "largest\n[mrad]", "after 0.5 s\n[mrad]"], rows


def cost() -> dict[str, float]:
    """Returns what scoring takes: ms a sample, and seconds for 20 motions of ArmTracking."""
    arm = MyoArm.load()
    with progress("motions", MOTIONS) as bar:
        arms = make_arms(TASK, MOTIONS, gravity="earth", coupling="none")
        motions = rollout(arms, make_policy("none", arms), range(MOTIONS))
        samples = len(motions[0].time)
        demand = demand_of(motions[0], arm, threads=1)
        share_among_muscles(arm, demand, CONVENTIONS[STANDARD])  # compiles
        geometry = seconds(lambda: demand_of(motions[0], arm, threads=1))
        sharing = seconds(lambda: share_among_muscles(arm, demand, CONVENTIONS[STANDARD]))
        begin = time.perf_counter()
        facts: Any = muscle_scores(motions, on_motion=bar.advance).facts
        whole = time.perf_counter() - begin
    return {
        "geometry [ms a sample]": 1e3 * geometry / samples,
        "sharing and power [ms a sample]": 1e3 * sharing / samples,
        "20 motions under all conventions [s]": whole,
        "cores": float(os.cpu_count() or 1),
        "reserve over torque": facts["reserve"],
        "largest reserve [N·m]": facts["largest_reserve"],
        "saturated": facts["saturated"],
    }


def report(json: bool) -> None:
    """Prints all of it."""
    errors, strong, bare, hit = map_errors(), strengths(), bare_arms(), pushes()
    spent = cost()
    if json:
        content = {
            "map": errors,
            "strength": [{**asdict(one), "apart": one.apart} for one in strong],
            "bare": [asdict(one) for one in bare],
            "pushes": [asdict(one) for one in hit],
            "cost": spent,
        }
        print(to_json(content))
        return
    table("MyoArm in our posture, random over the range", *_map_table(errors))
    table("strength of the average man [N·m]", *strength_table(strong))
    table("metabolic power of the bare arm on Earth, above rest", *bare_table(bare))
    table(f"an elbow pushed by {PUSH:g} N·m for {PUSHED:g} s", *pushed_table(hit))
    table("cost", ["what", "value"], [[name, f"{value:.3g}"] for name, value in spent.items()])


def _map_table(errors: dict[str, tuple[float, float]]) -> Rows:
    rows = [[name, *(f"{value:.1f}" for value in values)] for name, values in errors.items()]
    return ["error", "mean", "largest"], rows


def strength_table(found: Sequence[Strength]) -> Rows:
    """Returns the table of strengths; what is more than 30 % apart has a mark."""
    header = ["torque", "degrees", "degrees/s", "muscles", "balanced", "ours", "apart"]
    return header, [list(_strength_cells(one)) for one in found]


def _strength_cells(one: Strength) -> Iterator[str]:
    joint = one.joint.partition("_")[0]
    yield one.way if "abduction" in one.joint else f"{joint} {one.way}"
    yield f"{one.degrees:.0f}"
    yield f"{one.speed:.0f}"
    yield from (f"{value:.0f}" for value in (one.muscles, one.balanced, one.ours))
    yield f"{one.muscles / one.ours - 1:+.0%}" if one.apart else ""


def bare_table(found: Sequence[ArmWork]) -> Rows:
    """Returns the table of the bare arm: power, and its factor to the published value."""
    header = ["arm", *(name.replace(" ", "\n") + " [W]" for name in MODELS), "work\n[W]"]
    rows = []
    for one in found:
        cells = [_with_factor(value, one.published) for value in one.power.values()]
        published = "-" if one.published is None else f"{one.published:.0f}"
        rows.append([one.what, *cells, f"{one.work:.1f}", published, one.source])
    return [*header, "published\n[W]", "source"], rows


def _with_factor(power: float, published: float | None) -> str:
    return (
        f"{round(power) or 0}" if published is None else f"{power:.0f}, x {power / published:.2f}"
    )
