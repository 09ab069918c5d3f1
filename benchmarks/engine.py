"""The time that hysteresis takes in `mj_step`, beside other ways to add it to a simulation."""

import ctypes
import itertools
import platform
from collections.abc import Callable
from functools import cache
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numba.core.runtime import _nrt_python  # pyright: ignore[reportAttributeAccessIssue]
from numba.core.runtime.nrt import rtsys

from ..assets import SCENE, load_suit
from ..hysteresis import State
from ..hysteresis.engine import attach
from .timing import Row, compare

STEPS = 3000
CALLBACK_STEPS = 500
SIMULATIONS, FRAMES, SUBSTEPS, THREADS = 1024, 10, 5, 2
ALLOCATION_STEPS = 20_000


def rows(repeats: int) -> list[Row]:
    """Times a physics step of the suited arm against one of the same model without a suit."""
    plain = mujoco.MjSpec.from_file(str(SCENE)).compile()
    bare, with_sensors = _suited(sensors=False), _suited(sensors=True)
    cases: list[tuple[str, Callable[[], None], int, float | None]] = [
        ("J-A on 4 joints", _stepper(bare), STEPS, 0.90),
        ("J-A on 4 joints, with its 12 sensors", _stepper(with_sensors), STEPS, None),
        ("native springyield on 4 joints", _stepper(_yielding()), STEPS, None),
        ("J-A by Python qfrc_applied", _by_hand(plain), CALLBACK_STEPS, None),
        ("J-A by Python mjcb_passive", _by_callback(plain), CALLBACK_STEPS, None),
    ]
    found = [
        compare(
            what,
            work,
            "mj_step without suit",
            _stepper(plain),
            repeats=repeats,
            unit="us/step",
            count=count,
            reference_count=STEPS,
            target=target,
        )
        for what, work, count, target in cases
    ]
    batch = compare(
        f"Batch of {SIMULATIONS} x {SUBSTEPS} substeps, {THREADS} threads, J-A on 4 joints",
        _batch(bare),
        "the same without suit",
        _batch(plain),
        repeats=repeats,
        unit="us/step",
        count=SIMULATIONS * FRAMES * SUBSTEPS,
        target=0.90,
    )
    return [*found, batch, *_allocations(with_sensors)]


def _suited(sensors: bool) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_file(str(SCENE))
    for joint, entry in load_suit("mock-suit").joints.items():
        attach(spec, joint, entry.model, sensors=sensors)
    return spec.compile()


def _yielding() -> mujoco.MjModel:
    """Returns the arm with MuJoCo's own elasto-plastic spring on the same joints."""
    spec = mujoco.MjSpec.from_file(str(SCENE))
    for joint in load_suit("mock-suit").joints:
        spec.joint(joint).stiffness = [10.0, 0.0, 0.0]
        spec.joint(joint).springyield = 5.0
    return spec.compile()


def _start(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    data.ctrl[:] = model.key("reach").ctrl


def _stepper(model: mujoco.MjModel) -> Callable[[], None]:
    data = mujoco.MjData(model)

    def run() -> None:
        _start(model, data)
        mujoco.mj_step(model, data, STEPS)

    return run


class _Memories:
    """The suit's torque computed by a Python callback, as one would without the plugin."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.models = {name: e.model for name, e in load_suit("mock-suit").joints.items()}
        self.qpos = [model.joint(joint).qposadr[0] for joint in self.models]
        self.dof = [model.joint(joint).dofadr[0] for joint in self.models]
        self.states: list[State] = []

    def start(self, data: mujoco.MjData) -> None:
        """Begins a new motion, without memory of the past."""
        starts = zip(self.models.values(), self.qpos, strict=True)
        self.states = [model.start(float(data.qpos[address])) for model, address in starts]

    def advance(self, data: mujoco.MjData, force: np.ndarray) -> None:
        """Steps the models to the present angles and subtracts their torques from `force`."""
        for i, model in enumerate(self.models.values()):
            self.states[i], torque = model.step(self.states[i], float(data.qpos[self.qpos[i]]))
            force[self.dof[i]] -= torque


def _by_hand(model: mujoco.MjModel) -> Callable[[], None]:
    data, memories = mujoco.MjData(model), _Memories(model)

    def run() -> None:
        _start(model, data)
        memories.start(data)
        for _ in range(CALLBACK_STEPS):
            data.qfrc_applied[:] = 0
            memories.advance(data, data.qfrc_applied)
            mujoco.mj_step(model, data)

    return run


def _by_callback(model: mujoco.MjModel) -> Callable[[], None]:
    data, memories = mujoco.MjData(model), _Memories(model)

    def run() -> None:
        _start(model, data)
        memories.start(data)
        mujoco.set_mjcb_passive(lambda _, d: memories.advance(d, d.qfrc_passive))
        try:
            mujoco.mj_step(model, data, CALLBACK_STEPS)
        finally:
            mujoco.set_mjcb_passive(None)

    return run


def _batch(model: mujoco.MjModel) -> Callable[[], None]:
    batch = Batch(model, nsim=SIMULATIONS, nthread=THREADS)
    batch.reset()
    ctrl = batch.bind("ctrl")
    targets = itertools.cycle((model.key("reach").ctrl.copy(), model.key("home").ctrl.copy()))

    def run() -> None:
        ctrl[:] = next(targets)  # a motion to and fro, without resets
        for _ in range(FRAMES):
            batch.step(nstep=SUBSTEPS)

    return run


def _allocations(model: mujoco.MjModel) -> list[Row]:
    """Counts the memory that stepping allocates, by the counters of numba and of the C library."""
    data = mujoco.MjData(model)
    _start(model, data)
    _nrt_python.memsys_enable_stats()
    grown: list[int] = []
    for steps in (STEPS, ALLOCATION_STEPS):  # twice: counting itself needs memory at first
        before = _in_use()
        mujoco.mj_step(model, data, steps)
        grown = [b - a for a, b in zip(before, _in_use(), strict=True)]
    kinds = (("arrays allocated", ""), ("heap growth", "bytes"))
    return [
        Row(what=f"{what} in {ALLOCATION_STEPS} steps", unit=unit, ours=count, limit=0)
        for (what, unit), count in zip(kinds, grown, strict=False)
    ]


def _in_use() -> list[int]:
    """Returns the number of numba's arrays so far and, with glibc, the bytes of its heap."""
    arrays, mallinfo = rtsys.get_allocation_stats().alloc, _mallinfo()
    if mallinfo is None:
        return [arrays]
    info = mallinfo()
    return [arrays, info.uordblks + info.hblkhd]


@cache
def _mallinfo() -> Any:
    if platform.libc_ver()[0] != "glibc":
        return None

    class Info(ctypes.Structure):
        names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
        _fields_ = [(name, ctypes.c_size_t) for name in names.split()]

    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = Info
    return mallinfo
