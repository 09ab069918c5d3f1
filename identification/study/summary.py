"""Results of a study: a summary per joint and method, and a verdict per published claim."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ...arrays import Array
from ...published import LI_CLAIMS, LiClaim
from ..curves import Curve, Curves, noise_floor
from ..objective import CurveObjective
from .trial import StudyConfig, StudyTrial, is_multi_order

SUCCESS = 1.05  # largest ratio of a successful fitness to the noise floor
# Ratio to the NRMSE on first-order curves; a few hundred samples of noise differ by 3 %.
AS_WELL = 1.1
RESAMPLED = 10_000
FEWEST = 10  # least number of trials of either method for a verdict
Verdict = Literal["reproduced", "not reproduced", "undecidable"]


@dataclass(frozen=True, kw_only=True)
class MultiOrder:
    """How all trials of one method predict motions that turn more than once, on one joint.

    Errors are taken over all such motions together, those of first-order curves likewise.

    Attributes:
        curves: Names of the held-out curves that turn more than once.
        largest: Quartiles of the largest error [N·m], (3,).
        nrmse: Quartiles of the root mean square over the motions, (3,).
        first_order: Quartiles of the NRMSE on the held-out first-order curves, (3,); nan if there
            are none.
        ratio: Quartiles of each trial's own ratio of the two, (3,).
        as_well: Number of trials whose ratio is at most 1.1.
    """

    curves: tuple[str, ...]
    largest: Array
    nrmse: Array
    first_order: Array
    ratio: Array
    as_well: int


@dataclass(frozen=True, kw_only=True)
class Summary:
    """All trials of one method on one joint.

    Attributes:
        joint: The name of the joint.
        method: The name of the method.
        best: The trial with the lowest fitness.
        trials: All trials, by number.
        noise: The noise floor, as an NRMSE, estimated from the curves.
        successes: How many trials ended within 5 % of the noise floor.
        fitness: Quartiles of eq. (7), (3,).
        nrmse: Quartiles of the NRMSE, (3,).
        convergence: Quartiles of the convergence iteration, (3,); None for the certified fit,
            which has no iterations.
        evaluations_to_target: Evaluations of each trial until it was within 5 % of the noise floor,
            (trials,); infinite where it never was.
        to_target: Quartiles of `evaluations_to_target`, (3,).
        predictions: Quartiles of the largest error [N·m] by held-out first-order curve, (3,) each.
        multi_order: How held-out motions that turn more than once are predicted; None if there are
            none.
    """

    joint: str
    method: str
    best: StudyTrial
    trials: tuple[StudyTrial, ...] = field(repr=False)
    noise: float
    successes: int
    fitness: Array
    nrmse: Array
    convergence: Array | None
    evaluations_to_target: Array
    to_target: Array
    predictions: dict[str, Array]
    multi_order: MultiOrder | None

    @property
    def success_rate(self) -> float:
        """The share of trials that ended within 5 % of the noise floor."""
        return self.successes / len(self.trials)


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A claim beside our numbers.

    Attributes:
        claim: The printed claim.
        verdict: "not reproduced" if the interval lies below the printed advantage; else
            "reproduced" if it lies above 0; else "undecidable".
        reason: Why it is undecidable without numbers; else empty.
        sa_pso: Median of SA-PSO over the trials.
        mpso: Median of MPSO over the trials.
        advantage: (MPSO - SA-PSO) / SA-PSO of the medians.
        interval: The 95 % bootstrap interval of `advantage` over the trials.
        best_advantage: Advantage of the trials with the best fitness, as the paper compares.
    """

    claim: LiClaim
    verdict: Verdict
    reason: str = ""
    sa_pso: float = np.nan
    mpso: float = np.nan
    advantage: float = np.nan
    interval: tuple[float, float] = (np.nan, np.nan)
    best_advantage: float = np.nan


def summarize(
    config: StudyConfig,
    families: Mapping[str, Sequence[Curve]],
    trials: Sequence[StudyTrial],
) -> list[Summary]:
    """Returns one summary per joint and method, in the order of `config`.

    Args:
        config: The study.
        families: The curves by joint name.
        trials: All of its trials, in any order.
    """
    by_key = {trial.key: trial for trial in trials}
    ordered = [by_key[key] for key in config.keys]
    groups = [ordered[i : i + config.trials] for i in range(0, len(ordered), config.trials)]
    return [_summary(config, group, families[group[0].key.joint]) for group in groups]


def judge(config: StudyConfig, summaries: Sequence[Summary]) -> list[Judgement]:
    """Returns a judgement for every claim on a joint of the study."""
    found = {(summary.joint, summary.method): summary for summary in summaries}
    return [
        _judgement(
            claim,
            found.get((claim.joint, "sa-pso")),
            found.get((claim.joint, "mpso")),
            config,
        )
        for claim in LI_CLAIMS
        if claim.joint in config.joints
    ]


