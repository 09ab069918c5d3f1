"""The hysteresis of joints in all worlds of a MuJoCo Warp model: its arrays and its kernels."""

# pyright: reportInvalidTypeForm=false

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import warp as wp

from ...arrays import Array
from ...errors import InputError
from ..around import Viscoelastic
from ..protocol import HysteresisModel, State
from .source import ANGLE, BEGIN, COMMIT, EXTRA, TORQUE, TRIAL, Source

# Of the last step of a joint: time, angle, torque of the slow part, torque, and the rounding error
# of the work (compensated summation of Kahan).
AT_TIME, AT_ANGLE, SLOW, TOTAL, LOST = map(wp.constant, range(5))
Step = wp.types.vector(5, wp.float32)


@dataclass(frozen=True)
class Joint:
    """A joint with one model and start for all worlds, or one for each world."""

    name: str
    position: int  # place in `qpos`
    velocity: int  # place in `qvel`
    models: tuple[HysteresisModel, ...]
    starts: tuple[State, ...]
    source: Source
    numbers: Array  # of each model, shape (1 or worlds, source.size)


class Hysteresis:
    """Hysteretic torque of some joints in all worlds; `attach` makes it.

    The arrays are on the device of the simulation, and keep their places: `warp.to_torch` gives
    views of them, and a CUDA graph may use them. They are as of the last `step` or `forward`, with
    RK4 of its last stage.

    Attributes:
        joints: Names of the joints, which are the columns of the arrays.
        torque: Resistance [N·m], shape (worlds, joints).
        work: Work done on the models since the worlds began [J], by the trapezoidal rule over the
            steps, shape (worlds, joints). After a closed loop this is the dissipated energy.
        fault: Flags, 1 where a motion has met the pole of an uncertified model, shape (worlds,
            joints). The torque there keeps its last valid value until the world's next reset.
    """

    def __init__(self, m: Any, d: Any, joints: Sequence[Joint]) -> None:
        device, shape = d.qpos.device, (d.nworld, len(joints))
        self.joints = tuple(joint.name for joint in joints)
        self.torque = wp.zeros(shape, dtype=float, device=device)
        self.work = wp.zeros(shape, dtype=float, device=device)
        self.fault = wp.zeros(shape, dtype=int, device=device)
        self._steps = wp.empty(shape, dtype=Step, device=device)
        self._joints = tuple(joints)
        kinds: dict[Source, list[int]] = defaultdict(list)
        for column, joint in enumerate(joints):
            kinds[joint.source].append(column)
        self._kinds = [_Kind(source, columns, self) for source, columns in kinds.items()]
        self.reset()
        self._before: Callable[[Any, Any], None] | None = m.callback.passive
        m.callback.passive = self

    def __call__(self, m: Any, d: Any) -> None:
        """Adds the torque to `qfrc_passive`, and moves the memory where time has moved on."""
        if d.nworld != self.torque.shape[0]:
            raise InputError(
                f"d has {d.nworld} worlds, and the hysteresis was attached with "
                f"{self.torque.shape[0]}: attach the hysteresis to each model with its own data"
            )
        if self._before is not None:
            self._before(m, d)
        for kind in self._kinds:
            kind.launch(m, d, self)

    def reset(self, worlds: Any = None) -> None:
        """Makes worlds begin again at the next step, as `mujoco_warp.reset_data` does by itself.

        A call is needed where the time of a world does not go back, as when positions are written.
        `worlds` is a Warp array of bool, shape (worlds,), true where a world begins again; by
        default all worlds do.
        """
        count = self.torque.shape[0]
        if worlds is None:
            worlds = wp.ones(count, dtype=bool, device=self.torque.device)
        if not (isinstance(worlds, wp.array) and worlds.dtype is wp.bool):
            raise InputError("worlds is no array of bool of Warp: give one, or none for all worlds")
        if worlds.shape != (count,):
            raise InputError(f"worlds has shape {worlds.shape}: give one flag for each of {count}")
        wp.launch(_forget, self.torque.shape, [worlds, self._steps], device=self.torque.device)

    def dissipated(self) -> Array:
        """Computes the energy [J] dissipated since the worlds began, shape (worlds, joints).

        That is the work less the stored energy, which Python computes on the host.
        """
        steps, found = self._steps.numpy(), self.work.numpy().astype(np.float64)
        for kind in self._kinds:
            memories = kind.memory.numpy().astype(np.float64)
            for i, column in enumerate(kind.columns):
                joint = self._joints[column]
                for world, step in enumerate(steps[:, column]):
                    if step[AT_TIME] == np.inf:  # the world has not made a step
                        found[world, column] = 0.0
                        continue
                    model = joint.models[world % len(joint.models)]
                    start = joint.starts[world % len(joint.starts)]
                    change = _stored(model, memories[world, i], step)
                    found[world, column] -= change - model.energy(start).stored
        return found

    @staticmethod
    def joints_of(callback: Any) -> set[str]:
        """Returns the names of the joints of a callback and of the callbacks before."""
        names: set[str] = set()
        while isinstance(callback, Hysteresis):
            names |= set(callback.joints)
            callback = callback._before
        return names


