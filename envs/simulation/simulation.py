"""Arms with their wearers and motors, one or a thousand, in one batch of MuJoCo."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import AnyArray, Array
from ...assets import JOINTS, SuitJoint
from ...errors import InputError
from ...hysteresis.engine import replace_model, take_off
from ..model import GRAVITY, ArmConfig, Payload, bare_arm, resisting_joints, start_encoders
from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import Edits
from ..person import VoluntaryControl
from ..person.control import NOISE_SIZE, noise_constants, sight_periods
from ..person.fatigue import RATES
from ..person.strength import SHAPE
from . import settling
from .addresses import Addresses
from .bound import bound
from .cycle import after, before
from .differing import Differing, Variety
from .inverse_dynamics import arm_torques
from .kinematics import Arm
from .measurements import COLUMNS
from .memory import STRETCH, Memory
from .plan import Plan, checked_plan
from .sensing import Sensing, sense, smoothing
from .streams import stream
from .wearer import FEATURES

Rows = NDArray[np.int64]

VELOCITIES = mujoco.mjtStage.mjSTAGE_VEL.value
NOTHING = mujoco.mjtStage.mjSTAGE_NONE.value
DIVERGENCE = slice(mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC + 1)
PREVIEW = (0.02, 0.1, 0.24)  # [s], look-ahead times of the target in the observation


@dataclass(frozen=True, eq=False)
class Start:
    """Start of an episode of one row.

    Attributes:
        plan: Intended motion of the wearer, and loads on the hand.
        suit: Joints of the wearer's suit; None is the compiled one.
        encoder_offset: Error of the encoders' zeros [rad], shape (4,).
        payload: Load at the hand; None is that of the configuration.
        gravity: Name of the place; None is that of the configuration.
        wearer: Number of the wearer.
        misalignment: Displacement of the exoskeleton from its configured position [m], shape (3,).
        loudness: Factor of the noise of sensors.
        taught: Learned torque of the wearer, added to that of the bare arm [N·m], shape
            (samples, 4); None means no such torque.
    """

    plan: Plan
    suit: Mapping[str, SuitJoint] | None
    encoder_offset: Array
    payload: Payload | None
    gravity: str | None
    wearer: int
    misalignment: Array
    loudness: float
    taught: Array | None


class Posture(NamedTuple):
    """Time and pose of a row, from which its picture is drawn.

    Attributes:
        time: Simulated time [s].
        position: Position `qpos` of the physics.
        loaded: Whether the hand carries the task's load.
    """

    time: float
    position: Array
    loaded: bool


class Simulation:
    """Simulates rows of arms, without task and reward.

    Each row is an arm with its suit, exoskeleton and wearer. A control period is `before`, the
    physics of all rows, and `after` (see `cycle`). Row i is the same to the last bit whatever the
    other rows do, for any number of rows and threads.

    Args:
        config: Configuration of the arms.
        n: Number of rows.
        samples: Number of samples of an intention.
        control_dt: Control period [s].
        control: The wearer's control of the arm.
        fatigue: Whether effort tires the wearers.
        sensing: Noise, delay and bandwidth of sensors.
        noisy: Whether the sensors that have noise are read, which takes time.
        variety: What may differ between rows.
        edits: What a task adds to the model.
        carries: Whether loads change during an episode; rows then may have loads of their own.
        taught: Whether wearers take a learned torque.
        threads: Number of threads; 0 uses all cores.

    Attributes:
        model: MuJoCo model of a row, without drawings.
        memory: State of the episodes, beside the state of the physics.
        addresses: Addresses of the model.
        suit: Joints that the compiled suit resists, at its operating pressure.
        ranges: Ranges of the bare arm's joints [rad], shape (4, 2); intentions stay inside.
        columns: Columns of `memory.measured` that these arms have, by name.
        batch: The physics.
        plugin_state: State of the suits, a view of shape (n, size).
        sensordata: Sensors of the physics, a view of shape (n, size).
    """

    def __init__(
        self,
        config: ArmConfig,
        n: int,
        *,
        samples: int,
        control_dt: float,
        control: VoluntaryControl,
        fatigue: bool,
        sensing: Sensing,
        noisy: bool,
        variety: Variety,
        edits: Edits | None,
        carries: bool,
        taught: bool,
        threads: int,
    ) -> None:
        self.config, self.control, self.fatigue = config, control, fatigue
        self.sensing, self._noisy = sensing, noisy
        self._differing, self._variety = Differing(config, variety, edits), variety
        self._carries = carries
        self.model = self._differing.model
        self.n, self.samples, self.control_dt = n, samples, control_dt
        self.substeps = round(control_dt / config.timestep)
        self.addresses = Addresses.of(self.model)
        self._pushed = self.addresses.pushes.size > 0
        self.ranges = bare_arm(config).jnt_range
        self.suit = resisting_joints(config)
        self._joints = set(self.suit).union(*(suit.joints for suit in variety.suits))
        self.memory = Memory.empty(
            n,
            samples=samples,
            motors=self.addresses.motors.size,
            delay=round(control.delay / control_dt),
            sight=sight_periods(control_dt),
            taught=taught,
            learns=control.learns,
            noisy=control.noise > 0 or control.tremor > 0,
            felt=round(sensing.interaction_delay / control_dt) if noisy else None,
            carries=carries,
            pushed=self._pushed,
        )
        self._is_noisy = noisy or self.memory.fresh.size > 0
        self.columns = self._measured_columns()
        self._all, self._waiting = np.arange(n), set[int]()
        self._begin_physics(threads)

    # --- Episodes -----------------------------------------------------------------------------

    def begin(self, rows: Rows, start_of: Callable[[int], Start]) -> None:
        """Begins an episode in some rows: rested wearers hold their first intended posture.

        The posture is in equilibrium: the slow correction starts at the torque that the
        feed-forward torque lacks. Strength does not limit it there: a wearer who is too weak drops
        the arm afterwards. At the first step the motors start at the commanded torque and the
        wearer at the remainder, so that there is no start-up transient. Seeds and numbers of the
        episodes must be in `memory` before the call.

        Args:
            rows: The rows, shape (k,).
            start_of: Function that returns the start of the episode of a row.

        Raises:
            InputError: A motion has other shapes, is not finite or leaves the range of a joint; the
                rows then need another reset.
        """
        memory = self.memory
        memory.clear(rows)
        memory.gains[rows] = memory.growing[rows]
        self.batch.reset(self._ids(rows), stage=NOTHING)
        for row in rows.tolist():
            start = start_of(row)
            plan = self.checked(start.plan)
            memory.angle[row], memory.rate[row], memory.acceleration[row] = plan.motion
            memory.offset[row], memory.loudness[row] = start.encoder_offset, start.loudness
            memory.wearer[row], memory.misalignment[row] = start.wearer, start.misalignment
            self._differing.strap(self.plugin_state[row], start.wearer, start.misalignment)
            memory.load[row] = (start.payload or self.config.payload).mass
            if self._carries:
                memory.carried[row] = memory.load[row] + (0.0 if plan.mass is None else plan.mass)
                heaviest = memory.carried[row].max()
                if heaviest > HEAVIEST_PAYLOAD:
                    raise InputError(
                        f"payload and the task's load are {heaviest:.3g} kg together: stay within "
                        f"{HEAVIEST_PAYLOAD:g} kg"
                    )
                memory.load[row] = memory.carried[row, 0]
            if plan.push is not None:
                memory.push[row] = plan.push
            if memory.watched.shape[1]:
                memory.watched[row] = False if plan.watched is None else plan.watched
                memory.places[row] = self.arm_of(start.wearer).in_world(plan.motion[0])
            if start.gravity is not None:
                memory.fall[row] = GRAVITY[start.gravity]
            if start.suit is not None:
                self._put_on(row, start.suit)
            if start.taught is not None:
                memory.taught[row] = start.taught
        self._write_differences(rows)
        self._motor[rows] = 0.0
        self._settle(rows)
        self._waiting.update(rows.tolist())
        if self.config.exo.encoder_delay > 0:
            self._fill_encoders(rows)
        self.batch.forward(self._ids(rows))
        self._after(rows, False)
        if self._sense:
            self._sense(rows, False)

    def step(self, action: Array, rows: Rows | None = None) -> None:
        """Moves some rows by one control period.

        Args:
            action: Torque of the motors over their peaks, shape (n, motors); values beyond [-1, 1]
                are clipped and counted.
            rows: The rows that move; by default all.

        Raises:
            InputError: An action is not of finite numbers; nothing has changed.
        """
        moving = self._all if rows is None else rows
        if self._waiting:
            self._take_over(action, moving)
        if self._is_noisy:
            self._draw_noise(moving)
        if self._carries:
            self._exchange(moving)
        if self._pushed:
            self._push(moving)
        bad = self._before(moving, action)
        if bad >= 0:
            place = f"action of row {bad}" if self.n > 1 else "action"
            raise InputError(f"{place} is {action[bad].tolist()}: give finite numbers from -1 to 1")
        self.batch.step(ids=rows, nstep=self.substeps, stage=VELOCITIES)
        self._after(moving, True)
        if self._sense:
            self._sense(moving, True)

    def checked(self, plan: Plan) -> Plan:
        """Returns a plan that these arms can carry out; raises an InputError otherwise."""
        carries, pushes = self._carries, self._pushed
        return checked_plan(plan, self.samples, self.ranges, carries=carries, pushes=pushes)

    def arm_of(self, wearer: int) -> Arm:
        """Returns the bare arm of the wearer with a number."""
        return self._differing.arms[wearer]

    def own_torque(self, rows: Rows) -> Array:
        """Returns the torque that moves the bare arms along their intentions [N·m].

        Args:
            rows: The rows, shape (k,).

        Returns:
            The torques, shape (k, samples, 4).
        """
        memory, found = self.memory, np.empty((len(rows), self.samples, len(JOINTS)))
        for row, torque in zip(rows.tolist(), found, strict=True):
            motion = (memory.angle[row], memory.rate[row], memory.acceleration[row])
            chain = self._differing.chains[memory.wearer[row]]
            torque[:] = arm_torques(replace(chain, gravity=self._gravity[row, None]), *motion)
        return found

    def measured(self, name: str) -> Array:
        """Returns a view of one measurement of all rows, shape (n, size)."""
        return self.memory.measured[:, COLUMNS[name]]

    # --- State --------------------------------------------------------------------------------

    def state(self, rows: Rows) -> dict[str, NDArray]:
        """Returns physics and memory of some rows, as new arrays with a leading axis of rows."""
        arrays = {"physics": self.batch.state, **self.memory.arrays()}
        return {name: values[rows] for name, values in arrays.items()}

    def restore(self, rows: Rows, state: dict[str, NDArray]) -> None:
        """Restores what `state` returned, in as many rows; they then continue bit for bit."""
        self.batch.reset(rows, stage=NOTHING)
        self.batch.state[rows] = state["physics"]
        for name, values in self.memory.arrays().items():
            values[rows] = state[name]
        self._write_differences(rows)
        self._waiting.difference_update(rows.tolist())
        self._waiting.update(rows[self.memory.step[rows] == 0].tolist())
        self.batch.forward(rows, stage=VELOCITIES)

    def data(self, row: int, into: mujoco.MjData | None = None) -> mujoco.MjData:
        """Returns the physics of a row, for reading, in `into` or in a new MjData of `model`."""
        return self.batch.get_data(row, into)

    def posture_of(self, row: int) -> Posture:
        """Returns time and pose of a row, for a picture."""
        carried = self.memory.carried[row]
        loaded = carried.size > 0 and self.memory.load[row] > carried.min()
        return Posture(float(self._time[row]), self._qpos[row].copy(), bool(loaded))

    # --- Parts --------------------------------------------------------------------------------

    def _measured_columns(self) -> dict[str, slice]:
        at = self.addresses
        absent = set() if at.cuffs.size else {"cuff_force", "cuff_sensor"}
        if not self.fatigue:
            absent.add("fatigue")
        if not self._noisy:
            absent |= {"interaction_torque", "emg", "cuff_sensor"}
        if not at.motors.size:
            absent |= {"motor_load", "motor_torque", "previous_action"}
        return {name: part for name, part in COLUMNS.items() if name not in absent}

    def _begin_physics(self, threads: int) -> None:
        # An MjData takes 165 KB whatever the model, so that rows share those of the threads.
        batch = self.batch = Batch(self.model, self.n, nthread=threads, persistent=self.n == 1)
        batch.reset()
        self._differing.begin(batch)
        bound = ("time", "qpos", "qvel", "act", "ctrl", "sensordata", "actuator_force")
        bound = (*bound, "plugin_state")
        physics = {name: batch.bind(name) for name in bound}
        self._time, self._qpos, self._ctrl = physics["time"], physics["qpos"], physics["ctrl"]
        self._current = physics["act"]
        self.plugin_state, self.sensordata = physics["plugin_state"], physics["sensordata"]
        physics |= {name: batch.bind(name) for name in ("qfrc_passive", "qfrc_bias", "qacc")}
        physics["bias"] = batch.expand("actuator_biasprm")
        physics["warning"] = batch.warning[:, DIVERGENCE, 1]
        names = {**vars(self.addresses), **self.memory.arrays(), **physics, **self._constants()}
        chain = self._differing.chains[0]
        for name in ("links", "gravity"):
            names[name] = np.repeat(getattr(chain, name), self.n, axis=0)
        self._links, self._gravity = names["links"], names["gravity"]
        self._strength, self._impedance = names["strength"], names["impedance"]
        self._torque, self._motor = names["torque"], names["motor"]
        self._free = np.setdiff1d(self.addresses.exo_joints, self.addresses.joints)
        rows, action = self._all, np.empty((self.n, self.addresses.motors.size))
        self._begin_rest = _bound(settling.begin, names, rows)
        self._imbalance = _bound(settling.imbalance, names, rows)
        self._hold = _bound(settling.hold, names, rows)
        self._before = _bound(before, names, rows, action)
        self._after = _bound(after, names, rows, True)
        self._sense = _bound(sense, names, rows, True) if self._noisy else None

    def _constants(self) -> dict[str, Any]:
        n, config, dt = self.n, self.config, self.control_dt
        motors = list(config.exo.motors.values())[: self.addresses.motors.size]
        impedance = self._impedance_of(0)
        continuous = [motor.continuous_torque for motor in motors]
        heating = [motor.thermal_time_constant for motor in motors]
        return {
            "scratch": np.empty((n, len(JOINTS), 8)),
            "own": np.zeros((n, len(JOINTS))),
            "strength": np.tile(self._differing.strengths[0], (n, 1, 1)),
            "rested": np.zeros((n, 2, len(JOINTS))),
            "shape": SHAPE,
            "impedance": np.tile(impedance, (n, 1, 1)),
            "features": np.zeros((n, len(JOINTS), FEATURES)),
            "answer": np.zeros((n, len(JOINTS))),
            "torque": np.zeros((n, self.model.nq)),
            "motor": np.zeros((n, self.addresses.motors.size)),
            **self.control.habits(dt),
            "spread": NOISE_SIZE,
            "ringing": noise_constants(dt),
            "ratings": np.array([self.addresses.peak_torque, continuous, heating]),
            "rates": np.array(RATES),
            "ahead": np.array([round(ahead / dt) for ahead in PREVIEW]),
            "count": math.tau / 2**config.exo.encoder_bits,
            "smoothing": smoothing(self.sensing.rate_cutoff, dt),
            "here_angle": np.zeros((n, 1, len(JOINTS))),
            "here_rate": np.zeros((n, 1, len(JOINTS))),
            "here_acceleration": np.zeros((n, 1, len(JOINTS))),
            "cuff_noise": self.sensing.cuff_noise,
            "interaction_noise": self.sensing.interaction_noise,
            "emg_lead": round(self.sensing.emg_lead / dt),
            "emg_noise": self.sensing.emg_noise,
            "emg_smoothing": smoothing(self.sensing.emg_cutoff, dt),
            "dt": dt,
            "tires": self.fatigue,
        }

    def _exchange(self, moving: Rows) -> None:
        """Sets the masses that hands carry in the coming control period."""
        memory = self.memory
        wanted = memory.carried[moving, np.minimum(memory.step[moving], self.samples - 1)]
        changed = moving[wanted != memory.load[moving]]
        if changed.size:
            memory.load[moving] = wanted
            self._differing.load(changed, memory.wearer, memory.load)

    def _push(self, moving: Rows) -> None:
        """Sets the forces on the grips for the coming control period."""
        memory = self.memory
        now = memory.push[moving, np.minimum(memory.step[moving], self.samples - 1)]
        self._ctrl[moving[:, None], self.addresses.pushes] = now

    def _impedance_of(self, wearer: int) -> Array:
        return self.control.impedance(self._differing.persons[wearer])

    def _take_over(self, action: Array, moving: Rows) -> None:
        """Starts motors at the first commanded torque, and wearers at the remainder."""
        waiting = [row for row in moving.tolist() if row in self._waiting]
        if not waiting or not np.isfinite(action[moving]).all():
            return  # the kernel `before` reports an action that is not finite
        rows, at = np.array(waiting), self.addresses
        self._waiting.difference_update(waiting)
        if not at.motors.size:
            return
        self._motor[rows] = np.clip(action[rows], -1, 1) * at.peak_torque  # no thermal limit yet
        self._ctrl[rows[:, None], at.motors] = self._motor[rows]
        self._current[rows] = self._motor[rows]
        self._settle(rows)

    def _settle(self, rows: Rows) -> None:
        """Puts arms at rest at their first intention, and exoskeletons at rest on their cuffs."""
        self._begin_rest(rows)
        self._needed(rows)
        unbalanced = rows if self._free.size else rows[:0]
        for _ in range(settling.MOST_SLOPES):
            if not unbalanced.size:
                break
            unbalanced = self._balance(unbalanced)
        self._hold(rows)

    def _balance(self, rows: Rows) -> Rows:
        """Moves exoskeletons toward rest on their cuffs; returns rows that have not converged."""
        free = self._free
        torque = self._needed(rows)
        slope = np.empty((len(rows), free.size, free.size))
        for column, dof in enumerate(free):
            angle = self._qpos[rows, dof]
            self._qpos[rows, dof] = angle + settling.NUDGE
            slope[:, :, column] = (self._needed(rows) - torque)[:, free] / settling.NUDGE
            self._qpos[rows, dof] = angle
        inverse: AnyArray = np.linalg.inv(slope)
        moves = np.zeros((len(rows), 4, free.size))
        status = np.full(len(rows), settling.FRESH)
        self._torque[rows] = torque
        for _ in range(settling.MOST_CORRECTIONS):
            if not settling.correct(rows, self._torque, inverse, self._qpos, free, moves, status):
                break
            self._needed(rows)
        return rows[status != settling.SETTLED]

    def _needed(self, rows: Rows) -> Array:
        """Returns the net torque on arms at rest, without the wearer's, shape (k, dofs)."""
        self.batch.forward(self._ids(rows), stage=VELOCITIES)
        self._imbalance(rows)
        return self._torque[rows]

    def _ids(self, rows: Rows) -> Rows | None:
        return None if len(rows) == self.n else rows  # Batch takes all of them faster

    def _write_differences(self, rows: Rows) -> None:
        memory, differing = self.memory, self._differing
        wearer = memory.wearer
        differing.write(rows, wearer, memory.misalignment, memory.load, memory.fall)
        for row in rows.tolist() if self._variety.wearers else ():
            chain = differing.chains[wearer[row]]
            self._links[row], self._gravity[row] = chain.links[0], chain.gravity[0]
            self._strength[row] = differing.strengths[wearer[row]]
            self._impedance[row] = self._impedance_of(int(wearer[row]))
        if self._variety.places:
            self._gravity[rows] = memory.fall[rows, None] * differing.chains[0].down

    def _put_on(self, row: int, suit: Mapping[str, SuitJoint]) -> None:
        for joint in self._joints - suit.keys():
            take_off(self.model, self.plugin_state[row], joint)
        for joint, entry in suit.items():
            replace_model(
                self.model,
                self.plugin_state[row],
                joint,
                entry.model,
                start_angle=entry.start_angle,
                start_torque=entry.start_torque,
                start_path=entry.start_path,
                allow_uncertified=True,  # `SuitJoint` has checked it
            )

    def _fill_encoders(self, rows: Rows) -> None:
        data, history = mujoco.MjData(self.model), self.batch.bind("history")
        for row in rows.tolist():
            mujoco.mj_resetData(self.model, data)
            data.qpos[:] = self._qpos[row]
            start_encoders(self.model, data)
            history[row] = data.history

    def _draw_noise(self, rows: Rows) -> None:
        memory = self.memory
        for row in rows[memory.step[rows] % STRETCH == 0].tolist():
            part = int(memory.step[row]) // STRETCH
            key = int(memory.seed[row]), int(memory.episode[row])
            for numbers, purpose in (
                (memory.fresh[row], "muscle noise"),
                (memory.shaken[row], "sensor noise"),
            ):
                if numbers.size:
                    stream(*key, purpose, part).standard_normal(out=numbers)


def _bound(kernel: Any, names: dict[str, Any], *first: Any) -> Callable[..., Any]:
    """Returns a kernel with its arguments bound by name, but the first, which have examples."""
    wanted = list(inspect.signature(kernel.py_func).parameters)
    return bound(kernel, first, [names[name] for name in wanted[len(first) :]])
