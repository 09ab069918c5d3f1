"""The arrays on which the kernels of the control cycle work, grouped by what they describe.

Each array has the row as its first index, unless its line says otherwise. Those marked `SAVED` are
the state of an episode beside the state of the physics: `get_state` returns them by name. The
others are constants, or scratch memory of one control period.
"""

import re
from typing import Annotated, Any, NamedTuple, get_type_hints

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...hysteresis.engine import fault_slots
from ..model import ASSISTED
from ..model.cuffs import CUFFS
from ..model.workplace import PUSHES

Whole = NDArray[np.int64]
Bools = NDArray[np.bool_]
Index = int | np.int64
SAVED = "saved"  # mark of an array that belongs to the state of an episode
SCRATCH = "scratch"  # mark of a struct whose arrays do not
DIVERGENCE = slice(mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC + 1)


class Physics(NamedTuple):
    """Views of MuJoCo's arrays, with its names."""

    qpos: Array
    qvel: Array
    qacc: Array
    qfrc_passive: Array
    qfrc_bias: Array
    ctrl: Array
    biasprm: Array
    sensordata: Array
    actuator_force: Array
    warning: Array

    @classmethod
    def of(cls, batch: Batch) -> "Physics":
        """Returns the views of a batch whose rows have impedances of their own."""
        fields = ("qpos", "qvel", "qacc", "qfrc_passive", "qfrc_bias", "ctrl")
        views = {name: batch.bind(name) for name in (*fields, "sensordata", "actuator_force")}
        biasprm = batch.expand("actuator_biasprm")
        return cls(**views, biasprm=biasprm, warning=batch.warning[:, DIVERGENCE, 1])


class Episode(NamedTuple):
    """Counters of the episodes."""

    seed: Annotated[Whole, SAVED]  # seed of the row, from which all its random numbers follow
    episode: Annotated[Whole, SAVED]  # number of the episode since the row was seeded
    step: Annotated[Whole, SAVED]  # number of control periods since the reset
    limit: Annotated[Whole, SAVED]  # control periods after which the episode is truncated
    clipped: Annotated[Whole, SAVED]  # number of actions that were outside [-1, 1]
    diverged: Annotated[Bools, SAVED]  # whether the physics has diverged
    dt: float  # control period [s]


class Conditions(NamedTuple):
    """Conditions that were drawn at the reset, where rows have their own."""

    wearer: Annotated[Whole, SAVED]  # number of the wearer
    misalignment: Annotated[Array, SAVED]  # exoskeleton's displacement [m], (n, 3)
    load: Annotated[Array, SAVED]  # mass at the hand [kg]
    free_fall: Annotated[Array, SAVED]  # acceleration of free fall [m/s²]
    carried: Annotated[Array, SAVED]  # mass at the hand at every sample [kg], (n, samples)
    push: Annotated[Array, SAVED]  # force on the grip at every sample [N], (n, samples, 3)


class Motions(NamedTuple):
    """Motions of the joints, shape (n, samples, 4)."""

    angle: Annotated[Array, SAVED]  # rad
    rate: Annotated[Array, SAVED]  # rad/s
    acceleration: Annotated[Array, SAVED]  # rad/s²


class Intention(NamedTuple):
    """Intended motion of the wearer, and what was learned for it; without samples for nothing."""

    motion: Motions
    learned_torque: Annotated[Array, SAVED]  # N·m, (n, samples, 4)
    learned_contraction: Annotated[Array, SAVED]  # beyond the usual one [N·m], (n, samples, 4)


class BareArm(NamedTuple):
    """Inertia of the wearers' bare arms, and the torque that moves them."""

    links: Array  # links of `Chain`, (n, 4, 19)
    gravity: Array  # acceleration of free fall in the frame of the torso [m/s²], (n, 3)
    torque: Array  # result [N·m], (n, 4)
    scratch: Array  # (n, 4, 8)


class Muscles(NamedTuple):
    """Strength, impedance and fatigue of the muscle groups."""

    fatigued: Annotated[Array, SAVED]  # fatigued part of each group, (n, 2, 4)
    strength: Array  # isometric strength [N·m], (n, 2, 4)
    impedance: Array  # result of `VoluntaryControl.impedance`, (n, 5, 4)
    tires: bool  # whether effort tires the wearers


class Learning(NamedTuple):
    """The torque that wearers learn from episode to episode."""

    gains: Annotated[Array, SAVED]  # features to torque, (n, 4, FEATURES); none: no learning
    next_gains: Annotated[Array, SAVED]  # gains as learned so far, used from the next episode on
    features: Array  # features of the intended motion, (n, 4, FEATURES)
    rate: float  # share of the missing torque that one control period adds
    forgetting: float
    ahead: int  # control periods by which the learned torque precedes the error


