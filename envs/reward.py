"""What a control period costs: the wearer's effort, the tracking error, and unsteady assist."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EFFORT_SCALE = np.array([20.0, 10.0])  # N·m at shoulder and elbow that cost 1
ERROR_SCALE = 0.1  # rad that cost 1
SMOOTHNESS = 0.1
LOST = 1.0  # rad of tracking error at which an episode ends


def reward_terms(human_torque: Array, error: Array, change: Array) -> dict[str, float]:
    """Returns the terms of the reward, which sum to it.

    The wearer's torque and the motors' command are limited, and an error counts `LOST` at most: no
    reward is below -270.

    Args:
        human_torque: the wearer's torque at shoulder and elbow flexion [N·m], shape (2,).
        error: their tracking error [rad], shape (2,).
        change: by how much the action changed, shape (2,).
    """
    effort = human_torque / EFFORT_SCALE
    error = np.minimum(np.abs(error), LOST) / ERROR_SCALE
    return {
        "effort": -float(effort @ effort),
        "tracking": -float(error @ error),
        "smoothness": -SMOOTHNESS * float(change @ change),
    }
