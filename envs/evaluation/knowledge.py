"""What knowledge of the suit buys: beliefs of rising knowledge in one and the same controller."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ..belief import BelievedSuit, JointBelief, count_of
from ..model import ASSISTED
from ..policies.belief import BelievedArm
from ..policies.model_based import SHARE, ModelBased
from ..vector_env import ArmVectorEnv
from .compare import evaluate
from .rollout import Trace
from .statistics import Interval, difference_interval, mean_interval

TRUE, NONE = "true model", "no suit"
Beliefs = Mapping[str, Mapping[str, JointBelief]]


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What each belief reaches, by its name, in the order of rising knowledge.

    Attributes:
        relief: Relief by motion, shape (motions,).
        torque_error: Root mean square of believed less true torque, over time and the assisted
            joints, along the motion that happened [N·m], by motion.
        peak: Greatest torque of the suit in these motions [N·m].
    """

    relief: dict[str, Array]
    torque_error: dict[str, Array]
    peak: float

    def mean_relief(self, belief: str) -> Interval:
        """Returns the mean relief with its interval."""
        return mean_interval(self.relief[belief])

    def step(self, belief: str) -> Interval | None:
        """Returns the relief less that of the belief before; None for the first."""
        names = list(self.relief)
        place = names.index(belief)
        if place == 0:
            return None
        return difference_interval(self.relief[belief], self.relief[names[place - 1]])


def knowledge(env_id: str, beliefs: Beliefs, *, episodes: int = 20, **options: Any) -> Knowledge:
    """Evaluates compensation with each belief, then with the true model of the suit.

    Weight, friction and lead are the same in all of them; only the believed suit differs.

    Args:
        env_id: Id of a registered environment.
        beliefs: What is believed of each assisted joint, by joint, by the name of the belief.
        episodes: Number of motions, at least 8.
        **options: Options of the environment.

    Raises:
        InputError: See `evaluate`.
    """
    errors: dict[str, Array] = {}
    peaks: list[float] = []

    def made(arms: ArmVectorEnv, joints: Mapping[str, JointBelief] | None) -> ModelBased:
        arm = BelievedArm(arms)
        known = arm.joints if joints is None else joints
        suit = BelievedSuit(known, count_of(arm.config.exo.encoder_bits), arms.control_dt)
        return ModelBased(arms, weight=arm.whole_weight(), suit=suit, friction=SHARE)

    def compare(name: str, traces: list[Trace]) -> None:
        if name in beliefs:
            errors[name] = np.array([torque_error(beliefs[name], one) for one in traces])
        peaks.extend(float(np.abs(one.suit_torque).max()) for one in traces)

    policies = {
        **{name: (lambda arms, of=joints: made(arms, of)) for name, joints in beliefs.items()},
        TRUE: lambda arms: made(arms, None),
    }
    found = evaluate(env_id, policies, episodes=episodes, on_policy=compare, **options)
    unsuited, suited = (np.array(found.scores[name].effort) for name in ("unsuited", "suited"))
    cost = float(np.mean(suited - unsuited))
    relief = {
        name: (suited - np.array(score.effort)) / cost
        for name, score in found.scores.items()
        if name in policies
    }
    errors[TRUE] = np.zeros(episodes)
    return Knowledge(relief, errors, max(peaks))


def torque_error(joints: Mapping[str, JointBelief], trace: Trace) -> float:
    """Returns the root mean square of believed less true resistance along a motion [N·m].

    Args:
        joints: What is believed of each assisted joint; nothing of one that is missing.
        trace: The motion.
    """
    columns = {name: i for i, name in enumerate(ASSISTED, start=1)}
    wrong = []
    for name, column in columns.items():
        true, angle = -trace.suit_torque[:, column], trace.angle[:, column]
        believed = np.zeros_like(true)
        if name in joints:
            memory = joints[name].begin()[None].copy()
            for i, here in enumerate(angle):
                believed[i] = joints[name].advance(memory, here[None], here[None])[0]
        wrong.append(believed - true)
    return float(np.sqrt(np.mean(np.square(wrong))))
