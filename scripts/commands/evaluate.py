"""`activesuit evaluate`: compares policies on the same motions."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from ...checks import at_least, check_seed
from ...envs.evaluation import BOUNDS, FIRST_SEED, Evaluation, Trace
from ...envs.evaluation import evaluate as evaluate_policies
from ...envs.evaluation.compare import Policies, named_policies
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.extras import SCORES
from ...envs.making import make_arms
from ...envs.model.config import NO_SUIT
from ...envs.policies import make_policy, needed_options
from ...errors import InputError
from ..conclusion import conclude
from ..html.motions import write_motions
from ..html.subjects import SCORE
from ..options import EvaluatedName, Force, Json, Motions, Scores, Trust
from ..output import RunFolder, progress
from ..reports.motions import (
    agreement,
    cuff_remarks,
    effort_table,
    guard_remarks,
    score_table,
    settings_page,
    story,
    units_table,
    write_scores,
)
from ..reports.scores import Said, drawn_policies, evaluation_says
from ..reports.why import why_remarks
from ..scene import Scene, scene

USUAL_POLICIES = (
    "none",
    "transparent",
    "gravity",
    "feedforward",
    "compensation",
    "best-known-plan",
)
TABLE_POLICIES = (
    *("none", "transparent", "gravity", "feedforward", "compensation", "complement"),
    *BOUNDS,
)
PLACES, SUITS, COUPLINGS = (
    ("earth", "mars", "moon", "microgravity"),
    ("mock-suit", "emu-like"),
    ("rigid", "cuffs"),
)


def evaluate(
    policies: tuple[EvaluatedName, ...] = USUAL_POLICIES,
    motions: Motions = 20,
    seed: int = FIRST_SEED,
    unadapted: bool = False,
    score: Scores = (),
    table: bool = False,
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
        table: Evaluate on Earth, Mars, Moon and weightless, in two suits, rigid and on cuffs.
        out: Folder for result.json, motions.csv, the first motions and report.html, and tables.md
            with --table: a new or an empty one.
    """
    at_least("motions", motions, 1)
    check_seed(seed)
    if table and score:
        raise InputError("--table has no scores of extras: leave out --table or --score")
    if table:
        policies = TABLE_POLICIES if policies == USUAL_POLICIES else policies
    scenes = list(_scenes(options, policies, table=table, trusted=trust))
    for chosen in scenes[:1]:
        _check(chosen, score)
    if any(chosen.options["suit"] != NO_SUIT for chosen in scenes):
        at_least("motions", motions, FEWEST_MOTIONS)
    folder = RunFolder(out, force=force) if out else None
    results, tables, remarks, drawn = [], {}, [], []
    settings: dict[tuple[str, str, str], Evaluation] = {}
    for chosen in scenes:
        first: dict[str, Trace] = {}
        found = run(
            *(chosen.env, chosen.policies, motions, seed),
            unadapted=unadapted,
            first=first,
            **chosen.options,
        )
        scores = list(found.scores.values())
        with_references = found if found.suit_cost is not None else None
        results.append({"env": chosen.env, **chosen.options, **found.to_dict()})
        title = f"{chosen.place}, {chosen.options['coupling']}, {motions} motions"
        tables[title] = score_table(scores, with_references)
        if table:
            place, suit_name, coupling = (
                chosen.options[o] for o in ("gravity", "suit", "coupling")
            )
            settings[place, suit_name, coupling] = found
            remarks.append(f"{title}: {agreement(found)}")
        else:
            tables["Cost per motion"] = effort_table(scores)
            tables["Units of effort, medians"] = units_table(scores)
            remarks += [
                *story(found),
                *why_remarks(scores),
                *cuff_remarks(scores),
                *guard_remarks(scores),
            ]
        for name in score:
            said = _add_score(name, found, results[-1], folder)
            tables |= said.tables
            remarks += said.remarks
        if folder:
            name = "motions.csv" if not table else f"motions-{len(results)}.csv"
            write_scores(folder, name, scores, seed)
            if not table:
                drawn = write_motions(folder, chosen.place, first)
    if folder and table:
        folder.text("tables.md", settings_page(settings))
    result: dict[str, Any] = {"motions": motions, "seed": seed}
    result |= {"settings": results} if table else results[0]
    settings_of_run = {"env": scenes[0].env, "policies": policies, "motions": motions}
    settings_of_run |= {"seed": seed, "unadapted": unadapted, "score": score}
    settings_of_run |= {} if table else scenes[0].options
    conclude(
        *("evaluate", result, tables, remarks),
        folder=folder,
        json=json,
        settings=settings_of_run,
        motions=drawn,
    )


def run(
    env: str,
    policies: Policies,
    motions: int,
    seed: int,
    *,
    unadapted: bool,
    first: dict[str, Trace] | None = None,
    **options: Any,
) -> Evaluation:
    """Evaluates policies and shows a progress bar; puts their first motions into `first`."""
    references = options.get("suit") != NO_SUIT
    with progress(env, (len(policies) + 2 * references) * motions) as bar:

        def report(policy: str, traces: list[Trace]) -> None:
            if first is not None:
                first[policy] = traces[0]
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


def _add_score(
    name: str, found: Evaluation, result: dict[str, Any], folder: RunFolder | None
) -> Said:
    """Adds the score of an extra to a result, draws it, and returns what it says."""
    score = SCORES.find(name)
    with progress(name, sum(map(len, found.traces.values()))) as bar:
        scored = {
            policy: score.scored(traces, threads=0, on_motion=bar.advance)
            for policy, traces in found.traces.items()
        }
    said, values = evaluation_says(name, scored)
    for policy, its in values.items():
        result["scores"][policy][name] = its
    if folder and score.figure is not None:
        drawn = {policy: found.traces[policy][0] for policy in drawn_policies(name, scored)}
        folder.figure(f"{SCORE}{name}", score.figure(drawn))
    return said


def _scenes(
    options: Mapping[str, Any], policies: tuple[str, ...], *, table: bool, trusted: bool
) -> Iterator[Scene]:
    of_task = partial(scene, policies=policies, trusted=trusted)
    if not table:
        yield of_task(options)
        return
    if {"suit", "gravity", "coupling"} & options.keys():
        raise InputError("--table has its own suits, places and couplings: leave yours out")
    for coupling, suit_name, place in itertools.product(COUPLINGS, SUITS, PLACES):
        chosen = of_task({**options, "suit": suit_name, "gravity": place})
        yield replace(chosen, options={**chosen.options, "coupling": coupling})


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
