"""Measures speed, as ratios of paired medians, and exactness."""

import platform
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from ..checks import at_least, check_seed
from ..errors import InputError
from ..scripts.engine_log import engine_warnings
from ..scripts.folders import RunFolder, to_json
from ..scripts.options import Force, Json, Seed
from ..scripts.output import table
from ..scripts.writer import Report, conclude

if TYPE_CHECKING:
    from .timing import Row

Topic = Literal[
    "all",
    "hysteresis",
    "engine",
    "model",
    "env",
    "train",
    "identify",
    "exactness",
    "device",
    "gpu",
    "sensitivity",
    "bound",
    "hindered",
    "pushes",
    "settings",
    "muscles",
    "honesty",
    "first-use",
]
PAIRS = 9
CASES = "honesty.json"  # the first file of a folder of cases
FEW, MANY = 25, 200  # cases of honesty, with --quick and without
CHANGES = 10  # of the plan of each motion


def bench(
    topic: Annotated[Topic, tyro.conf.Positional] = "all",
    /,
    repeats: int | None = None,
    quick: bool = False,
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
    worlds: tuple[int, ...] = (),
) -> None:
    """Measure speed, each row against something else in turn in this very run.

    Args:
        topic: Part whose speed is measured (train needs the extra train), or all of them; or
            exactness, which compares the kernels with their readable references, with SciPy and
            with the engine; or device, which compares the C code of models with Python (needs a C
            compiler); or gpu, which steps many worlds in MuJoCo Warp (needs the extra gpu), on the
            first CUDA device where there is one; or sensitivity, which halves and doubles assumed
            numbers (about an hour); or bound, which changes the best known plan at random under
            wearers who adapt to each change (half an hour); or hindered, which locks and throws the
            arm in every task; or pushes, on arms of usual and persistent wearers (two
            minutes); or settings, which compares policies in places, suits and couplings
            (eight minutes); or muscles, which compares MyoArm with our arm (needs the extra
            muscles); or honesty, which counts how often intervals, verdicts and searches of
            identify are right on random truths; or first-use, which compiles everything that a
            first environment needs.
        repeats: Number of pairs of measurements of each row, 9 by default; of honesty the cases of
            each cell, 200 by default; of bands, which take long, a third of it; of bound the
            changes of each of 20 motions, 10 by default.
        quick: Take 25 cases of each cell, of bands 8 (honesty).
        seed: Seed of the first case (honesty).
        out: Folder that keeps each case as it is finished, so that the same command goes on where
            it was stopped (honesty).
        worlds: Numbers of worlds, by default 1024 4096 16384 (gpu).
    """
    if repeats is not None:
        at_least("repeats", repeats, 1)
    check_seed(seed)
    if worlds and topic != "gpu":
        raise InputError(f"--worlds belongs to gpu, not to {topic}: leave it out")
    if topic == "honesty":
        folder = RunFolder(out, force=force, resumes=(out / CASES).exists()) if out else None
        _count(repeats or (FEW if quick else MANY), seed, folder, json)
        return
    if quick or out is not None or seed or force:
        raise InputError(
            f"--quick, --seed, --out and --force belong to honesty, not to {topic}: leave out"
        )
    import mujoco  # noqa: F401  (so that its warnings are kept; slow, so not for the help)

    with engine_warnings():
        if topic == "gpu":
            from . import gpu

            gpu.report(repeats or PAIRS, worlds, json)
        else:
            _measure(topic, repeats or (CHANGES if topic == "bound" else PAIRS), json)


def _count(repeats: int, seed: int, folder: RunFolder | None, json: bool) -> None:
    from . import honesty

    if folder:
        folder.json(CASES, {"topic": "honesty"})  # so that the run may go on in it
    found = honesty.honesty(repeats, seed, folder.path if folder else None)
    report = Report(
        heading="How often verdicts are right",
        about=f"{repeats} repeats",
        result={"repeats": repeats, "seed": seed, "cases": found},
        tables=honesty.tables(found),
    )
    conclude(report, folder, json)


