"""`activesuit benchmark`: compares controllers over tasks, levels and suits."""

from dataclasses import replace
from json import loads
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from ...envs.benchmark import BASELINE, SUITES, Result, Setting, Suite, Trial, run_trial
from ...envs.benchmark import suite as make_suite
from ...envs.benchmark.report import (
    benchmark_remarks,
    best_policies,
    contract_remarks,
    difference_rows,
    level_rows,
    page,
    profile_plot,
    task_rows,
)
from ...envs.benchmark.results import RESULTS, lines, read_results, read_text
from ...envs.benchmark.score_report import Said, benchmark_says
from ...envs.benchmark.standings import FIXED, Standings
from ...envs.extras import SCORES
from ...envs.making import make_arms
from ...envs.policies import make_policy, needed_options
from ...errors import InputError, shown
from ...files import write_text
from ...json_files import read_json
from ...tables import Rows
from ..backends import Backend, check_backend, run_all
from ..folders import RunFolder, to_json
from ..options import Force, Json, Scores, Trust, choice, optional_number
from ..options import levels as level_names
from ..options import tasks as task_names
from ..output import progress, table, telling
from ..scene import refuse_observed
from ..writer import Report, conclude

What = Literal["run", "table", "compare"]
TRIALS, CONFIG = "trials", "config.json"


def benchmark(
    what: Annotated[What, tyro.conf.Positional],
    results: Annotated[tuple[Path, ...], tyro.conf.Positional] = (),
    /,
    suite: Annotated[str, choice(lambda: SUITES, "Name of a suite (run).")] = "quick",
    policies: tuple[str, ...] = (),
    tasks: tuple[Annotated[str, choice(task_names)], ...] = (),
    levels: tuple[Annotated[str, choice(level_names)], ...] = (),
    believed: tuple[str, ...] = (),
    motions: Annotated[int | None, optional_number("that of the suite", int)] = None,
    score: Scores = (),
    workers: int = -1,
    backend: Backend = "loky",
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **environment: Any,
) -> None:
    """Compare controllers over tasks, levels and suits.

    `run` runs a suite, trial by trial; the same command again goes on where it stopped. `table`
    merges results of several machines or people into one page. `compare` gives the paired
    difference of the policies' relief to the first one. Options of the environment are for run;
    their results have a contract of their own.

    Args:
        what: Whether to run a suite, make tables of results, or compare two policies.
        results: Files of results, or folders of runs, for table and compare.
        policies: Policies with their options, instead of those of the suite (run). For compare:
            names in the results, the first of which the others are compared with.
        tasks: Names of tasks, instead of those of the suite (run).
        levels: Names of levels, instead of those of the suite (run).
        believed: Suits that controllers believe in, instead of those of the suite (run).
        motions: Number of motions of each policy, at least 8 (run).
        workers: Number of trials at once; -1 uses all cores, or the whole cluster (run).
        backend: Place of the trials (run): processes (loky) or threads of this machine, or a
            cluster of ray or dask, which RAY_ADDRESS or DASK_SCHEDULER_ADDRESS names.
        out: Folder for results.jsonl, tables.md, report.html and the figure of profiles: a new or
            an empty one, or that of the same benchmark, which goes on.
    """
    if what == "run":
        if results:
            raise InputError(f"run takes no results, and {str(results[0])!r} is given: use table")
        chosen = make_suite(
            suite,
            policies=policies,
            tasks=tasks,
            levels=levels,
            believed=believed,
            motions=motions,
            options=environment,
            scores=score,
            trust=trust,
        )
        check_backend(backend, workers)
        refuse_observed(chosen.options, [*chosen.policies.values()])
        if policies or believed or environment:
            _check(chosen)
        _check_scores(chosen)
        folder = _folder(out or Path("runs/benchmark"), chosen, force)
        with telling(lambda: _kept(folder, chosen)):
            found = _run(folder, chosen, backend, workers)
        folder.text(RESULTS, lines(found))
        _report(found, folder, json, {**_config(chosen), "backend": backend})
        return
    found = read_results(results)
    folder = RunFolder(out, force=force) if out else None
    if what == "table":
        if folder:
            folder.text(RESULTS, lines(found))
        _report(found, folder, json, {"results": results}, "benchmark-table")
    else:
        _compare(Standings(found), policies or (BASELINE,), json)


def _check(chosen: Suite) -> None:
    """Reports mistakes in policies and suits before anything has run."""
    for trial in replace(chosen, tasks=chosen.tasks[:1]).trials:
        if trial.label not in FIXED:
            options = {**chosen.environment(trial.setting), **needed_options(trial.policy)}
            arms = make_arms(f"ActiveSuit/{trial.setting.task}-v0", 1, **options)
            make_policy(trial.policy, arms)
            arms.close()


def _check_scores(chosen: Suite) -> None:
    """Reports a score that no task can have, before anything has run."""
    for name in chosen.scores:
        refused: InputError | None = None
        for setting in {one.task: one for one in chosen.settings}.values():
            arms = make_arms(f"ActiveSuit/{setting.task}-v0", 1, **chosen.environment(setting))
            try:
                SCORES.find(name).check(arms.episodes.simulation)
            except InputError as error:
                refused = error
            else:
                refused = None
                break
        if refused is not None:
            raise refused


