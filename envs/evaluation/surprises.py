"""What a policy and its wearer do when something fails that worked in all motions before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ..making import make_arms
from .compare import Policies, named_policies
from .core import FIRST_SEED, REFERENCES, maker, options_of, run
from .relief import relief_interval
from .rollout import Trace, rollout
from .scores import Score, score
from .statistics import Interval, mean_interval
from .wearers import Wearers


@dataclass(frozen=True, eq=False)
class Surprise:
    """Motions with a fault beside the same motions without.

    Attributes:
        policy: Name of the policy.
        fault: Name of the fault.
        score: Score of the motions with the fault.
        relief: Relief in them; None where the suit costs too little.
        moved: Greatest change of a joint's angle that the fault makes [rad], by motion.
        loaded: Greatest change of the torque that the wearer gives [N·m], by motion.
    """

    policy: str
    fault: str
    score: Score
    relief: Interval | None
    moved: Array
    loaded: Array

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers as plain values."""
        return {
            "policy": self.policy,
            "fault": self.fault,
            "score": self.score.to_dict(),
            "relief": self.relief and self.relief.to_dict(),
            "moved": mean_interval(self.moved).to_dict(),
            "loaded": mean_interval(self.loaded).to_dict(),
        }


def surprises(
    env_id: str,
    policies: Policies,
    faults: Mapping[str, Mapping[str, Any]],
    *,
    episodes: int = 20,
    seed: int = FIRST_SEED,
    **options: Any,
) -> list[Surprise]:
    """Evaluates policies where something fails, with wearers who have learned that it works.

    Args:
        env_id: Id of a registered environment.
        policies: Policies as `evaluate` takes them.
        faults: Fields of `Faults` by the name of the fault.
        episodes: Number of motions, at least 8.
        seed: Seed of the first motion.
        **options: Options of the environment.

    Returns:
        A surprise for each policy and fault, in their order.

    Raises:
        InputError: See `evaluate`; or a fault is outside its range.
    """
    named, seeds = named_policies(policies), range(seed, seed + episodes)
    unsuited, suited = (
        run(name, name, env_id, seeds, **options).score.effort for name in REFERENCES
    )
    found = []
    for name, given in named.items():
        mine = options_of(given, options)
        wearers = Wearers(env_id, episodes, **mine)
        try:
            make = maker(name, given, wearers, seeds)
            learned, usual = wearers.learn(make, seeds)
            for fault, fields in faults.items():
                arms = make_arms(
                    env_id, episodes, **mine, faults=dict(fields), **wearers.unlearning
                )
                try:
                    traces = rollout(arms, make(), seeds, learned=learned)
                finally:
                    arms.close()
                scored = score(name, traces)
                found.append(
                    Surprise(
                        policy=name,
                        fault=fault,
                        score=scored,
                        relief=relief_interval(unsuited, suited, scored.effort),
                        moved=_largest(usual, traces, "angle"),
                        loaded=_largest(usual, traces, "human_torque"),
                    )
                )
        finally:
            wearers.close()
    return found


def _largest(usual: Sequence[Trace], traces: Sequence[Trace], series: str) -> Array:
    """Returns the largest difference of a series in each motion, until one of both ends."""
    found = []
    for one, other in zip(usual, traces, strict=True):
        end = min(len(one.time), len(other.time))
        change = getattr(other, series)[:end] - getattr(one, series)[:end]
        found.append(float(np.abs(change).max()))
    return np.array(found)
