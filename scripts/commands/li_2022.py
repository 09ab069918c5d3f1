"""`activesuit reproduce li-2022`: compares methods by many trials, and judges the claims."""

from collections.abc import Sequence
from json import loads
from pathlib import Path
from typing import Annotated, Any

from ... import __version__
from ...assets import CURVES, curves_path
from ...errors import InputError, shown
from ...files import write_text
from ...identification import Curves, load_curves
from ...identification.study.figures import figures
from ...identification.study.summary import judge, summarize
from ...identification.study.trial import (
    STUDY_METHODS,
    StudyConfig,
    StudyTrial,
    TrialKey,
    check,
    fingerprint,
    run_trial,
)
from ...identification.thinning import thinned, thinning_note
from ...json_files import read_json
from ..backends import Backend, check_backend, run_all
from ..options import Force, Json, Seed, choice
from ..output import RunFolder, messages, progress, say, table, telling, to_json
from ..reports.study import report, to_dict
from ..reports.study_tables import (
    best_table,
    multi_order_table,
    prediction_table,
    summary_rows,
    trial_rows,
    typical_table,
    verdict_table,
)

Method = Annotated[str, choice(lambda: STUDY_METHODS)]
CurvesName = Annotated[str, choice(lambda: [*CURVES, "FILE.csv"])]
Families = dict[str, Curves]


def li_2022(
    out: Path = Path("runs/study"),
    methods: tuple[Annotated[str, choice(lambda: STUDY_METHODS)], ...] = ("sa-pso", "mpso"),
    joints: tuple[Annotated[str, choice(lambda: [*CURVES, "FILE.csv"])], ...] = (
        "shoulder",
        "elbow",
    ),
    trials: int = 30,
    seed: Seed = 0,
    swarm_size: int = 50,
    iterations: int = 100,
    workers: int = -1,
    backend: Backend = "threading",
    force: Force = False,
    json: Json = False,
) -> None:
    """Compare identification methods by many trials, and judge the claims.

    Every finished trial is kept at once; the same command again goes on where it stopped. Results
    do not depend on the workers or the backend.

    Args:
        out: Folder for config.json, the trials, trials.csv, table.csv, report.md and the figures: a
            new or an empty one, or that of the same study, which goes on.
        methods: Names of the methods to compare.
        joints: Names of shipped curves, or CSV files; curves with the role predict are kept out of
            the fits, and may turn more than once.
        trials: Number of independent runs of each method on each joint.
        swarm_size: Number of particles of a swarm.
        iterations: Number of moves of a swarm; every other method except certified may evaluate
            the model as often as a swarm does.
        workers: Number of trials that run at once; -1 uses all cores, or the whole cluster.
        backend: Place where the trials run: threads or processes (loky) of this machine, or a
            cluster of ray or dask, which RAY_ADDRESS or DASK_SCHEDULER_ADDRESS names; without that
            address a new one of this many workers starts here.
    """
    families = _families(joints)
    config = StudyConfig(
        methods=methods,
        joints={joint: fingerprint(curves) for joint, curves in families.items()},
        trials=trials,
        seed=seed,
        swarm_size=swarm_size,
        iterations=iterations,
    )
    check(config, families)
    check_backend(backend, workers)
    folder = _folder(out, config, force)
    with telling(lambda: _kept(folder, config)):
        finished = _run(folder, config, families, backend, workers)
    summaries = summarize(config, families, finished)
    judgements = judge(config, summaries)
    result = to_dict(config, summaries, judgements)
    folder.json("result.json", result)
    folder.csv("trials.csv", *trial_rows(config, summaries))
    folder.csv("table.csv", *summary_rows(summaries))
    drawn = figures(config, families, summaries)
    for name, figure in drawn.items():
        folder.figure(name, figure)
    folder.text("report.md", report(config, summaries, judgements, list(drawn)))
    if json:
        print(to_json(result))
        return
    table(f"best of {trials} trials", *best_table(summaries))
    table("all trials", *typical_table(summaries))
    table("largest errors on held-out first-order curves", *prediction_table(summaries), left=3)
    if any(summary.multi_order for summary in summaries):
        table("held-out motions that turn more than once", *multi_order_table(summaries))
    if judgements:
        table("SA-PSO against MPSO, as the paper claims", *verdict_table(judgements), left=2)
    for reason in dict.fromkeys(judgement.reason for judgement in judgements if judgement.reason):
        say(f"note: undecidable: {reason}")
    say(f"report, figures and data: {folder.path}/report.md")


