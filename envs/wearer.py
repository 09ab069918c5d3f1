"""The wearer: where the intention goes into the physics, and how an episode begins."""

import mujoco

from .reference import Reference
from .wiring import Wiring

SETTLING_ITERATIONS = 8  # each one shrinks the error by stiffness of suit and weight over kp


def intend(data: mujoco.MjData, wiring: Wiring, reference: Reference, step: int) -> None:
    """Gives the wearer the intention of control period `step`; past the end, to stay there."""
    i = reference.at(step)
    where = wiring.intention
    data.ctrl[where[:, 0]] = reference.angle[i]
    data.ctrl[where[:, 1]] = reference.rate[i] * (i == step)
    data.ctrl[where[:, 2]] = reference.feedforward[i]


def settle(
    model: mujoco.MjModel, data: mujoco.MjData, wiring: Wiring, reference: Reference
) -> None:
    """Puts the arm where the wearer holds it at rest: feedback carries what is not foreseen."""
    intended, feedforward = reference.angle[0], reference.feedforward[0]
    angle = intended
    for _ in range(SETTLING_ITERATIONS):
        data.qpos[wiring.joints] = angle
        mujoco.mj_forward(model, data)
        load = data.qfrc_bias[wiring.joints] - data.qfrc_passive[wiring.joints]
        angle = intended - (load - feedforward) / wiring.stiffness
    data.qpos[wiring.joints] = angle
    mujoco.mj_forward(model, data)
