"""The environment's step against the physics in it."""

import mujoco
import numpy as np

from ...envs.evaluation import make_env
from .timing import Row, compare

STEPS = 500


def rows(repeats: int) -> list[Row]:
    """Times `env.step` against raw `mj_step` of the same frame."""
    env, arm = make_env("ActiveSuit/ArmTracking-v0")
    env.reset(seed=0)
    action = np.zeros(2, dtype=np.float32)
    data = mujoco.MjData(arm.model)
    mujoco.mj_resetDataKeyframe(arm.model, data, 0)

    def ours() -> None:
        for _ in range(STEPS):
            env.step(action)

    def raw() -> None:
        for _ in range(STEPS):
            mujoco.mj_step(arm.model, data, arm.substeps)

    return [
        compare(
            "env.step",
            ours,
            "raw mj_step of a frame",
            raw,
            repeats=repeats,
            unit="us/step",
            count=STEPS,
            target=0.50,
        )
    ]