def _families(joints: Sequence[str]) -> Families:
    families: Families = {}
    for given in joints:
        path = curves_path(given) if given in CURVES else Path(given)
        if given not in CURVES and path.suffix.lower() != ".csv":
            raise InputError(
                f"joint {given!r}: use shipped curves ({', '.join(sorted(CURVES))}) or a CSV file"
            )
        if path.stem in families:
            raise InputError(f"two joints are named {path.stem!r}: rename one of the files")
        measured = load_curves(path)
        if note := thinning_note(measured):
            messages.print(f"note: {path.name}: {note}", markup=False)
        families[path.stem] = thinned(measured)
        if given in CURVES:
            multi_order = load_curves(path.with_stem(f"{given}_multi_order"))
            families[path.stem] = Curves([*families[path.stem], *multi_order])
    return families


def _folder(out: Path, config: StudyConfig, force: bool) -> RunFolder:
    """Opens the folder of a new study, or of one with the same configuration.

    Trials that are there are never taken for those of a study with another configuration.

    Raises:
        InputError: The folder holds another study.
    """
    folder = RunFolder(out, "study", force=force)
    trials = folder.subfolder("trials")
    wanted = loads(to_json({"version": __version__, **config.to_dict()}))
    begun = any(trials.glob("[!.]*"))
    present = _read_config(folder / "config.json") if begun or folder.own else None
    if present is None and begun:
        raise InputError(
            f"{str(trials)!r} holds trials without a config.json: choose another --out"
        )
    if present is None:
        folder.json("config.json", wanted)
    elif present != wanted:
        names = {**wanted, **present}
        different = next(name for name in names if present.get(name) != wanted.get(name))
        raise InputError(
            f"{str(out)!r} holds a study whose {different} is {shown(present.get(different))}, not "
            f"{shown(wanted.get(different))}: choose another --out, or go on with its own options"
        )
    return folder


def _read_config(path: Path) -> dict[str, Any] | None:
    if not path.exists():
        return None
    found = read_json(path, "configuration of the study")
    if not isinstance(found, dict):
        raise InputError(f"{str(path)!r} is not the configuration of a study: choose another --out")
    return found


def _run(
    folder: RunFolder, config: StudyConfig, families: Families, backend: Backend, workers: int
) -> list[StudyTrial]:
    """Returns all trials: reads those on disk, and runs and writes the others one by one."""
    held_out = {joint: curves.held_out().names for joint, curves in families.items()}
    found = (_load(folder, key, held_out[key.joint]) for key in config.keys)
    finished = [trial for trial in found if trial is not None]
    done = {trial.key for trial in finished}
    calls = [(config, key, families[key.joint]) for key in config.keys if key not in done]
    with progress("study", len(config.keys)) as bar:
        bar.move_to(len(done))
        for trial in run_all(run_trial, calls, backend, workers):
            write_text(_path(folder, trial.key), trial.to_json() + "\n")
            finished.append(trial)
            bar.advance()
    return finished


def _path(folder: RunFolder, key: TrialKey) -> Path:
    return folder / "trials" / key.file_name


def _load(folder: RunFolder, key: TrialKey, held_out: Sequence[str]) -> StudyTrial | None:
    path = _path(folder, key)
    if not path.exists():
        return None
    content = read_json(path, "trial", fix="delete it")
    try:
        trial = StudyTrial.from_dict(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    if trial.key != key:
        raise InputError(f"{path} is the trial {trial.key.file_name}: delete it")
    if set(trial.predictions) != set(held_out):
        raise InputError(
            f"{path} predicts {shown(list(trial.predictions))}, and the held-out curves are "
            f"{shown(list(held_out))}: delete it"
        )
    return trial


def _kept(folder: RunFolder, config: StudyConfig) -> str:
    done = sum(_path(folder, key).exists() for key in config.keys)
    return (
        f"the finished trials ({done} of {len(config.keys)}) are kept in {folder.path}/trials; run "
        "the same command again for the rest"
    )
