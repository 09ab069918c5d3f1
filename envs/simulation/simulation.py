"""Arms with their wearers and motors, one or a thousand, in one batch of MuJoCo.

    >>> from activesuit.envs.person import VoluntaryControl
    >>> options = SimulationOptions(samples=101, control_dt=0.01, control=VoluntaryControl())
    >>> arms = Simulation(ArmConfig(suit="none"), 2, options)
    >>> arms.state.intention.motion.angle.shape, arms.measured("angle").shape
    ((2, 101, 4), (2, 4))

`begin` puts some rows at rest at the start of their intention, and `step` moves rows by one control
period. Row i is the same to the last bit whatever the other rows do, for any number of rows and
threads: kernels get the index of a row, and draw no random numbers. `state`, `plugin_state`,
`sensordata` and `measured` are views of the arrays in which the kernels write: copy the values that
you need after the next call.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import AnyArray, Array
from ...assets import SuitJoint
from ...errors import InputError
from ...hysteresis.engine import replace_model, take_off
from ..model import GRAVITY, ArmConfig, Payload, bare_arm, resisting_joints, start_encoders
from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import Edits
from . import compiling, equilibrium
from .bound_kernels import bound
from .cycle import after, before
from .episode_plan import Plan, checked_plan
from .faults import FaultInjector, Faults
from .inverse_dynamics import Chain, arm_torques
from .kinematics import Arm
from .measurements import COLUMNS, sense
from .row_models import RowModels
from .state import KEPT, STRETCH, SimulationOptions, state_of, stream
from .structs import Addresses, Arms, Physics, saved

Rows = NDArray[np.int64]

VELOCITIES = mujoco.mjtStage.mjSTAGE_VEL.value
NOTHING = mujoco.mjtStage.mjSTAGE_NONE.value


@dataclass(frozen=True, eq=False)
class Start:
    """Start of an episode of one row."""

    # Intended motion of the wearer, and loads on the hand, as `Simulation.checked` returns.
    plan: Plan
    suit: Mapping[str, SuitJoint] | None  # joints of the wearer's suit; None is the compiled suit
    encoder_offset: Array  # error of the encoders' zeros [rad], shape (4,)
    payload: Payload | None  # load at the hand; None is that of the configuration
    gravity: str | None  # name of the place; None is that of the configuration
    wearer: int  # number of the wearer
    # Displacement of the exoskeleton from its configured position [m], shape (3,).
    misalignment: Array
    noise_scale: float  # factor of the noise of sensors


class Posture(NamedTuple):
    """Time and pose of a row, from which its picture is drawn."""

    time: float  # simulated time [s]
    position: Array  # position `qpos` of the physics
    loaded: bool  # whether the hand carries the task's load


class Simulation:
    """Simulates rows of arms, without task and reward.

    Each row is an arm with its suit, exoskeleton and wearer. A control period is `before`, the
    physics of all rows, and `after` (see `cycle`).

    Args:
        config: Configuration of the arms.
        n: Number of rows.
        options: What the rows have in common.
        edits: What a task adds to the model.
        threads: Number of threads; 0 uses all cores.

    Attributes:
        model: MuJoCo model of a row, without drawings.
        state: State of the episodes, beside the state of the physics.
        addresses: Addresses of the model.
        suit: Joints that the compiled suit resists, at its operating pressure.
        ranges: Ranges of the bare arm's joints [rad], shape (4, 2); intentions stay inside.
        columns: Columns of the measurements that these arms have, by name.
        bounds: Lowest and highest number of each array of a saved state, by name.
        batch: The physics.
        plugin_state: State of the suits, a view of shape (n, size).
        sensordata: Sensors of the physics, a view of shape (n, size).
    """

    def __init__(
        self,
        config: ArmConfig,
        n: int,
        options: SimulationOptions,
        edits: Edits | None = None,
        threads: int = 1,
    ) -> None:
        compiling.begin(before)
        self.config, self.n, self._options = config, n, options
        self.control, self.fatigue, self.sensing = options.control, options.fatigue, options.sensing
        self.samples, self.control_dt = options.samples, options.control_dt
        variety, self.faults = options.variety, options.faults
        models = self._row_models = RowModels(config, variety, edits)
        self.model, self.addresses = models.model, Addresses.of(models.model)
        self.substeps = round(self.control_dt / config.timestep)
        self._pushed = self.addresses.pushes.size > 0
        self.ranges = bare_arm(config).jnt_range
        self.suit = resisting_joints(config)
        self._joints = set(self.suit).union(*(suit.joints for suit in variety.suits))
        arm = models.chains[0], models.strengths[0], self._impedance_of(0)
        self.state = state_of(n, config, options, self.addresses, arm)
        self._injector = None
        if self.faults != Faults():
            received = self.state.sensors.measured, self.state.reception
            self._injector = FaultInjector(self.faults, *received, self.addresses)
        self._saved = self.state.arrays()
        self.bounds = {name: (one.low, one.high) for name, (_, one) in saved(self.state).items()}
        self.bounds["wearer"] = (0, len(models.persons) - 1)
        self._cleared = [values for name, values in self._saved.items() if name not in KEPT]
        muscles_draw = self.state.wearer.noise.muscle_draws.size > 0
        self._draws = options.noisy or muscles_draw or self._injector is not None
        self.columns = self._measured_columns()
        self._all = np.arange(n)
        self._begin_physics(threads)

    # --- Episodes -----------------------------------------------------------------------------

    def begin(
        self, rows: Rows, start_of: Callable[[int], Start], learned: Mapping[str, Array]
    ) -> None:
        """Begins an episode in some rows, shape (k,), with rested wearers at their first posture.

        `start_of` returns the start of the episode of a row. `learned` has what the wearers have
        learned [N·m], shape (k, samples, 4) each, by the names of `Intention`. Seeds and numbers of
        the episodes must be in `state` before the call.

        The posture is in equilibrium: the slow correction starts at the torque that the feed-
        forward torque lacks. Strength does not limit this torque: a wearer who is too weak drops
        the arm afterwards. Motors begin without torque; see `cycle.drive` for the first control
        period.
        """
        learning = self.state.wearer.learning
        for values in self._cleared:
            values[rows] = 0
        for name, values in learned.items():
            getattr(self.state.intention, name)[rows] = values
        learning.gains[rows] = learning.next_gains[rows]
        self.batch.reset(self._ids(rows), stage=NOTHING)
        for row in rows.tolist():
            self._write_start(row, start_of(row))
        self._write_differences(rows)
        self._equilibrate(rows)
        if self.config.exo.encoder_delay > 0:
            self._fill_encoders(rows)
        self.batch.forward(self._ids(rows))
        self._after(rows, False)
        if self._sense:
            self._sense(rows, False)
        if self._injector:
            self._injector.begin(rows)

    def step(self, action: Array, rows: Rows | None = None) -> None:
        """Moves some rows, by default all, by one control period.

        `action` is the torque of the motors over their peaks, finite, shape (n, motors); values
        beyond [-1, 1] are clipped and counted.
        """
        if self._pid is not None and os.getpid() != self._pid:
            raise InputError(
                "this environment was made before a fork, whose child has none of its threads: "
                "make it in the child, or with threads=1"
            )
        moving = self._all if rows is None else rows
        received = self._injector.recall(moving) if self._injector else None
        if self._draws:
            self._draw_noise(moving)
        if self._options.carries:
            self._exchange(moving)
        if self._pushed:
            now = self.state.conditions.push[moving, self._sample(moving)]
            self._ctrl[moving[:, None], self.addresses.pushes] = now
        self._before(moving, action)
        self.batch.step(ids=rows, nstep=self.substeps, stage=VELOCITIES)
        self._after(moving, True)
        if self._sense:
            self._sense(moving, True)
        if self._injector and received is not None:
            step, draws = self.state.episode.step[moving], self.state.reception.fault_draws
            now = draws[moving, (step - 1) % STRETCH]
            self._injector.deliver(moving, received, step * self.control_dt, now)

    def checked(self, plan: Plan) -> Plan:
        """Returns the plan; raises an InputError if these arms cannot carry it out."""
        carries, pushes = self._options.carries, self._pushed
        return checked_plan(plan, self.samples, self.ranges, carries=carries, pushes=pushes)

    def arm_of(self, wearer: int) -> Arm:
        """Returns the bare arm of the wearer with a number."""
        return self._row_models.arms[wearer]

    def dressed(self, row: int) -> Chain:
        """Returns the arm of a row with suit and load of the configuration.

        Loads that a task puts into the hand later are not part of the arm, nor is an exoskeleton.
        """
        chain = self._row_models.dressed(int(self.state.conditions.wearer[row]))
        return replace(chain, gravity=self.state.wearer.arm.gravity[row, None].copy())

    def own_torque(self, rows: Rows) -> Array:
        """Returns the torque of bare arms along their intentions [N·m], (k, samples, 4)."""
        motion, found = self.state.intention.motion, []
        for row in rows.tolist():
            chain = self._row_models.chains[self.state.conditions.wearer[row]]
            here = replace(chain, gravity=self.state.wearer.arm.gravity[row, None])
            found.append(arm_torques(here, *(part[row] for part in motion)))
        return np.array(found)

    def measured(self, name: str) -> Array:
        """Returns a view of one measurement of all rows, shape (n, size)."""
        return self.state.sensors.measured[:, COLUMNS[name]]

    # --- State --------------------------------------------------------------------------------

    def get_state(self, rows: Rows) -> dict[str, NDArray]:
        """Returns the state of some rows, as new arrays with a leading axis of rows."""
        arrays = {"physics": self.batch.state, **self._saved}
        return {name: values[rows] for name, values in arrays.items()}

    def set_state(self, rows: Rows, state: dict[str, NDArray]) -> None:
        """Restores a result of `get_state` in as many rows, which then continue bit for bit."""
        self.batch.reset(rows, stage=NOTHING)
        self.batch.state[rows] = state["physics"]
        for name, values in self._saved.items():
            values[rows] = state[name]
        self._write_differences(rows)
        self.batch.forward(rows, stage=VELOCITIES)

    def data(self, row: int, into: mujoco.MjData | None = None) -> mujoco.MjData:
        """Returns the physics of a row, for reading, in `into` or in a new MjData of `model`."""
        return self.batch.get_data(row, into)

    def posture_of(self, row: int) -> Posture:
        """Returns time and pose of a row, for a picture."""
        conditions = self.state.conditions
        carried = conditions.carried[row]
        loaded = carried.size > 0 and conditions.load[row] > carried.min()
        return Posture(float(self._time[row]), self._qpos[row].copy(), bool(loaded))

    # --- Parts --------------------------------------------------------------------------------

    def _measured_columns(self) -> dict[str, slice]:
        at = self.addresses
        absent = set() if at.cuffs.size else {"cuff_force", "cuff_sensor"}
        if not self.fatigue:
            absent.add("fatigue")
        if not self._options.noisy:
            absent |= {"interaction_torque", "emg", "cuff_sensor"}
        if not at.motors.size:
            absent |= {"motor_load", "motor_torque", "previous_action"}
        return {name: part for name, part in COLUMNS.items() if name not in absent}

    def _begin_physics(self, threads: int) -> None:
        compiling.wait()
        self._pid = os.getpid() if threads != 1 else None
        # An MjData takes 165 KB whatever the model, so that rows share those of the threads.
        batch = self.batch = Batch(self.model, self.n, nthread=threads, persistent=self.n == 1)
        batch.reset()
        self._row_models.begin(batch)
        self._time = batch.bind("time")
        self.plugin_state = batch.bind("plugin_state")
        physics, at, state = Physics.of(batch), self.addresses, self.state
        self._qpos, self._ctrl = physics.qpos, physics.ctrl
        self._passive, self._bias = physics.qfrc_passive, physics.qfrc_bias
        self.sensordata = physics.sensordata
        self._free = np.setdiff1d(at.exo_joints, at.joints)
        self._rest = np.zeros((self.n, self.model.nv))
        rows, action = self._all, np.empty((self.n, at.motors.size))
        arms = Arms(physics, at, *(getattr(state, name) for name in Arms._fields[2:]))
        self._begin_rest = bound(equilibrium.begin, (rows,), arms)
        self._hold = bound(equilibrium.hold, (rows, self._rest), arms)
        self._before = bound(before, (rows, action), arms)
        self._after = bound(after, (rows, True), arms)
        self._sense = bound(sense, (rows, True), arms) if self._options.noisy else None

    def _write_start(self, row: int, start: Start) -> None:
        state, conditions, plan = self.state, self.state.conditions, start.plan
        for values, part in zip(state.intention.motion, plan.motion, strict=True):
            values[row] = part
        state.sensors.encoder_offset[row] = start.encoder_offset
        state.noisy.noise_scale[row] = start.noise_scale
        conditions.wearer[row], conditions.misalignment[row] = start.wearer, start.misalignment
        self._row_models.strap(self.plugin_state[row], start.wearer, start.misalignment)
        conditions.load[row] = (start.payload or self.config.payload).mass
        if self._options.carries:
            carried = conditions.load[row] + (0.0 if plan.mass is None else plan.mass)
            conditions.carried[row] = carried
            heaviest = conditions.carried[row].max()
            if heaviest > HEAVIEST_PAYLOAD:
                raise InputError(
                    f"payload and the task's load are {heaviest:.3g} kg together: stay within "
                    f"{HEAVIEST_PAYLOAD:g} kg"
                )
            conditions.load[row] = conditions.carried[row, 0]
        if plan.push is not None:
            conditions.push[row] = plan.push
        if start.gravity is not None:
            conditions.free_fall[row] = GRAVITY[start.gravity]
        if start.suit is not None:
            self._put_on(row, start.suit)

    def _exchange(self, moving: Rows) -> None:
        """Sets the masses that hands carry in the coming control period."""
        conditions = self.state.conditions
        wanted = conditions.carried[moving, self._sample(moving)]
        changed = moving[wanted != conditions.load[moving]]
        if changed.size:
            conditions.load[moving] = wanted
            self._row_models.load(changed, conditions.wearer, conditions.load)

    def _sample(self, rows: Rows) -> Rows:
        """Returns the sample of the intention at which rows are, shape (k,)."""
        return np.minimum(self.state.episode.step[rows], self.samples - 1)

    def _impedance_of(self, wearer: int) -> Array:
        return self.control.impedance(self._row_models.persons[wearer])

    def _equilibrate(self, rows: Rows) -> None:
        """Puts arms at rest at their first intention, and exoskeletons at rest on their cuffs."""
        self._begin_rest(rows)
        self._needed(rows)
        unbalanced = rows if self._free.size else rows[:0]
        for _ in range(equilibrium.MOST_SLOPES):
            if not unbalanced.size:
                break
            unbalanced = self._balance(unbalanced)
        self._hold(rows, self._rest)

    def _balance(self, rows: Rows) -> Rows:
        """Moves exoskeletons toward rest on their cuffs; returns rows that have not converged."""
        free = self._free
        torque = self._needed(rows)
        slope = np.empty((len(rows), free.size, free.size))
        for column, dof in enumerate(free):
            angle = self._qpos[rows, dof]
            self._qpos[rows, dof] = angle + equilibrium.NUDGE
            slope[:, :, column] = (self._needed(rows) - torque)[:, free] / equilibrium.NUDGE
            self._qpos[rows, dof] = angle
        inverse: AnyArray = np.linalg.inv(slope)
        moves = np.zeros((len(rows), 4, free.size))
        status = np.full(len(rows), equilibrium.FRESH)
        self._rest[rows] = torque
        for _ in range(equilibrium.MOST_CORRECTIONS):
            if not equilibrium.correct(rows, self._rest, inverse, self._qpos, free, moves, status):
                break
            self._needed(rows)
        return rows[status != equilibrium.DONE]

    def _needed(self, rows: Rows) -> Array:
        """Returns the net torque on arms at rest, without the wearer's, shape (k, dofs)."""
        self.batch.forward(self._ids(rows), stage=VELOCITIES)
        self._rest[rows] = self._passive[rows] - self._bias[rows]
        return self._rest[rows]

    def _ids(self, rows: Rows) -> Rows | None:
        return None if len(rows) == self.n else rows  # Batch moves all rows faster

    def _write_differences(self, rows: Rows) -> None:
        models, conditions, muscles = self._row_models, self.state.conditions, self.state.muscles
        wearer, arm = conditions.wearer, self.state.wearer.arm
        models.write(rows, wearer, conditions.misalignment, conditions.load, conditions.free_fall)
        for row in rows.tolist() if self._options.variety.wearers else ():
            chain = models.chains[wearer[row]]
            arm.links[row], arm.gravity[row] = chain.links[0], chain.gravity[0]
            muscles.strength[row] = models.strengths[wearer[row]]
            muscles.impedance[row] = self._impedance_of(int(wearer[row]))
        if self._options.variety.places:
            arm.gravity[rows] = conditions.free_fall[rows, None] * models.chains[0].down

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
                allow_uncertified=True,  # `SuitJoint` has checked the model
            )

    def _fill_encoders(self, rows: Rows) -> None:
        data, history = mujoco.MjData(self.model), self.batch.bind("history")
        for row in rows.tolist():
            mujoco.mj_resetData(self.model, data)
            data.qpos[:] = self._qpos[row]
            start_encoders(self.model, data)
            history[row] = data.history

    def _draw_noise(self, rows: Rows) -> None:
        episode, noise = self.state.episode, self.state.wearer.noise
        for row in rows[episode.step[rows] % STRETCH == 0].tolist():
            part = int(episode.step[row]) // STRETCH
            key = int(episode.seed[row]), int(episode.episode[row])
            for numbers, purpose in (
                (noise.muscle_draws[row], "muscle noise"),
                (self.state.noisy.sensor_draws[row], "sensor noise"),
                (self.state.reception.fault_draws[row], "faults"),
            ):
                if numbers.size:
                    stream(*key, purpose, part).standard_normal(out=numbers)
