"""`activesuit evaluate`: compares policies on the same motions."""

from pathlib import Path
from typing import Annotated, Any

from ...checks import at_least, check_seed
from ...envs.evaluation import evaluate as evaluate_policies
from ...envs.evaluation.compare import check_policy, named_policies
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.model.config import NO_SUIT
from ..folders import RunFolder
from ..options import EvaluatedName, Force, Json, Motions, Scores, Trust, optional_number
from ..output import progress
from ..scene import scene
from ..writer import Report, conclude

USUAL_POLICIES = (*"none transparent gravity feedforward compensation best-known-plan".split(),)


def evaluate(
    policies: tuple[EvaluatedName, ...] = USUAL_POLICIES,
    motions: Motions = 20,
    seed: Annotated[int | None, optional_number("10000; drawn for your own policies", int)] = None,
    unadapted: bool = False,
    score: Scores = (),
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **options: Any,
) -> None:
    """Compare assist policies by the effort of the wearer.

    The same motions are simulated without suit and exoskeleton (unsuited), and with the suit alone
    (suited). Relief is the share of the suit's cost that a policy gives back. Trained policies are
    evaluated in the task, at the level and with the options of their training; --level chooses
    another level.

    Args:
        policies: Names of policies and bounds, or folders of training runs, which must have the
            same options.
        seed: Seed of the first motion. Policies of your own are scored in motions that are drawn
            now; the report has the seed, which repeats the evaluation.
        unadapted: Score wearers who have never worn suit and exoskeleton, in place of wearers who
            have repeated each motion until they improve no more.
        out: Folder for result.json, the scores and the first motions as CSV, figures and
            report.html: a new or an empty folder.
    """
    at_least("motions", motions, 1)
    if seed is not None:
        check_seed(seed)
    chosen = scene(options, policies=policies, trusted=trust)
    named_policies(chosen.policies)
    for policy in chosen.policies:
        check_policy(chosen.env, policy, score, **chosen.options)
    references = chosen.options["suit"] != NO_SUIT
    if references:
        at_least("motions", motions, FEWEST_MOTIONS)
    folder = RunFolder(out, force=force) if out else None
    rounds = (len(chosen.policies) + 2 * references) * (1 + len(score))
    with progress(chosen.env, rounds * motions) as bar:
        found = evaluate_policies(
            *(chosen.env, chosen.policies),
            motions=motions,
            seed=seed,
            references=references,
            adapted=not unadapted,
            scores=score,
            on_policy=lambda _, traces: bar.advance(len(traces)),
            threads=0,
            **chosen.options,
        )
    given = {"env": chosen.env, "motions": motions, "seed": found.first_seed, **chosen.options}
    place = f"{chosen.place}, {chosen.options['coupling']}, {motions} motions"
    report = Report.of(
        *(found, "Policies compared", place),
        result=given | found.to_dict(),
        tables=found.tables(place),
        settings=given | {"policies": policies, "unadapted": unadapted, "score": score},
    )
    conclude(report, folder, json)
