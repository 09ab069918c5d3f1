"""The time of an environment's step, single and in rows, against the physics inside it."""

import importlib.util
import multiprocessing
import os
import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np

from ..envs.making import make_arms, make_env
from ..envs.model import compose
from ..envs.vector_env import ArmVectorEnv
from ..scripts.output import messages
from .timing import Row, compare, measure

ENV = "ActiveSuit/ArmTracking-v0"
STEPS = 500  # number of steps of a single environment
SOME, MANY = 64, 1024  # rows
WORKERS = 8
LONG = 100_000  # row-steps over which memory must not grow
MEGABYTE = 2**20
VELOCITIES = mujoco.mjtStage.mjSTAGE_VEL.value
BEFORE = "0.1 reached 0.50 to 0.56"


def rows(repeats: int) -> list[Row]:
    """Times environments, single and in rows, against raw physics and against other makers."""
    return [
        _single(repeats),
        *_some_rows(repeats),
        _many_rows(repeats),
        *_resets(repeats),
        *_stable_baselines(repeats),
        *_memory(),
    ]


def _single(repeats: int) -> Row:
    env, arm = make_env(ENV)
    drawn = compose(arm.config)
    data, action = mujoco.MjData(drawn), np.zeros(2, dtype=np.float32)

    def ours() -> None:
        env.reset(seed=0)
        for _ in range(STEPS):
            env.step(action)

    def raw() -> None:
        mujoco.mj_resetDataKeyframe(drawn, data, drawn.key("home").id)
        for _ in range(STEPS):
            mujoco.mj_step(drawn, data, 5)

    return compare(
        "gym.make, step",
        ours,
        f"raw mj_step of the same frame, with drawings ({BEFORE})",
        raw,
        repeats=repeats,
        unit="us/step",
        count=STEPS,
        target=0.90,
    )


def _stepper(env: Any, steps: int) -> Callable[[], None]:
    """Returns a function that makes some steps without action."""
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape, np.float32)

    def run() -> None:
        for _ in range(steps):
            env.step(action)

    return run


def _some_rows(repeats: int) -> list[Row]:
    steps, found = 20, []
    ours = make_arms(ENV, SOME, threads=1)
    shared = {"repeats": repeats, "unit": "us/step"}
    with closing(gymnasium.make_vec(ENV, SOME, vectorization_mode="sync")) as others:
        found.append(
            compare(
                f"{SOME} rows, one thread",
                _stepper(ours, steps),
                f"SyncVectorEnv of {SOME} single ones",
                _stepper(others, steps),
                count=SOME * steps,
                target=2.0,
                **shared,
            )
        )
    with closing(gymnasium.make_vec(ENV, WORKERS, vectorization_mode="async")) as others:
        found.append(
            compare(
                f"{SOME} rows, one thread",
                _stepper(ours, steps),
                f"AsyncVectorEnv of {WORKERS} single ones",
                _stepper(others, steps),
                count=SOME * steps,
                reference_count=WORKERS * steps,
                target=5.0,
                **shared,
            )
        )
    tired = make_arms(ENV, SOME, threads=1, fatigue=True, control={"noise": 1.0, "tremor": 0.01})
    found.append(
        compare(
            f"{SOME} rows with muscle noise and fatigue",
            _stepper(tired, steps),
            "the same without",
            _stepper(ours, steps),
            count=SOME * steps,
            target=1 / 1.2,
            **shared,
        )
    )
    return found


def _many_rows(repeats: int) -> Row:
    steps, ours = 4, make_arms(ENV, MANY)
    batch = make_arms(ENV, MANY).episodes.simulation.batch

    def raw() -> None:
        for _ in range(steps):
            batch.step(nstep=5, stage=VELOCITIES)

    return compare(
        f"{MANY} rows, all cores",
        _stepper(ours, steps),
        "raw Batch.step of the same rows",
        raw,
        repeats=repeats,
        unit="us/step",
        count=MANY * steps,
        target=0.75,
    )


def _resets(repeats: int) -> list[Row]:
    env, ours = make_env(ENV)[0], make_arms(ENV, MANY)

    def one() -> None:
        for seed in range(SOME):
            env.reset(seed=seed)

    def many() -> None:
        ours.reset(seed=0)

    return [
        measure("reset of one", one, repeats=repeats, unit="ms/row", count=SOME, limit=0.3),
        measure(
            f"reset of {MANY} rows", many, repeats=repeats, unit="ms/row", count=MANY, limit=0.3
        ),
    ]


def _stable_baselines(repeats: int) -> list[Row]:
    if importlib.util.find_spec("stable_baselines3") is None:
        messages.print("Stable-Baselines3 is left out: the extra train is not installed")
        return []
    from stable_baselines3.common.vec_env import DummyVecEnv

    from ..envs.sb3 import ArmVecEnv

    steps, ours = 20, ArmVecEnv(make_arms(ENV, SOME, threads=1, autoreset_mode="SameStep"))
    dummy = DummyVecEnv([lambda: gymnasium.make(ENV)] * SOME)
    action = np.zeros((SOME, 2), np.float32)

    def stepper(env: Any) -> Callable[[], None]:
        env.reset()

        def run() -> None:
            for _ in range(steps):
                env.step(action)

        return run

    row = compare(
        f"Stable-Baselines3, {SOME} rows, one thread",
        stepper(ours),
        f"its DummyVecEnv of {SOME} single ones",
        stepper(dummy),
        repeats=repeats,
        unit="us/step",
        count=SOME * steps,
        target=2.0,
    )
    return [row]


def _memory() -> list[Row]:
    """Measures the memory of a process with many rows, where /proc tells it."""
    if not Path("/proc/self/status").exists():
        return []
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_measure_memory, args=(theirs, MANY, LONG))
    process.start()
    theirs.close()
    resident, reserved, growth, forked = ours.recv()
    process.join()
    return [
        Row(what=f"memory of {MANY} rows", unit="MB", ours=resident, limit=400.0),
        Row(what="address space", unit="MB", ours=reserved, limit=1500.0),
        Row(what=f"growth in {LONG:,} row-steps", unit="MB", ours=growth, limit=1.0),
        Row(what="exit code of a fork of it", unit="", ours=forked, limit=0.0),
    ]


def _measure_memory(pipe: Any, rows: int, row_steps: int) -> None:
    arms = ArmVectorEnv(rows)
    run = _stepper(arms, 10)
    run()
    resident, reserved = _in_use("VmRSS"), _in_use("VmSize")
    for _ in range(row_steps // (10 * rows)):
        run()
    growth = _in_use("VmRSS") - resident
    child = os.fork()
    if child == 0:
        env = gymnasium.make(ENV)
        env.reset(seed=0)
        env.step(np.zeros(2, np.float32))
        os._exit(0)
    _, status = os.waitpid(child, 0)
    pipe.send((resident, reserved, growth, float(os.waitstatus_to_exitcode(status))))


def _in_use(what: str) -> float:
    """Returns an entry of /proc/self/status [MB]."""
    found = re.search(rf"{what}:\s+(\d+)", Path("/proc/self/status").read_text())
    assert found
    return int(found[1]) * 1024 / MEGABYTE
