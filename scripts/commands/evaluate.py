"""`activesuit evaluate`: compares policies on the same motions."""

from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from ...checks import at_least, check_seed
from ...envs.benchmark.score_report import drawn_policies, evaluation_says
from ...envs.evaluation import BOUNDS, FIRST_SEED, Evaluation, Trace
from ...envs.evaluation import evaluate as evaluate_policies
from ...envs.evaluation.compare import Policies, named_policies
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.extras import SCORES
from ...envs.making import make_arms
from ...envs.model.config import NO_SUIT
from ...envs.policies import make_policy, needed_options
from ...tables import Rows
from ..folders import RunFolder
from ..options import EvaluatedName, Force, Json, Motions, Scores, Trust
from ..output import progress
from ..scene import Scene, scene
from ..writer import Report, conclude

USUAL_POLICIES = (
    "none",
    "transparent",
    "gravity",
    "feedforward",
    "compensation",
    "best-known-plan",
)


def evaluate(
    policies: tuple[EvaluatedName, ...] = USUAL_POLICIES,
    motions: Motions = 20,
    seed: int = FIRST_SEED,
    unadapted: bool = False,
    score: Scores = (),
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **options: Any,
) -> None:
    """Compare assist policies by what the wearer has to do.

    Beside them are the same motions without suit and exoskeleton (unsuited) and without the
    exoskeleton (suited). Relief is the share of the suit's cost that a policy gives back.
    Trained policies are evaluated in the task, at the level and with the options that they were
    trained with; --level chooses another level.

    Args:
        policies: Names of policies and bounds, or folders of training runs, which must have the
            same options.
        seed: Seed of the first motion.
        unadapted: Score wearers who have learned nothing of suit and exoskeleton, instead of those
            who have repeated each motion until nothing is left to learn.
        out: Folder for result.json, the scores and the first motions as CSV, figures and
            report.html: a new or an empty one.
    """
    at_least("motions", motions, 1)
    check_seed(seed)
    chosen = scene(options, policies=policies, trusted=trust)
    _check(chosen, score)
    if chosen.options["suit"] != NO_SUIT:
        at_least("motions", motions, FEWEST_MOTIONS)
    folder = RunFolder(out, force=force) if out else None
    found = run(
        *(chosen.env, chosen.policies, motions, seed), unadapted=unadapted, **chosen.options
    )
    given = {"env": chosen.env, "motions": motions, "seed": seed, **chosen.options}
    extras = [_scored(name, found) for name in score]
    result = given | found.to_dict()
    for name, one in zip(score, extras, strict=True):
        for policy, values in one.values.items():
            result["scores"][policy][name] = values
    place = f"{chosen.place}, {chosen.options['coupling']}, {motions} motions"
    report = Report(
        heading="Policies compared",
        about=place,
        result=result,
        tables=dict(chain(found.tables(place).items(), *(x.tables.items() for x in extras))),
        answer=[*found.sentences(), *(said for one in extras for said in one.remarks)],
        columns=found.columns(seed),
        plots=found.plots(),
        pictures={name: figure for one in extras for name, figure in one.pictures.items()},
        settings=given | {"policies": policies, "unadapted": unadapted, "score": score},
    )
    conclude(report, folder, json)


def run(
    env: str,
    policies: Policies,
    motions: int,
    seed: int,
    *,
    unadapted: bool,
    **options: Any,
) -> Evaluation:
    """Evaluates policies and shows a progress bar."""
    references = options.get("suit") != NO_SUIT
    with progress(env, (len(policies) + 2 * references) * motions) as bar:

        def report(policy: str, traces: list[Trace]) -> None:
            del policy
            bar.advance(len(traces))

        return evaluate_policies(
            env,
            policies,
            motions=motions,
            seed=seed,
            references=references,
            adapted=not unadapted,
            on_policy=report,
            threads=0,
            **options,
        )


class _Scored(NamedTuple):
    """What the score of an extra says about an evaluation."""

    tables: Mapping[str, Rows]
    remarks: Sequence[str]
    values: Mapping[str, Mapping[str, Any]]
    pictures: Mapping[str, Any]


def _scored(name: str, found: Evaluation) -> _Scored:
    """Returns what the score of an extra says about an evaluation."""
    score = SCORES.find(name)
    with progress(name, sum(map(len, found.traces.values()))) as bar:
        scored = {
            policy: score.scored(traces, threads=0, on_motion=bar.advance)
            for policy, traces in found.traces.items()
        }
    said, values = evaluation_says(name, scored)
    pictures = {}
    if score.figure is not None:
        drawn = {policy: found.traces[policy][0] for policy in drawn_policies(name, scored)}
        pictures[f"score-{name}"] = score.figure(drawn)
    return _Scored(said.tables, said.remarks, values, pictures)


def _check(chosen: Scene, scores: Sequence[str]) -> None:
    """Reports a mistake before a folder is made."""
    named_policies(chosen.policies)
    for policy in chosen.policies:
        needed = {} if policy in BOUNDS else needed_options(policy)
        arms = make_arms(chosen.env, 1, **{**chosen.options, **needed})
        for name in scores:
            SCORES.find(name).check(arms.episodes.simulation)
        if policy not in BOUNDS:
            make_policy(policy, arms)