class Feedback(NamedTuple):
    """The wearer's reflex and voluntary correction."""

    reflex: Annotated[Array, SAVED]  # torque of the reflex [N·m], (n, 4)
    correction: Annotated[Array, SAVED]  # torque of the correction [N·m], (n, 4)
    reflex_delay: Annotated[Array, SAVED]  # inputs of the reflex [N·m], ring by step, (n, delay, 4)
    correction_goals: Annotated[Array, SAVED]  # its last three goals [N·m], latest first, (n, 3, 4)
    correction_delay: Annotated[Array, SAVED]  # errors [rad], ring by step, (n, delay, 4)
    needed: Array  # torque beside the feed-forward torque [N·m], (n, 4)
    reflex_gain: float
    lead: float  # s
    lag: float  # share of a change that the muscle follows in one control period
    correction_gain: float  # share of the error that one correction removes
    correction_periods: int  # control periods between two corrections, and of each
    least: float  # least error that is corrected [rad]
    late: float  # time by which the intention may be late [s]


class MuscleNoise(NamedTuple):
    """Noise and tremor of the muscles."""

    muscle_noise: Annotated[Array, SAVED]  # noise, tremor, its quadrature, variance 1, (n, 3, 4)
    muscle_draws: Annotated[Array, SAVED]  # random numbers, (n, STRETCH, 3, 4); none without noise
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

    command: Annotated[Array, SAVED]  # last action, (n, motors)
    change: Annotated[Array, SAVED]  # its change since the action before, (n, motors)
    mean_square: Annotated[Array, SAVED]  # mean square of the torques [N²·m²], (n, motors)
    ratings: Array  # peak and continuous torque [N·m], time constant of heat [s], (3, motors)


class Sensors(NamedTuple):
    """Measurements, and the sensors without noise."""

    measured: Annotated[Array, SAVED]  # last valid measurements, (n, WIDTH)
    encoder_counts: Annotated[Array, SAVED]  # counts that the encoders showed last, (n, 4)
    encoder_offset: Annotated[Array, SAVED]  # error of the encoders' zeros [rad], (n, 4)
    dissipated_at_reset: Annotated[Array, SAVED]  # energy that the suit had dissipated [J]
    preview: Whole  # look-ahead of the target [samples], (3,)
    resolution: float  # angle of one count of the encoders [rad]
    smoothing: float  # low-pass of the rates


class NoisySensors(NamedTuple):
    """Sensors at the cuffs and on the person."""

    noise_scale: Annotated[Array, SAVED]  # factor of the noise
    sensor_draws: Annotated[Array, SAVED]  # random numbers, (n, STRETCH, NOISES); none: not used
    interaction_delay: Annotated[Array, SAVED]  # torques [N·m], ring by step, (n, delay + 1, 4)
    present: Annotated[Motions, SCRATCH]  # the present motion of the arm, one sample
    interaction_noise: float
    cuff_noise: float  # N
    emg_noise: float
    emg_lead: int  # samples
    emg_smoothing: float


class Reception(NamedTuple):
    """Readings of sensors on their way to the controller, where something fails."""

    sent: Annotated[Array, SAVED]  # last readings of the sensors, (n, columns of `RECEIVED`)
    fault_draws: Annotated[Array, SAVED]  # random numbers, (n, STRETCH, 2); none: not used


class Equilibrium(NamedTuple):
    """The search for the equilibrium at the start of an episode."""

    torque: Array  # net torque on the arm at rest, without the wearer's [N·m], (n, dofs)
    motor: Array  # torques of the motors [N·m], (n, motors)


def saved(struct: Any) -> dict[str, NDArray]:
    """Returns the arrays of a struct that are marked as `SAVED`, also within others, by name."""
    found: dict[str, NDArray] = {}
    for name, hint in get_type_hints(type(struct), include_extras=True).items():
        value = getattr(struct, name)
        marks = getattr(hint, "__metadata__", ())
        if SAVED in marks:
            found[name] = value
        elif isinstance(value, tuple) and SCRATCH not in marks:
            found |= saved(value)
    return found


class Addresses(NamedTuple):
    """Whole into mjData, in the order of `JOINTS` (4) or `ASSISTED` (2).

    The arrays of motors are empty without an exoskeleton, and those of cuff forces without cuffs.
    """

    joints: Whole  # angles of the arm in qpos, and rates in qvel (all joints are hinges), (4,)
    exo_joints: Whole  # angles of the exoskeleton in qpos, those of the arm if it is rigid, (4,)
    driven: Whole  # those of the exoskeleton's joints that carry a motor, (2,)
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


def _indices(values) -> Whole:
    return np.array(list(values), dtype=np.int64)