def target_fitness(curves: Sequence[Curve]) -> tuple[float, float]:
    """Returns the noise floor as NRMSE, and the fitness, eq. (7), that is 5 % above it."""
    objective = CurveObjective(curves)
    noise = noise_floor(curves) / objective.peak
    return noise, float(SUCCESS * noise / np.sqrt(objective.torque.size))


def _summary(config: StudyConfig, trials: list[StudyTrial], curves: Sequence[Curve]) -> Summary:
    first, family = trials[0], Curves(curves)
    noise, target = target_fitness(family.fitted())
    multi = tuple(curve.name for curve in family.held_out() if is_multi_order(curve))
    reached = [trial.evaluations_to(target) for trial in trials]
    return Summary(
        joint=first.key.joint,
        method=first.key.method,
        best=min(trials, key=lambda trial: (trial.fitness, trial.key.number)),
        trials=tuple(trials),
        noise=noise,
        successes=sum(trial.fitness <= target for trial in trials),
        fitness=_quartiles([trial.fitness for trial in trials]),
        nrmse=_quartiles([trial.nrmse for trial in trials]),
        convergence=(
            None
            if first.key.method == "certified"
            else _quartiles([trial.convergence_iteration(config.swarm_size) for trial in trials])
        ),
        evaluations_to_target=np.array(reached),
        to_target=_quartiles(reached),
        predictions={
            name: _quartiles([trial.predictions[name].largest for trial in trials])
            for name in first.predictions
            if name not in multi
        },
        multi_order=_multi_order(trials, multi) if multi else None,
    )


def _multi_order(trials: Sequence[StudyTrial], names: tuple[str, ...]) -> MultiOrder:
    others = [name for name in trials[0].predictions if name not in names]
    multi, first = (np.array([_nrmse(t, group) for t in trials]) for group in (names, others))
    ratio = np.divide(multi, first, out=np.full_like(multi, np.inf), where=np.isfinite(multi))
    return MultiOrder(
        curves=names,
        largest=_quartiles([max(t.predictions[name].largest for name in names) for t in trials]),
        nrmse=_quartiles(multi),
        first_order=_quartiles(first),
        ratio=_quartiles(ratio),
        as_well=int(np.sum(ratio <= AS_WELL)),
    )


def _nrmse(trial: StudyTrial, names: Sequence[str]) -> float:
    if not names:
        return np.nan
    return float(np.sqrt(np.mean([trial.predictions[name].nrmse ** 2 for name in names])))


def _quartiles(values: Sequence[float] | Array) -> Array:
    # Between a finite and an infinite value there is no middle.
    method = "linear" if np.isfinite(values).all() else "higher"
    return np.quantile(np.array(values, dtype=np.float64), [0.25, 0.5, 0.75], method=method)


def _judgement(
    claim: LiClaim, ours: Summary | None, other: Summary | None, config: StudyConfig
) -> Judgement:
    if ours is None or other is None:
        return _undecidable(claim, "the study has not run both sa-pso and mpso")
    if config.trials < FEWEST:
        return _undecidable(claim, f"{config.trials} trials each; it takes {FEWEST}")
    if claim.quantity == "prediction" and not ours.predictions:
        return _undecidable(claim, "no first-order curve has the role predict")
    a, b = (_values(summary, claim.quantity, config) for summary in (ours, other))
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        return _undecidable(claim, "models of some trials meet their pole on a held-out curve")
    name = f"{claim.joint} {claim.quantity}".encode()
    rng = np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(zlib.crc32(name),)))
    medians = [np.median(rng.choice(values, (RESAMPLED, values.size)), axis=1) for values in (a, b)]
    low, high = map(float, np.quantile(medians[1] / medians[0] - 1, [0.025, 0.975]))
    verdict: Verdict = "undecidable"
    if high < claim.advantage:
        verdict = "not reproduced"
    elif low > 0:
        verdict = "reproduced"
    sa_pso, mpso = float(np.median(a)), float(np.median(b))
    best_a, best_b = a[ours.best.key.number], b[other.best.key.number]
    return Judgement(
        claim=claim,
        verdict=verdict,
        sa_pso=sa_pso,
        mpso=mpso,
        advantage=mpso / sa_pso - 1,
        interval=(low, high),
        best_advantage=float(best_b / best_a - 1),
    )


def _undecidable(claim: LiClaim, reason: str) -> Judgement:
    return Judgement(claim=claim, verdict="undecidable", reason=reason)


def _values(summary: Summary, quantity: str, config: StudyConfig) -> Array:
    """Returns what a claim compares of each trial, (trials,)."""
    if quantity == "convergence":
        values = [trial.convergence_iteration(config.swarm_size) for trial in summary.trials]
    elif quantity == "prediction":
        values = [
            np.mean([trial.predictions[name].largest for name in summary.predictions])
            for trial in summary.trials
        ]
    else:
        values = [trial.fitness for trial in summary.trials]
    return np.array(values, dtype=np.float64)
