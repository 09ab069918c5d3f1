"""The reward of a control period: costs of effort, tracking error and unsteady assist."""

from collections.abc import Sequence

EFFORT_SCALE = (20.0, 10.0)  # N·m at shoulder and elbow that cost 1
ERROR_SCALE = 0.1  # rad that cost 1
SMOOTHNESS = 0.1
LOST = 1.0  # rad of tracking error at which an episode ends


def reward_terms(
    human_torque: Sequence[float], error: Sequence[float], change: Sequence[float]
) -> dict[str, float]:
    """Returns the terms of the reward, whose sum is the reward.

    The wearer's torque and the motors' command are limited, and an error counts `LOST` at most.
    So no reward of the default wearer is below -271.

    Args:
        human_torque: Torque of the wearer at shoulder and elbow flexion [N·m].
        error: Tracking error of these joints [rad].
        change: Change of the action since the last control period.
    """
    effort = [torque / scale for torque, scale in zip(human_torque, EFFORT_SCALE, strict=True)]
    return {
        "effort": -_square(effort),
        "tracking": -_square([min(abs(angle), LOST) / ERROR_SCALE for angle in error]),
        "smoothness": -SMOOTHNESS * _square(change),
    }


def _square(values: Sequence[float]) -> float:
    return sum([value * value for value in values])
