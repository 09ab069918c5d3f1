"""The arrays on which the kernels of the control cycle work, grouped by what they describe.

Each array of a struct declares its shape and its purpose: `Saved` is state of an episode beside the
state of the physics, which `get_state` returns by name, and `Scratch` is memory of one control
period. `allocated` makes both. All other fields are constants.
"""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_type_hints

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...checks import HIGHEST_SEED
from ...hysteresis.engine import fault_slots
from ..model import ASSISTED
from ..model.config import HEAVIEST_PAYLOAD, LARGEST_MISALIGNMENT
from ..model.cuffs import CUFFS
from ..model.workplace import PUSHES

Struct = TypeVar("Struct")
Whole = NDArray[np.int64]
Bools = NDArray[np.bool_]
Index = int | np.int64
DIVERGENCE = slice(mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC + 1)
MOST = 10**9  # [control periods], greatest count
LARGEST = 1e9  # [SI], more than in any episode; sums stay finite
STRONGEST = 1e4  # [N·m], more than any torque of reflex, correction or learning


class Scratch(NamedTuple):
    """Mark of an array of one control period; `shape` has numbers, and names of sizes."""

    shape: str


class Saved(NamedTuple):
    """Mark of an array of the state of an episode, with its lowest and highest number."""

    shape: str
    low: float = -LARGEST
    high: float = LARGEST


def allocated(kind: type[Struct], sizes: Mapping[str, int], **given: Any) -> Struct:
    """Returns a struct whose arrays are zero, with all other fields as given.

    `sizes` has the names that `Saved` and `Scratch` use.
    """
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if name not in given:
            array, mark = get_args(hint)
            shape = [int(size) if size.isdigit() else sizes[size] for size in mark.shape.split()]
            given[name] = np.zeros(shape, get_args(get_args(array)[1])[0])
    return kind(**given)


def saved(struct: Any) -> dict[str, tuple[NDArray, Saved]]:
    """Returns the arrays of a struct and of its structs that are marked as `Saved`, by name."""
    return dict(_saved(struct))


def _saved(struct: Any) -> Iterator[tuple[str, tuple[NDArray, Saved]]]:
    for name, hint in get_type_hints(type(struct), include_extras=True).items():
        value, marks = getattr(struct, name), getattr(hint, "__metadata__", ())
        if marks and isinstance(marks[0], Saved):
            yield name, (value, marks[0])
        elif isinstance(value, tuple) and not marks:
            yield from _saved(value)


class Physics(NamedTuple):
    """Views of MuJoCo's arrays, with its names; they are valid as long as the batch exists."""

    qpos: Array
    qvel: Array
    qacc: Array
    act: Array
    qfrc_passive: Array
    qfrc_bias: Array
    ctrl: Array
    sensordata: Array
    actuator_force: Array
    biasprm: Array
    warning: Array

    @classmethod
    def of(cls, batch: Batch) -> "Physics":
        """Returns the views of a batch whose rows have impedances of their own."""
        views = {name: batch.bind(name) for name in cls._fields[:-2]}  # the others are no fields
        biasprm = batch.expand("actuator_biasprm")
        return cls(**views, biasprm=biasprm, warning=batch.warning[:, DIVERGENCE, 1])


class Episode(NamedTuple):
    """Counters of the episodes."""

    seed: Annotated[Whole, Saved("n", 0, HIGHEST_SEED)]  # all random numbers of the row follow
    episode: Annotated[Whole, Saved("n", 0, MOST)]  # number of the episode since the seed
    step: Annotated[Whole, Saved("n", 0, MOST)]  # number of control periods since the reset
    limit: Annotated[Whole, Saved("n", 1, MOST)]  # control periods until the episode is truncated
    clipped: Annotated[Whole, Saved("n", 0, MOST)]  # number of actions that were outside [-1, 1]
    diverged: Annotated[Bools, Saved("n", 0, 0)]  # whether the physics has diverged
    dt: float  # control period [s]