def _measure(topic: Topic, repeats: int, json: bool) -> None:
    # Not needed by other commands, and slow to import.
    import mujoco

    from . import (
        device,
        effort,
        engine,
        env,
        exactness,
        hysteresis,
        identify,
        model,
        starts,
        train,
    )

    alone = {
        **{"exactness": exactness.report, "sensitivity": _sensitivity, "first-use": _first_use},
        **{
            "hindered": _hindered,
            "pushes": _pushes,
            "settings": _settings,
            "device": device.report,
            "muscles": _muscles,
        },
    }
    if topic == "bound":
        _bound(repeats, json)
        return
    if topic in alone:
        alone[topic](json)
        return
    topics: dict[str, Callable[[int], list[Row]]] = {
        "hysteresis": hysteresis.rows,
        "engine": engine.rows,
        "model": model.rows,
        "env": env.rows,
        "identify": identify.rows,
    }
    rows = [row for name, run in topics.items() if topic in (name, "all") for row in run(repeats)]
    learners = []
    if topic == "train" or (topic == "all" and find_spec("stable_baselines3")):  # env says so
        compared, learners = train.training(repeats)
        rows += compared
    found = starts.random_starts(repeats) if topic in ("identify", "all") else []
    errors = model.step_errors() if topic in ("model", "all") else []
    costs = effort.suit_costs() if topic in ("model", "all") else []
    machine = f"{platform.processor() or platform.machine()}, MuJoCo {mujoco.__version__}"
    if json:
        parts = {
            **{"rows": rows, "training": learners, "starts": found},
            **{"step_errors": errors, "suit_costs": costs},
        }
        content = {name: [one.to_dict() for one in part] for name, part in parts.items()}
        print(to_json({"machine": machine, "repeats": repeats, **content}))
        return
    table(
        f"medians of {repeats} pairs; {machine}",
        ["ours\nagainst", "time", "processor\ntime", "ratio", "lowest\nhighest", "target"],
        map(_cells, rows),
    )
    if learners:
        table("steps of PPO, and where their time goes", *train.training_table(learners))
    if errors:
        table("RMS differences from physics steps of 0.125 ms", *model.step_table(errors))
    if costs:
        table("effort in a suit over effort without", *effort.cost_table(costs))
        print(effort.SIMULATED)
    if found:
        table("fits from random starts", *starts.starts_table(found))


def _sensitivity(json: bool) -> None:
    from . import sensitivity

    cases = sensitivity.sensitivity()
    if json:
        print(to_json({"cases": [case.to_dict() for case in cases]}))
    else:
        table("assumed numbers halved and doubled", *sensitivity.sensitivity_table(cases))


def _bound(repeats: int, json: bool) -> None:
    from . import bound

    found = bound.attacks(repeats)
    if json:
        print(to_json({"attacks": [one.to_dict() for one in found]}))
    else:
        table("random changes of the best known plan", *bound.attack_table(found))


def _settings(json: bool) -> None:
    from .settings import settings

    found = settings()
    tables = found.pop("tables")
    if json:
        print(to_json(found))
        return
    for title, rows in tables.items():
        table(title, *rows)


def _hindered(json: bool) -> None:
    from . import hindered

    found = hindered.hindered()
    if json:
        print(to_json({"tasks": [one.to_dict() for one in found]}))
    else:
        table("arms that are hindered", *hindered.hindered_table(found))


def _pushes(json: bool) -> None:
    from . import pushes

    found = pushes.pushes()
    if json:
        print(to_json({"wearers": found}))
    else:
        table("pushes on held arms", *pushes.pushes_table(found))


def _muscles(json: bool) -> None:
    from . import muscles

    muscles.report(json)


def _first_use(json: bool) -> None:
    from . import first_use

    uses = first_use.first_uses()
    if json:
        print(to_json({"uses": [use.to_dict() for use in uses]}))
        return
    for title, (header, rows) in first_use.tables(uses).items():
        table(title, header, rows)


def _cells(row: "Row") -> Sequence[str]:
    verdict = "met" if row.met else "NOT met"
    if row.ratio is None:
        goal = "-" if row.limit is None else f"<= {row.limit:g} {verdict}"
        return row.what, f"{row.ours:.3g} {row.unit}", _cpu(row.cpu), "", "", goal
    return (
        f"{row.what}\n{row.against}",
        f"{row.ours:.3g} {row.unit}\n{row.reference:.3g} {row.unit}",
        f"{_cpu(row.cpu)}\n{_cpu(row.reference_cpu)}",
        f"{row.ratio:.3g}",
        f"{row.lowest:.3g}\n{row.highest:.3g}",
        f">= {row.target:g} {verdict}" if row.target else "-",
    )


def _cpu(time: float | None) -> str:
    return "" if time is None else f"{time:.3g}"