class _Kind:
    """Joints whose models have the same code, with their `columns` in the arrays of all joints.

    The array `memory` has the shape (worlds, joints of the kind, numbers of a memory).
    """

    def __init__(self, source: Source, columns: list[int], all_joints: Hysteresis) -> None:
        device, worlds = all_joints.torque.device, all_joints.torque.shape[0]
        joints = [all_joints._joints[column] for column in columns]
        rows = max(len(joint.numbers) for joint in joints)
        numbers = [np.broadcast_to(one.numbers, (rows, source.size)) for one in joints]
        places = [(one.position, one.velocity, i) for one, i in zip(joints, columns, strict=True)]
        self.columns = columns
        self.memory = wp.zeros((worlds, len(joints), source.state), dtype=float, device=device)
        self._numbers = wp.array(np.stack(numbers, axis=1), dtype=float, device=device)
        self._places = wp.array(np.array(places), dtype=wp.vec3i, device=device)
        self._kernel = kernel_of(source)
        wp.load_module(self._kernel.module, device=device)  # not while a graph is captured

    def launch(self, m: Any, d: Any, into: Hysteresis) -> None:
        wp.launch(
            self._kernel,
            self.memory.shape[:2],
            [self._places, self._numbers, d.time, d.qpos, d.qvel, m.opt.timestep],
            [self.memory, into._steps, into.torque, into.work, into.fault, d.qfrc_passive],
            device=self.memory.device,
        )


def _stored(model: HysteresisModel, memory: Array, step: Array) -> float:
    """Returns the energy that a model has stored [J], from its memory in C."""
    angle, torque = float(step[AT_ANGLE]), float(step[SLOW])
    stored = model.energy(State(memory[: model.memory_size], angle, torque)).stored
    if isinstance(model, Viscoelastic) and model.relaxation_stiffness > 0:
        stored += memory[-1] ** 2 / (2 * model.relaxation_stiffness)
    return stored


@wp.kernel(enable_backward=False)
def _forget(worlds: wp.array[bool], steps: wp.array2d[Step]):
    world, column = wp.tid()
    if worlds[world]:
        step = steps[world, column]
        step[AT_TIME] = wp.inf
        steps[world, column] = step


@cache
def kernel_of(source: Source) -> Any:
    """Returns the Warp kernel that computes the torque of the joints with the code `source`."""

    @wp.func_native(source.code)
    def move(
        numbers: wp.array3d[float],
        memory: wp.array3d[float],
        row: int,
        world: int,
        joint: int,
        angle: float,
        rate: float,
        dt: float,
        phase: int,
    ) -> wp.vec2: ...

    first = source.size - EXTRA

    @wp.kernel(module="unique", enable_backward=False)
    def resist(
        places: wp.array[wp.vec3i],
        numbers: wp.array3d[float],
        time: wp.array[float],
        qpos: wp.array2d[float],
        qvel: wp.array2d[float],
        timestep: wp.array[float],
        memory: wp.array3d[float],
        steps: wp.array2d[Step],
        torque: wp.array2d[float],
        work: wp.array2d[float],
        fault: wp.array2d[int],
        qfrc_passive: wp.array2d[float],
    ):
        world, joint = wp.tid()
        place = places[joint]
        dof, column = place[1], place[2]
        row = world % numbers.shape[0]
        angle = qpos[world, place[0]]
        rate = qvel[world, dof]
        step = steps[world, column]
        phase = int(TRIAL)
        if time[world] < step[AT_TIME]:
            phase = int(BEGIN)
            begun = numbers[row, joint, first + TORQUE]
            step = Step(time[world], numbers[row, joint, first + ANGLE], begun, begun, 0.0)
            work[world, column] = 0.0
            fault[world, column] = 0
        elif time[world] > step[AT_TIME]:
            phase = int(COMMIT)
        dt = timestep[world % timestep.shape[0]]
        found = move(numbers, memory, row, world, joint, angle, rate, dt, phase)
        slow = found[0]
        if fault[world, column] != 0 or wp.isnan(slow):  # also where the angle is not finite
            slow = step[SLOW]
            if phase == COMMIT and wp.isfinite(angle):
                fault[world, column] = 1
        total = slow + found[1]
        if phase == COMMIT and wp.isfinite(angle):
            more = 0.5 * (step[TOTAL] + total) * (angle - step[AT_ANGLE]) - step[LOST]
            sum = work[world, column] + more
            lost = (sum - work[world, column]) - more
            work[world, column] = sum
            step = Step(time[world], angle, slow, total, lost)
        steps[world, column] = step
        torque[world, column] = total
        qfrc_passive[world, dof] = qfrc_passive[world, dof] - total

    return resist