def _report(
    found: list[Result],
    folder: RunFolder | None,
    json: bool,
    settings: dict[str, Any],
    command: str = "benchmark",
) -> None:
    standings = Standings(found)
    scores = benchmark_says(found)
    tables = _tables(standings, scores)
    failed = [one for one in found if one.failed]
    report = Report(
        heading="Benchmark of controllers",
        about=f"{standings.count} trials",
        result={"trials": [loads(one.to_json()) for one in found]},
        tables=tables,
        answer=[
            *best_policies(standings),
            *(sentence for one in scores.values() for sentence in one.remarks),
            *benchmark_remarks(found),
            *contract_remarks(standings),
            *(f"{x.policy} failed in {x.task} at {x.level}: {x.failed}" for x in failed),
        ],
        plots={"profiles": profile_plot(standings)},
        settings={**settings, **standings.protocol},
    )
    if folder:
        folder.text("tables.md", page(standings, "# Controllers compared", "profiles.png", scores))
    conclude(report, folder, json)


def _tables(standings: Standings, scores: dict[str, Said]) -> dict[str, Rows]:
    """Returns the tables of all levels by their titles."""
    levels = standings.levels
    tables = {f"{one}: all tasks": level_rows(standings, one) for one in levels}
    tables |= {f"{one}: success and relief by task": task_rows(standings, one) for one in levels}
    return tables | {title: rows for one in scores.values() for title, rows in one.tables.items()}


def _compare(standings: Standings, policies: tuple[str, ...], json: bool) -> None:
    if len(policies) < 2:
        raise InputError("compare needs two policies: add --policies compensation adaptive")
    first, *others = policies
    tables = {other: difference_rows(standings, other, first) for other in others}
    if json:
        print(
            to_json(
                {
                    name: [dict(zip(h, r, strict=True)) for r in rows]
                    for name, (h, rows) in tables.items()
                }
            )
        )
        return
    for name, rows in tables.items():
        table(f"relief of {name} less that of {first}", *rows)


def _folder(out: Path, chosen: Suite, force: bool) -> RunFolder:
    """Opens the folder of a new benchmark, or of one that goes on."""
    wanted, path = _config(chosen), out / CONFIG
    present = read_json(path, "configuration of the benchmark") if path.exists() else None
    begun = present if isinstance(present, dict) and "contract" in present else {}
    folder = RunFolder(out, force=force, resumes=bool(begun))
    if begun and begun != wanted:
        name = next(n for n in {**wanted, **begun} if begun.get(n) != wanted.get(n))
        raise InputError(
            f"{str(out)!r} holds a benchmark whose {name} is {shown(begun.get(name))}, not "
            f"{shown(wanted.get(name))}: choose another --out, or go on with its own options"
        )
    folder.json(CONFIG, wanted)  # the first file, by which the benchmark is known again
    folder.subfolder(TRIALS)
    return folder


def _config(chosen: Suite) -> dict[str, Any]:
    """Returns what config.json holds."""
    return loads(
        to_json(
            {
                "suite": chosen.name,
                "contract": chosen.contract,
                "tasks": chosen.tasks,
                "levels": chosen.levels,
                "believed": chosen.believed,
                "motions": chosen.motions,
                "policies": {name: spec.to_dict() for name, spec in chosen.policies.items()},
                **({"options": chosen.options} if chosen.options else {}),
                **({"scores": chosen.scores} if chosen.scores else {}),
            }
        )
    )


def _run(folder: RunFolder, chosen: Suite, backend: Backend, workers: int) -> list[Result]:
    """Returns all results: reads those on disk, and runs and writes the others one by one."""
    trials = chosen.trials
    found = {trial.file_name: _load(folder, chosen, trial) for trial in trials}
    missing = [trial for trial in trials if found[trial.file_name] is None]
    with progress("benchmark", len(trials)) as bar:
        bar.move_to(len(trials) - len(missing))
        for name, result in run_all(_named, [(chosen, one) for one in missing], backend, workers):
            write_text(folder / TRIALS / name, result.to_json() + "\n")
            found[name] = result
            bar.advance()
    return [one for one in found.values() if one is not None]


def _named(chosen: Suite, trial: Trial) -> tuple[str, Result]:
    return trial.file_name, run_trial(chosen, trial)


def _load(folder: RunFolder, chosen: Suite, trial: Trial) -> Result | None:
    path = folder / TRIALS / trial.file_name
    if not path.exists():
        return None
    content = read_text(path, "trial")
    found = Result.from_json(content, repr(str(path)))
    here = (*trial.setting, trial.label, chosen.contract)
    if (*_setting(found), found.policy, found.protocol.get("contract")) != here:
        raise InputError(f"{str(path)!r} is the result of another trial: delete it")
    return found


def _setting(result: Result) -> Setting:
    return Setting(result.task, result.level, result.believed)


def _kept(folder: RunFolder, chosen: Suite) -> str:
    done = sum((folder / TRIALS / trial.file_name).exists() for trial in chosen.trials)
    return (
        f"the finished trials ({done} of {len(chosen.trials)}) are kept in "
        f"{folder.path}/{TRIALS}; run the same command again for the rest"
    )
