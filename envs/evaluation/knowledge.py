"""What knowledge of the suit buys: beliefs of rising knowledge in one and the same controller."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError
from ...hysteresis.branches import Branches
from ..belief import BelievedSuit, JointBelief, count_of
from ..model import ASSISTED
from ..plant import Plant
from ..policies.model_based import SHARE, ModelBased
from .compare import evaluate
from .relief import LEAST_COST, relief
from .rollout import Trace
from .scores import root_mean_square
from .statistics import Interval, difference_interval, mean_interval

TRUE, NONE = "true model", "no suit"
Beliefs = Mapping[str, Mapping[str, JointBelief]]


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What each belief reaches, by its name, in the order in which they are given.

    Attributes:
        relief: Relief by motion, shape (motions,).
        torque_error: Root mean square of believed less true torque, over time and the assisted
            joints, along the motion that happened [N·m], by motion.
        peak: Greatest torque of the suit in these motions [N·m].
        without_memory: Names of the beliefs that know angle and direction alone, or nothing.
    """

    relief: dict[str, Array]
    torque_error: dict[str, Array]
    peak: float
    without_memory: tuple[str, ...]

    def mean_relief(self, belief: str) -> Interval:
        """Returns the mean relief with its interval."""
        return mean_interval(self.relief[belief])

    @property
    def best_without_memory(self) -> str | None:
        """Name of the belief without memory that has the most relief; None if there is none."""
        return max(self.without_memory, key=lambda name: self.relief[name].mean(), default=None)

    def gain(self, belief: str) -> Interval | None:
        """Returns the relief less that of the best belief without memory, motion by motion.

        None for a belief without memory, or if there is no such belief.
        """
        best = self.best_without_memory
        if best is None or belief in self.without_memory:
            return None
        return difference_interval(self.relief[belief], self.relief[best])


def knowledge(env_id: str, beliefs: Beliefs, *, episodes: int = 20, **options: Any) -> Knowledge:
    """Evaluates compensation with each belief, then with the true model of the suit.

    Weight, friction and lead are the same in all of them; only the believed suit differs.

    Args:
        env_id: Id of a registered environment.
        beliefs: What is believed of each assisted joint, by joint, by the name of the belief.
        episodes: Number of motions, at least 8.
        **options: Options of the environment.

    Raises:
        InputError: The suit costs so little that relief has no meaning, or `evaluate` raises it.
    """

    def made(plant: Plant, joints: Mapping[str, JointBelief] | None) -> ModelBased:
        arm = plant.believed()
        known = arm.joints if joints is None else joints
        suit = BelievedSuit(known, count_of(arm.config.exo.encoder_bits), plant.dt)
        return ModelBased(plant, weight=arm.whole_weight(), suit=suit, friction=SHARE)

    policies = {
        **{name: (lambda plant, of=joints: made(plant, of)) for name, joints in beliefs.items()},
        TRUE: lambda plant: made(plant, None),
    }
    found = evaluate(env_id, policies, episodes=episodes, **options)
    efforts = {name: score.effort for name, score in found.scores.items()}
    reliefs = {}
    for name in policies:
        gained = relief(efforts["unsuited"], efforts["suited"], efforts[name])
        if gained is None:
            raise InputError(
                f"the suit costs less than {LEAST_COST:.0%} of strength in {env_id}, so that "
                "relief has no meaning: choose another suit or task"
            )
        reliefs[name] = gained
    errors = {name: torque_error(one, found.traces[name]) for name, one in beliefs.items()}
    errors[TRUE] = np.zeros(episodes)
    traces = [trace for each in found.traces.values() for trace in each]
    peak = max(float(np.abs(trace.suit_torque).max()) for trace in traces)
    without = [
        name
        for name, joints in beliefs.items()
        if all(isinstance(one, Branches) for one in joints.values())
    ]
    return Knowledge(reliefs, errors, peak, tuple(without))


def torque_error(joints: Mapping[str, JointBelief], traces: Sequence[Trace]) -> Array:
    """Returns the root mean square of believed less true resistance of each motion [N·m].

    Args:
        joints: What is believed of each assisted joint; nothing of one that is missing.
        traces: The motions.
    """
    columns = [JOINTS.index(name) for name in ASSISTED]
    errors = [
        _believed(joints, one.angle[:, columns]) + one.suit_torque[:, columns] for one in traces
    ]
    return np.array([root_mean_square(error) for error in errors])


def _believed(joints: Mapping[str, JointBelief], angle: Array) -> Array:
    """Returns the believed resistance along a motion of the assisted joints [N·m]."""
    torque = np.zeros_like(angle)
    for column, name in enumerate(ASSISTED):
        if name in joints:
            memory = joints[name].begin()[None].copy()
            for i, here in enumerate(angle[:, column]):
                torque[i, column] = joints[name].advance(memory, here[None], here[None])[0]
    return torque
