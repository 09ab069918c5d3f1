"""Where can a hand stay without getting tired?

The work envelope of Schmidt (2001, thesis, MIT, and SAE 2001-01-2162) has the hand positions at
which every joint needs less than 15 % of its greatest isometric strength. Here a position counts if
any posture that reaches it takes at most 15 %.

Each column of litres is a condition of the arm, with the torque that is left to the wearer:

| condition | equipment | the wearer gives |
|---|---|---|
| unsuited | nothing; joints as free as a healthy adult's | the weight of the bare arm |
| suited | the suit; joints as free as it lets them | weight and the suit's torque |
| assisted | suit and exoskeleton | what the motors leave |
| unlimited | the same | the same, with motors of any torque |

Shoulder flexion and the elbow have motors, up to their continuous torque and without friction;
abduction and wrist have none. The suit is in its steady cycle: on the loading branch every joint
comes from the lower end of its range, on the unloading branch from the upper one. The column
reached has what the suited arm reaches at any effort, the column lost what can be kept suited but
not assisted. The deviation is the standard error over eight lattices of cubes. The figure has the
conditions in the suit.

The suit costs most of the envelope. The motors give back a part; where assisted and unlimited are
alike, abduction and wrist limit the hand. Most of these postures are beyond the angles at which the
suits were measured; `--measured` keeps every joint inside them. Schmidt also asks that the hand is
visible, and has other joints, so that the litres of both cannot be compared.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import mujoco
import numpy as np
import tyro
from activesuit.assets import JOINTS, load_suit
from activesuit.envs.model import ASSISTED, ArmConfig, Exo, compose, resisting_joints
from activesuit.envs.person import isometric_strength, strength_limits
from activesuit.hysteresis import steady_cycle
from matplotlib.figure import Figure
from numpy.typing import NDArray

Array = NDArray[Any]
CONDITIONS = ("unsuited", "suited", "assisted", "unlimited")
BRANCHES = ("loading", "unloading")
SUSTAINED = 0.15  # share of isometric strength, Schmidt 2001
WRIST_ANGLES = 65
SAMPLES = 201  # angles of a joint at which its torques are tabulated, as many as a cycle has
ROUNDING = 1e-9  # rad, distance by which an angle may miss its range
COLORS = ("#0072b2", "#d55e00", "#009e73")  # of the conditions in the suit


class Arm(NamedTuple):
    """An arm at rest; positions are in the frame of the torso, from the shoulder.

    Attributes:
        model: The MuJoCo model.
        low: Lower end of the range of each joint [rad], shape (4,).
        high: Upper end [rad], shape (4,).
        mass: Mass of each link with all that it wears [kg], shape (4,).
        center: Its center in the frame of the link [m], shape (4, 3).
        lengths: Lengths of the upper arm, of the forearm and from the wrist to the grip [m].
        bent: Direction of the grip from a straight wrist, from down towards forward [rad].
        gravity: Acceleration of free fall [m/s²].
        resistance: Torque of suit and relaxed joint by branch, over the angle [N·m], shape
            (4, samples).
        strength: Least and greatest torque of the wearer over the angle [N·m], shape
            (2, 4, samples).
        motor: Torque up to which a motor takes over [N·m], shape (4,).
    """

    model: mujoco.MjModel
    low: Array
    high: Array
    mass: Array
    center: Array
    lengths: Array
    bent: float
    gravity: float
    resistance: dict[str, Array]
    strength: Array
    motor: Array


def arm_of(suit: str, place: str, condition: str, measured: bool) -> Arm:
    """Returns the arm of the default man under a condition."""
    config = ArmConfig(suit=suit, gravity=place)
    if condition in ("unsuited", "suited"):
        config = replace(config, coupling="none", exo=Exo())
    if condition == "unsuited":
        config = replace(config, suit="none")
    model = compose(config, drawn=False)
    joints = [model.joint(joint).id for joint in JOINTS]
    span = model.jnt_range[joints]
    if measured and condition != "unsuited":
        for name, entry in load_suit(suit).joints.items():
            span[JOINTS.index(name)] = np.clip(entry.range, *span[JOINTS.index(name)])
    angle = np.linspace(span[:, 0], span[:, 1], SAMPLES)
    rest = model.qpos_spring[model.jnt_qposadr[joints]]
    relaxed = (model.jnt_stiffness[joints] * (angle - rest)).T
    resistance = {branch: relaxed.copy() for branch in BRANCHES}
    for name, entry in resisting_joints(config).items():
        joint, start = JOINTS.index(name), (entry.start_angle, entry.start_torque)
        low, high = map(float, span[joint])
        cycle = steady_cycle(entry.model, (low, high), start_angle=start[0], start_torque=start[1])
        resistance["loading"][joint] += cycle.rising
        resistance["unloading"][joint] += cycle.falling
    strength = strength_limits(isometric_strength(config.wearer), angle, np.zeros_like(angle))
    motor = np.zeros(len(JOINTS))
    if condition in ("assisted", "unlimited"):
        for name in ASSISTED:
            torque = config.exo.motors[name].continuous_torque
            motor[JOINTS.index(name)] = torque if condition == "assisted" else np.inf
    return Arm(
        model=model,
        low=span[:, 0],
        high=span[:, 1],
        resistance=resistance,
        strength=np.swapaxes(strength, 1, 2),
        motor=motor,
        **geometry(model, joints),
    )


def geometry(model: mujoco.MjModel, joints: list[int]) -> dict[str, Any]:
    """Returns masses and lengths of a right arm, with all bodies of a link put together."""
    data, links = mujoco.MjData(model), model.jnt_bodyid[joints]
    mujoco.mj_kinematics(model, data)  # the arm hangs straight down
    mass, center = np.zeros(len(links)), np.zeros((len(links), 3))
    for i, link in enumerate(links):
        parts = np.flatnonzero(model.body_weldid == link)
        mass[i] = model.body_mass[parts].sum()
        center[i] = model.body_mass[parts] @ (data.xipos[parts] - data.xpos[link]) / mass[i]
    grip = data.site("hand_grip").xpos - data.xpos[links[3]]
    lengths = -np.diff(data.xpos[links[1:], 2])
    return {
        "mass": mass,
        "center": center,
        "lengths": np.array([*lengths, np.hypot(grip[0], grip[2])]),
        "bent": float(np.arctan2(grip[0], -grip[2])),
        "gravity": -float(model.opt.gravity[2]),
    }


def into_range(angle: Array, low: float, high: float) -> Array:
    """Returns angles plus the full turns that put them into a range, or NaN."""
    turned = low - ROUNDING + (angle - low + ROUNDING) % (2 * np.pi)
    return np.where(turned <= high + ROUNDING, np.clip(turned, low, high), np.nan)


def postures(arm: Arm, points: Array) -> Iterator[tuple[NDArray[np.int64], Array]]:
    """Yields postures for many hand positions at once: their numbers, and joint angles [rad].

    The wrist goes through its angles; shoulder and elbow follow in closed form. Abduction of a
    right arm turns about the axis backward.

    Args:
        arm: The arm.
        points: Hand positions [m], shape (n, 3).
    """
    upper, lower, hand = arm.lengths
    x, y, z = points.T
    across, squared = np.hypot(y, z), (points**2).sum(axis=1)
    for above in (1.0, -1.0):  # the hand is below the shoulder in its plane, or above
        abduction = into_range(-np.arctan2(above * y, -above * z), arm.low[0], arm.high[0])
        toward = np.arctan2(x, above * across)
        for wrist in np.linspace(arm.low[3], arm.high[3], WRIST_ANGLES):
            along = lower + hand * np.cos(arm.bent + wrist)
            beside = hand * np.sin(arm.bent + wrist)
            outer, turned = np.hypot(along, beside), np.arctan2(beside, along)
            cosine = (squared - upper**2 - outer**2) / (2 * upper * outer)
            for side in (1.0, -1.0):
                with np.errstate(invalid="ignore"):  # NaN where the hand cannot be
                    fold = side * np.arccos(cosine)
                rise = np.arctan2(outer * np.sin(fold), upper + outer * np.cos(fold))
                elbow = into_range(fold - turned, arm.low[2], arm.high[2])
                shoulder = into_range(toward - rise, arm.low[1], arm.high[1])
                angle = np.stack([abduction, shoulder, elbow, np.full(len(x), wrist)], axis=1)
                there = np.flatnonzero(np.isfinite(angle).all(axis=1))
                yield there, angle[there]


def weights(arm: Arm, angle: Array) -> Array:
    """Returns the torques that hold up the weight of the arm [N·m], shape (n, 4).

    The links are a chain in a plane that abduction turns, at directions from straight down.

    Args:
        arm: The arm.
        angle: Joint angles [rad], shape (n, 4).
    """
    direction = np.cumsum(np.column_stack([np.zeros(len(angle)), angle[:, 1:]]), axis=1)
    s, c = np.sin(direction), np.cos(direction)
    link = np.array([0, *arm.lengths[:2]])  # between the joints of flexion
    forward, up = np.zeros_like(angle), np.zeros_like(angle)  # of each joint in the plane
    forward[:, 1:] = np.cumsum(link * s[:, :3], axis=1)
    up[:, 1:] = np.cumsum(-link * c[:, :3], axis=1)
    x, y, z = arm.center.T
    ahead, above = forward + c * x - s * z, up + s * x + c * z  # of the center of each link
    aside, upright = np.sin(angle[:, 0]), np.cos(angle[:, 0])
    torque = np.empty_like(angle)
    torque[:, 0] = -aside * (above @ arm.mass) - upright * (y @ arm.mass)
    for joint in range(1, 4):
        lever = ahead[:, joint:] - forward[:, [joint]]
        torque[:, joint] = upright * (lever @ arm.mass[joint:])
    return arm.gravity * torque


def efforts(arm: Arm, angle: Array, weight: Array, branch: str) -> Array:
    """Returns the largest share of isometric strength that any joint of the wearer gives [1]."""
    largest = np.zeros(len(angle))
    for joint in range(4):
        table = np.linspace(arm.low[joint], arm.high[joint], SAMPLES)
        torque = weight[:, joint] + np.interp(angle[:, joint], table, arm.resistance[branch][joint])
        left = torque - np.clip(torque, -arm.motor[joint], arm.motor[joint])
        weakest, strongest = (np.interp(angle[:, joint], table, one[joint]) for one in arm.strength)
        share = left / np.where(left > 0, strongest, weakest)
        largest = np.maximum(largest, share)
    return largest


def envelopes(arm: Arm, points: Array) -> dict[str, Array]:
    """Returns the effort of the easiest posture at each point by branch; inf where none is."""
    found = {branch: np.full(len(points), np.inf) for branch in BRANCHES}
    for there, angle in postures(arm, points):
        weight = weights(arm, angle)
        for branch, least in found.items():
            least[there] = np.minimum(least[there], efforts(arm, angle, weight, branch))
    return found


def error_of_weights(arm: Arm) -> float:
    """Returns the largest difference from MuJoCo's inverse dynamics in 100 postures [N·m]."""
    angle = np.random.default_rng(0).uniform(arm.low, arm.high, (100, 4))
    model, torque = arm.model, np.zeros(arm.model.nv)
    data, joints = mujoco.MjData(model), [model.joint(joint).id for joint in JOINTS]
    largest = 0.0
    for posture, expected in zip(angle, weights(arm, angle), strict=True):
        data.qpos[model.jnt_qposadr[joints]] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_rne(model, data, 0, torque)
        largest = max(largest, np.abs(torque[model.jnt_dofadr[joints]] - expected).max())
    return largest