class Conditions(NamedTuple):
    """Conditions that were drawn at the reset, where rows have their own."""

    wearer: Annotated[Whole, Saved("n", 0, MOST)]  # number of the wearer
    misalignment: Annotated[Array, Saved("n 3", -LARGEST_MISALIGNMENT, LARGEST_MISALIGNMENT)]  # m
    load: Annotated[Array, Saved("n", 0, HEAVIEST_PAYLOAD)]  # mass at the hand [kg]
    free_fall: Annotated[Array, Saved("n", 0, 1000)]  # acceleration of free fall [m/s²]
    carried: Annotated[Array, Saved("n masses", 0, HEAVIEST_PAYLOAD)]  # by sample [kg]
    push: Annotated[Array, Saved("n pushes 3")]  # force on the grip at every sample [N]


class Motions(NamedTuple):
    """Motions of the joints."""

    angle: Annotated[Array, Saved("n samples 4", -2 * math.pi, 2 * math.pi)]  # rad
    rate: Annotated[Array, Saved("n samples 4")]  # rad/s
    acceleration: Annotated[Array, Saved("n samples 4")]  # rad/s²


class Intention(NamedTuple):
    """Intended motion of the wearer, and learned torques; without samples if none are learned."""

    motion: Motions
    learned_torque: Annotated[Array, Saved("n learned 4", -STRONGEST, STRONGEST)]  # N·m
    learned_contraction: Annotated[
        Array, Saved("n learned 4")
    ]  # beyond the usual contraction [N·m]


class BareArm(NamedTuple):
    """Inertia of the wearers' bare arms, and the torque that moves them."""

    links: Array  # links of `Chain`, (n, 4, 19)
    gravity: Array  # acceleration of free fall in the frame of the torso [m/s²], (n, 3)
    torque: Array  # result [N·m], (n, 4)
    scratch: Array  # (n, 4, 8)


class Muscles(NamedTuple):
    """Strength, impedance and fatigue of the muscle groups."""

    fatigued: Annotated[Array, Saved("n 2 4", -1e-9, 1 + 1e-9)]  # fatigued part of each group
    strength: Array  # isometric strength [N·m], (n, 2, 4)
    impedance: Array  # result of `VoluntaryControl.impedance`, (n, 5, 4)
    tires: bool  # whether effort tires the wearers


class Learning(NamedTuple):
    """The torque that wearers learn from episode to episode."""

    gains: Annotated[Array, Saved("n 4 gains", -STRONGEST, STRONGEST)]  # features to torque
    next_gains: Annotated[Array, Saved("n 4 gains", -STRONGEST, STRONGEST)]  # of the next episode
    features: Annotated[Array, Scratch("n 4 features")]  # features of the intended motion
    rate: float  # share of the missing torque that one control period adds
    forgetting: float
    ahead: int  # control periods by which the learned torque precedes the error


class Persistence(NamedTuple):
    """What a persistent wearer adds to the correction; the array is empty where none is."""

    # Rows: time without approach [s], time since the intention rests [s], whether the wearer
    # pushes or lets go, side of the push, torque of pushes [N·m], this torque before a push or
    # after letting go [N·m], greatest error of the push [rad], share of the gain that swings have
    # taken, last side of the seen error, co-contraction [N·m].
    persistence: Annotated[Array, Saved("n persistence 4")]
    friction: Array  # dry friction of the gears, which the wearer knows [N·m], (4,)
    dt: float  # control period [s]
    late: int  # age of the error that is felt [control periods]
    window: int  # control periods over which its rate is felt
    still: float  # rad/s
    wait: float  # s
    rest: float  # s
    pace: float  # of the friction per s
    most: float  # of the friction
    ahead: float  # s
    release: float  # N·m/s
    fade: float  # s
    calm: float  # share of the gain that one swing leaves
    recovery: float  # s
    stiffening: float  # N·m/(rad·s)
    relaxing: float  # s
    hardest: float  # greatest co-contraction, of strength


