"""`activesuit benchmark`: compares controllers over tasks, levels and suits."""

from dataclasses import replace
from json import loads
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from ...envs.benchmark import BASELINE, SUITES, Leaderboard, Result, Suite, Trial, run_trial
from ...envs.benchmark import suite as make_suite
from ...envs.benchmark.results import RESULTS, lines, read_results, read_text
from ...envs.evaluation.run import drawn_seed
from ...errors import InputError, shown
from ...files import write_text
from ...json_files import read_json
from ..backends import Backend, check_backend, run_all
from ..folders import RunFolder, to_json
from ..options import Force, Json, Trust, choice, optional_number
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
    seed: Annotated[int | None, optional_number("10000; drawn for your own policies", int)] = None,
    workers: int = -1,
    backend: Backend = "loky",
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **environment: Any,
) -> None:
    """Compare controllers over tasks, levels and suits.

    `run` runs a suite, trial by trial; the same command after an interruption runs the missing
    trials. `table` merges results of several machines or people into one page. `compare` gives the
    paired difference between the relief of each policy and of the first policy. Options of the
    environment belong to `run`; results with such options have a contract of their own.

    Args:
        what: Whether to run a suite, make tables of results, or compare two policies.
        results: Files of results, or folders of runs, for table and compare.
        policies: Policies with their options, in place of the policies of the suite (run). For
            compare: names in the results; the others are compared with the first name.
        tasks: Names of tasks, in place of the tasks of the suite (run).
        levels: Names of levels, in place of the levels of the suite (run).
        believed: Suits that controllers believe in, in place of those of the suite (run).
        motions: Number of motions of each policy, at least 8 (run).
        seed: Seed of the first motion (run). Policies of your own are scored in motions that are
            drawn when the folder is begun; config.json has the seed, which repeats the run.
        workers: Number of trials at once; -1 uses all cores, or the whole cluster (run).
        backend: Place of the trials (run): processes (loky) or threads of this machine, or a
            cluster of ray or dask, which RAY_ADDRESS or DASK_SCHEDULER_ADDRESS names.
        out: Folder for results.jsonl, tables.md, report.html and the figure of profiles: a new or
            an empty folder, or the folder of the same benchmark, whose missing trials are run.
    """
    if what == "run":
        if results:
            raise InputError(f"run takes no results, and {str(results[0])!r} is given: use table")
        names = {"policies": policies, "tasks": tasks, "levels": levels, "believed": believed}
        more = {"motions": motions, "seed": seed, "options": environment, "trust": trust}
        chosen = make_suite(suite, **names, **more)
        out = out or Path("runs/benchmark")
        if seed is None and chosen.has_own:
            chosen = replace(chosen, first_seed=_begun(out).get("first_seed", drawn_seed()))
        check_backend(backend, workers)
        refuse_observed(chosen.options, [*chosen.policies.values()])
        if policies or believed or environment:
            chosen.check()
        folder = _folder(out, chosen, force)
        with telling(lambda: _kept(folder, chosen)):
            found = _run(folder, chosen, backend, workers)
        _report(found, folder, json, {**_plain(chosen), "backend": backend})
        return
    found = Leaderboard(read_results(results))
    folder = RunFolder(out, force=force) if out else None
    if what == "table":
        _report(found, folder, json, {"results": results})
        return
    given = policies or (BASELINE,)
    tables = found.differences(given)
    if json:
        named = {
            name: [dict(zip(header, row, strict=True)) for row in rows]
            for name, (header, rows) in tables.items()
        }
        print(to_json(named))
        return
    for name, rows in tables.items():
        table(f"relief of {name} less that of {given[0]}", *rows)


def _report(
    found: Leaderboard, folder: RunFolder | None, json: bool, given: dict[str, Any]
) -> None:
    if folder:
        folder.text(RESULTS, lines(found.results))
        folder.text("tables.md", found.page())
    settings = given | found.protocol
    about = f"{len(found.results)} trials"
    conclude(Report.of(found, "Benchmark of controllers", about, settings=settings), folder, json)


def _folder(out: Path, chosen: Suite, force: bool) -> RunFolder:
    """Opens the folder of a benchmark, which may have trials already."""
    wanted, begun = _plain(chosen), _begun(out)
    folder = RunFolder(out, force=force, resumes=bool(begun))
    if begun and begun != wanted:
        name = next(n for n in {**wanted, **begun} if begun.get(n) != wanted.get(n))
        raise InputError(
            f"{str(out)!r} holds a benchmark whose {name} is {shown(begun.get(name))}, not "
            f"{shown(wanted.get(name))}: choose another --out, or go on with its own options"
        )
    folder.json(CONFIG, wanted)  # the first file: it identifies the benchmark in a later run
    folder.subfolder(TRIALS)
    return folder


def _begun(out: Path) -> dict[str, Any]:
    """Returns the configuration of the benchmark in a folder; empty if there is none."""
    path = out / CONFIG
    present = read_json(path, "configuration of the benchmark") if path.exists() else None
    return present if isinstance(present, dict) and "contract" in present else {}


def _plain(chosen: Suite) -> dict[str, Any]:
    """Returns what config.json holds."""
    return loads(to_json(chosen.to_dict()))


def _run(folder: RunFolder, chosen: Suite, backend: Backend, workers: int) -> Leaderboard:
    """Returns all results: reads finished trials, and runs and writes the missing trials."""
    trials = chosen.trials
    found = {trial.file_name: _load(folder, chosen, trial) for trial in trials}
    missing = [trial for trial in trials if found[trial.file_name] is None]
    with progress("benchmark", len(trials)) as bar:
        bar.move_to(len(trials) - len(missing))
        for name, result in run_all(_named, [(chosen, one) for one in missing], backend, workers):
            write_text(folder / TRIALS / name, result.to_json() + "\n")
            found[name] = result
            bar.advance()
    return Leaderboard([one for one in found.values() if one is not None])


def _named(chosen: Suite, trial: Trial) -> tuple[str, Result]:
    return trial.file_name, run_trial(chosen, trial)


def _load(folder: RunFolder, chosen: Suite, trial: Trial) -> Result | None:
    path = folder / TRIALS / trial.file_name
    if not path.exists():
        return None
    content = read_text(path, "trial")
    found = Result.from_json(content, repr(str(path)))
    here = (*trial.setting, trial.label, chosen.contract)
    named = found.task, found.level, found.believed, found.policy, found.protocol.get("contract")
    if named != here:
        raise InputError(f"{str(path)!r} is the result of another trial: delete it")
    return found


def _kept(folder: RunFolder, chosen: Suite) -> str:
    done = sum((folder / TRIALS / trial.file_name).exists() for trial in chosen.trials)
    return (
        f"the finished trials ({done} of {len(chosen.trials)}) are kept in "
        f"{folder.path}/{TRIALS}; run the same command again for the rest"
    )
