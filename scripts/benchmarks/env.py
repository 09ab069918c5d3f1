"""The time of an environment's step, against the physics inside it."""

import mujoco
import numpy as np

from ...envs.evaluation import make_env
from ...envs.state import restore_physics
from .timing import Row, compare

STEPS = 500


def rows(repeats: int) -> list[Row]:
    """Times `env.step` against raw `mj_step` along the same motion."""
    env, arm = make_env("ActiveSuit/ArmTracking-v0")
    env.reset(seed=0)
    action = np.zeros(2, dtype=np.float32)
    start = arm.get_state()
    controls = []
    for _ in range(STEPS):
        env.step(action)
        controls.append(arm.data.ctrl.copy())
    data = mujoco.MjData(arm.model)

    def ours() -> None:
        arm.set_state(start)
        for _ in range(STEPS):
            env.step(action)

    def raw() -> None:
        restore_physics(arm.model, data, start)
        for control in controls:
            data.ctrl[:] = control
            mujoco.mj_step(arm.model, data, arm.substeps)

    return [
        compare(
            "env.step",
            ours,
            "raw mj_step of the same frame",
            raw,
            repeats=repeats,
            unit="us/step",
            count=STEPS,
            target=0.50,
        )
    ]