def litres(kept: NDArray[np.bool_], spacing: float) -> str:
    """Returns a volume with its standard error by the choice of the lattice [l].

    Args:
        kept: Whether a cube counts, shape (2 n, 2 n, 2 n).
        spacing: Edge of a cube [m].
    """
    half = kept.shape[0] // 2
    parts = kept.reshape(half, 2, half, 2, half, 2).sum(axis=(0, 2, 4)) * 8e3 * spacing**3
    return f"{parts.mean():.1f} ± {parts.std(ddof=1) / np.sqrt(8):.1f}"


def draw(volumes: dict[tuple[str, str, str], list[float]]) -> Figure:
    """Draws the volumes that can be kept in the suit [l], a panel for each suit and branch.

    Args:
        volumes: Volumes by suit, place and branch, in the order of `CONDITIONS`.
    """
    suits, places, _ = (list(dict.fromkeys(names)) for names in zip(*volumes, strict=True))
    figure = Figure(figsize=(7, 2.6 * len(suits) + 0.4), layout="constrained")
    panels = figure.subplots(len(suits), len(BRANCHES), squeeze=False, sharex=True, sharey=True)
    for ax, (suit, branch) in zip(panels.flat, product(suits, BRANCHES), strict=True):
        for i, condition in enumerate(CONDITIONS[1:]):
            heights = [volumes[suit, place, branch][i + 1] for place in places]
            at = np.arange(len(places)) + 0.27 * (i - 1)
            ax.bar(at, heights, 0.25, color=COLORS[i], label=condition)
        ax.set_title(f"{suit}, {branch}")
        ax.set_xticks(range(len(places)), places)
        ax.grid(axis="y", alpha=0.3)
    figure.supylabel("volume where a hand can stay [l]")
    lines = panels[0, 0].get_legend_handles_labels()
    figure.legend(*lines, loc="outside upper center", ncols=len(CONDITIONS), frameon=False)
    return figure