class Feedback(NamedTuple):
    """The wearer's reflex and voluntary correction; delays are rings by step."""

    reflex: Annotated[Array, Saved("n 4", -STRONGEST, STRONGEST)]  # torque of the reflex [N·m]
    correction: Annotated[Array, Saved("n 4", -STRONGEST, STRONGEST)]  # torque [N·m]
    reflex_delay: Annotated[Array, Saved("n reflex_delay 4")]  # inputs of the reflex [N·m]
    correction_goals: Annotated[Array, Saved("n 3 4")]  # its last goals [N·m], latest first
    correction_delay: Annotated[Array, Saved("n sight 4")]  # errors [rad]
    needed: Annotated[Array, Scratch("n 4")]  # torque beside the feed-forward torque [N·m]
    reflex_gain: float
    lead: float  # s
    lag: float  # share of a change that the muscle follows in one control period
    correction_gain: float  # share of the error that one correction removes
    correction_periods: int  # control periods between two corrections, and of each
    least: float  # least error that is corrected [rad]
    late: float  # time by which the intention may be late [s]
    persistence: Persistence


class MuscleNoise(NamedTuple):
    """Noise and tremor of the muscles."""

    muscle_noise: Annotated[Array, Saved("n 3 4")]  # noise, tremor, its quadrature, variance 1
    muscle_draws: Annotated[Array, Saved("n muscle_draws 3 4")]  # random numbers, if there is noise
    recursion: Array  # coefficients of `noise_constants`, (6,)
    noise: float  # share of the torque
    tremor: float


class Wearer(NamedTuple):
    """The wearer's control of the arm, without the muscles."""

    arm: BareArm
    feedback: Feedback
    learning: Learning
    noise: MuscleNoise


class Motors(NamedTuple):
    """The motors of the exoskeleton."""

    command: Annotated[Array, Saved("n motors", -1, 1)]  # last action
    change: Annotated[Array, Saved("n motors", -2, 2)]  # its change since the action before
    mean_square: Annotated[Array, Saved("n motors", 0)]  # mean square of the torques [N²·m²]
    ratings: Array  # peak and continuous torque [N·m], time constant of heat [s], (3, motors)
    fails: Array  # time from which a motor has no power [s], (motors,)


class Sensors(NamedTuple):
    """Measurements, and the sensors without noise."""

    measured: Annotated[Array, Saved("n measurements")]  # last valid measurements
    encoder_counts: Annotated[Array, Saved("n 4")]  # counts that the encoders showed last
    encoder_offset: Annotated[Array, Saved("n 4", -1, 1)]  # error of the encoders' zeros [rad]
    dissipated_at_reset: Annotated[Array, Saved("n")]  # energy that the suit had dissipated [J]
    preview: Whole  # look-ahead of the target [samples], (3,)
    resolution: float  # angle of one count of the encoders [rad]
    smoothing: float  # low-pass of the rates


class NoisySensors(NamedTuple):
    """Sensors at the cuffs and on the person."""

    noise_scale: Annotated[Array, Saved("n", 0, 100)]  # factor of the noise
    sensor_draws: Annotated[Array, Saved("n sensor_draws noises")]  # random numbers; none: not used
    interaction_delay: Annotated[Array, Saved("n interaction_delay 4")]  # torques [N·m], a ring
    present: Annotated[Motions, Scratch("")]  # the present motion of the arm, one sample
    interaction_noise: float
    cuff_noise: float  # N
    emg_noise: float
    emg_lead: int  # samples
    emg_smoothing: float


class Reception(NamedTuple):
    """Readings of sensors on their way to the controller, where something fails."""

    sent: Annotated[Array, Saved("n received")]  # last readings of the sensors
    fault_draws: Annotated[Array, Saved("n fault_draws 2")]  # random numbers; none: not used


