"""Scores of muscles: metabolic power, activation, and what they say about relief."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError, unknown_name
from ..evaluation.relief import relief_interval
from ..evaluation.rollout import Trace
from ..evaluation.scores import Values, root_mean_square
from ..evaluation.statistics import Interval
from .analysis import CONVENTIONS, STANDARD, Convention, demand_of, share_among_muscles
from .metabolic import LEAST_HEAT, muscle_masses
from .myoarm import MyoArm

FULL = 0.999  # activation from which a muscle counts as saturated
LOADED = 3  # muscles that are named
LEAST_COST = {"power": 0.5, "effort": 0.002}
"""Least cost of a suit for relief to have a meaning, in W, and in root mean square activation."""
FEWEST_SAMPLES = 3
MOST_OUTSIDE = 0.5


@dataclass(frozen=True, kw_only=True)
class MuscleScore:
    """Muscles of the wearer over some motions; a tuple has one value per motion, in their order.

    A motion that ended before its third sample has NaN.

    Attributes:
        power: Metabolic power of all muscles, mean over time [W], under each convention.
        effort: Root mean square activation over time and muscles, under each convention.
        loaded: The three muscles with the greatest root mean square activation over all motions,
            with it, under the standard convention like all that follows.
        rest: Metabolic power of the muscles at rest [W], which `power` includes.
        reserve: Root mean square of the torque that muscles could not give, over that of the torque
            that was wanted.
        largest_reserve: Largest such torque [N·m].
        saturated: Share of time in which a muscle was fully active: its load may then be larger.
        outside: Share of time in which the posture was outside a range of MyoArm.
    """

    power: dict[str, Values]
    effort: dict[str, Values]
    loaded: dict[str, float]
    rest: float
    reserve: float
    largest_reserve: float
    saturated: float
    outside: float

    def to_dict(self) -> dict[str, Any]:
        """Returns the score as plain values, with the units of its numbers under "units"."""
        return {**asdict(self), "units": UNITS}


UNITS = {
    **{"power": "W", "rest": "W", "largest_reserve": "N·m"},
    **dict.fromkeys(("effort", "loaded", "reserve", "saturated", "outside"), "1"),
}
"""Units of the numbers of a score, "1" for a ratio."""


def muscle_scores(
    motions: Sequence[Trace],
    *,
    conventions: Iterable[str] = tuple(CONVENTIONS),
    threads: int = 0,
    on_motion: Callable[[], None] = lambda: None,
) -> MuscleScore:
    """Returns what motions cost the muscles of the wearer (needs the extra `muscles`).

    MyoArm's muscles give the wearer's torque of every control period; see `analysis` for how, and
    for the conventions.

    Args:
        motions: Motions of one policy, such as `rollout` or `Evaluation.traces` has them.
        conventions: Names of conventions; the standard one is always among them.
        threads: Number of threads; 0 uses all cores.
        on_motion: Function that is called after each motion.

    Raises:
        InputError: The extra is missing, a convention is unknown, there is no motion, a wearer
            tires, or more than half of the postures are outside MyoArm's ranges.
    """
    chosen = _chosen(conventions)
    if not motions:
        raise InputError("there are no motions: give at least one")
    arm = MyoArm.load()
    power: dict[str, list[float]] = {name: [] for name in chosen}
    effort: dict[str, list[float]] = {name: [] for name in chosen}
    squares, wanted, left, most, full, outside = [], [], [], [], [], []
    rest = np.nan
    for motion in motions:
        if len(motion.time) < FEWEST_SAMPLES:
            for values in (*power.values(), *effort.values()):
                values.append(np.nan)
            on_motion()
            continue
        demand = demand_of(motion, arm, threads=threads)
        for name, convention in chosen.items():
            shared = share_among_muscles(arm, demand, convention)
            power[name].append(float(shared.power.sum(axis=1).mean()))
            effort[name].append(root_mean_square(shared.activation))
            if name == STANDARD:
                squares.append((shared.activation**2).mean(axis=0))
                wanted.append(np.square(demand.torque).sum(axis=1).mean())
                left.append(np.square(shared.reserve).sum(axis=1).mean())
                most.append(np.abs(shared.reserve).max())
                full.append((shared.activation > FULL).any(axis=1).mean())
        outside.append(demand.geometry.outside.mean())
        rest = demand.scale * LEAST_HEAT * muscle_masses(arm).sum()
        on_motion()
    if not outside:
        raise InputError(
            f"no motion has {FEWEST_SAMPLES} samples, which accelerations need: give longer ones"
        )
    if np.mean(outside) > MOST_OUTSIDE:
        raise InputError(
            f"{np.mean(outside):.0%} of the postures are outside the ranges of MyoArm's joints, "
            "and at most half may be: score a motion inside them"
        )
    return MuscleScore(
        power={name: tuple(values) for name, values in power.items()},
        effort={name: tuple(values) for name, values in effort.items()},
        loaded=_most_loaded(arm, np.sqrt(np.mean(squares, axis=0))),
        rest=float(rest),
        reserve=float(np.sqrt(np.mean(left) / max(float(np.mean(wanted)), 1e-12))),
        largest_reserve=float(max(most)),
        saturated=float(np.mean(full)),
        outside=float(np.mean(outside)),
    )


def muscle_relief(
    unsuited: MuscleScore,
    suited: MuscleScore,
    policy: MuscleScore,
    what: str = "power",
    convention: str = STANDARD,
) -> Interval | None:
    """Returns the share of the suit's cost to the muscles that a policy gives back.

    Args:
        unsuited: Score without suit and exoskeleton.
        suited: Score in the suit without exoskeleton, in the same motions.
        policy: Score of the policy in these motions.
        what: "power" or "effort".
        convention: Name of a convention that all of them have.

    Returns:
        Relief with its 95 % interval, that of a ratio of means; None where the suit costs less than
        0.5 W, or 0.2 % of activation, or a motion ended too soon.
    """
    series = [getattr(score, what)[convention] for score in (unsuited, suited, policy)]
    if not np.isfinite(series).all():
        return None
    return relief_interval(*series, least=LEAST_COST[what])


def relief_range(
    unsuited: MuscleScore, suited: MuscleScore, policy: MuscleScore, what: str = "power"
) -> tuple[float, float] | None:
    """Returns the least and the greatest relief over all conventions; None where one has none."""
    found = [
        muscle_relief(unsuited, suited, policy, what, convention) for convention in policy.power
    ]
    values = [one.value for one in found if one is not None]
    return (min(values), max(values)) if len(values) == len(found) else None


def _chosen(conventions: Iterable[str]) -> Mapping[str, Convention]:
    names = dict.fromkeys((STANDARD, *conventions))
    for name in names:
        if name not in CONVENTIONS:
            raise unknown_name("convention", name, CONVENTIONS)
    return {name: CONVENTIONS[name] for name in names}


def _most_loaded(arm: MyoArm, activation: Array) -> dict[str, float]:
    order = np.argsort(-activation, kind="stable")[:LOADED]
    return {arm.muscles[i]: float(activation[i]) for i in order}