def main(
    suits: tuple[str, ...] = ("mock-suit", "emu-like"),
    places: tuple[str, ...] = ("earth", "mars", "moon", "microgravity"),
    spacing: float = 0.04,
    measured: bool = False,
    quick: bool = False,
) -> None:
    """Measure the work envelope: unsuited, suited and assisted.

    Args:
        suits: Names or files of suits.
        places: Names of places, for their gravity.
        spacing: Distance of neighboring hand positions [m].
        measured: Bend the joints of the suits only within the ranges of their files.
        quick: Measure one suit in one place, coarsely.
    """
    if quick:
        suits, places, spacing = suits[:1], places[:1], 0.08
    header = f"{'litres, ' + f'{spacing} m apart':24}{'branch':10}{'reached':>9}"
    print(header + "".join(f"{one:>14}" for one in (*CONDITIONS, "lost")))
    volumes: dict[tuple[str, str, str], list[float]] = {}
    difference = 0.0
    for suit, place in product(suits, places):
        arms = {condition: arm_of(suit, place, condition, measured) for condition in CONDITIONS}
        difference = max(difference, *map(error_of_weights, arms.values()))
        half = int(np.ceil(max(arm.lengths.sum() for arm in arms.values()) / spacing))
        line = (np.arange(-half, half) + 0.5) * spacing
        points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
        found = {
            (condition, branch): effort.reshape(line.size, line.size, line.size)
            for condition, arm in arms.items()
            for branch, effort in envelopes(arm, points).items()
        }
        for branch in BRANCHES:
            kept = {one: found[one, branch] <= SUSTAINED for one in CONDITIONS}
            kept["lost"] = kept["suited"] & ~kept["assisted"]
            litre = 1e3 * spacing**3
            volumes[suit, place, branch] = [kept[one].sum() * litre for one in CONDITIONS]
            reached = np.isfinite(found["suited", branch]).sum() * litre
            row = "".join(f"{litres(one, spacing):>14}" for one in kept.values())
            print(f"{suit:10} {place:13}{branch:10}{reached:9.0f}{row}", flush=True)
    print(f"weights differ from those of MuJoCo by at most {difference:.0e} N·m")
    draw(volumes).savefig("envelope.png", dpi=150)


if __name__ == "__main__":
    tyro.cli(main)