class Addresses(NamedTuple):
    """Addresses in mjData, in the order of `JOINTS` (4) or `ASSISTED` (2).

    The arrays of motors are empty without an exoskeleton, and those of cuff forces without cuffs.
    """

    joints: Whole  # angles of the arm in qpos, and rates in qvel (all joints are hinges), (4,)
    exo_joints: Whole  # angles of the exoskeleton in qpos, those of the arm if rigid, (4,)
    driven: Whole  # angles of the exoskeleton's joints that carry a motor, (2,)
    assisted: Whole  # positions of the assisted joints in `JOINTS`, (2,)
    human: Whole  # torques of the wearer in actuator_force, (4,)
    intention: Whole  # controls of the wearer: position, velocity, feed-forward, (3, 4)
    encoders: Whole  # angles of the encoders in sensordata, (4,)
    assist: Whole  # torques of the motors in actuator_force, (2,)
    motors: Whole  # controls of the motors, which are torques [N·m], (2,)
    peak_torque: Array  # largest torque of each motor [N·m], (2,)
    pushes: Whole  # controls of the forces on the grip, (3,); none where a task has none
    hand: Whole  # place of the grip in sensordata, (3,)
    cuffs: Whole  # forces on upper arm, forearm and hand in sensordata, (9,)
    # A joint occurs once for each kind of model that its suit may have, of which one is active.
    suited: Whole  # positions in `JOINTS` of the joints that suits resist, (n,)
    suit_torque: Whole  # torques of these models in sensordata, (n,)
    dissipated: Whole  # energies that they have dissipated in sensordata, (n,)
    faults: Whole  # fault flags of these models in plugin_state, (n,)

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "Addresses":
        """Returns the addresses of a model, which are found by name."""
        actuators = {model.actuator(i).name: i for i in range(model.nactuator)}
        sensors = {model.sensor(i).name: model.sensor_adr[i] for i in range(model.nsensor)}
        joints = {model.joint(i).name: model.jnt_qposadr[i] for i in range(model.njnt)}
        human = [actuators[f"human_{joint}"] for joint in JOINTS]
        motors = [f"assist_{joint}" for joint in ASSISTED]
        assist = _indices(actuators[motor] for motor in motors if motor in actuators)
        cuffs = [f"cuff_{segment}_force" for segment in CUFFS]
        forces = _indices(sensors[cuff] for cuff in cuffs if cuff in sensors)
        found = [re.fullmatch(r"(.*)(_suit(?:_\d+)?)_torque", sensor) for sensor in sensors]
        resisting = sorted((JOINTS.index(match[1]), match[2]) for match in found if match)
        suits = [f"{JOINTS[i]}{suit}" for i, suit in resisting]
        exo_joints = _indices(joints.get(f"exo_{joint}", joints[joint]) for joint in JOINTS)
        assisted = _indices(JOINTS.index(joint) for joint in ASSISTED)
        return cls(
            joints=_indices(joints[joint] for joint in JOINTS),
            exo_joints=exo_joints,
            driven=exo_joints[assisted],
            assisted=assisted,
            human=_indices(human),
            intention=_indices(model.actuator_ctrladr[human]) + np.arange(3)[:, None],
            encoders=_indices(sensors[f"encoder_{joint}"] for joint in JOINTS),
            assist=assist,
            motors=_indices(model.actuator_ctrladr[assist]),
            peak_torque=model.actuator_forcerange[assist, 1],
            pushes=_indices(
                model.actuator_ctrladr[actuators[push]] for push in PUSHES if push in actuators
            ),
            hand=sensors["hand_position"] + np.arange(3),
            cuffs=(forces[:, None] + np.arange(3)).ravel(),
            suited=_indices(i for i, _ in resisting),
            suit_torque=_indices(sensors[f"{suit}_torque"] for suit in suits),
            dissipated=_indices(sensors[f"{suit}_dissipated_energy"] for suit in suits),
            faults=fault_slots(model),
        )


class Arms(NamedTuple):
    """Everything on which the kernels of the control cycle work."""

    physics: Physics
    at: Addresses
    episode: Episode
    intention: Intention
    wearer: Wearer
    muscles: Muscles
    motors: Motors
    sensors: Sensors
    noisy: NoisySensors


def _indices(values) -> Whole:
    return np.array(list(values), dtype=np.int64)
