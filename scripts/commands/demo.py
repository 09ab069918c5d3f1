"""`activesuit demo`: from measured loops to a compensated arm motion, in one command."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...assets import CURVES, Suit, curves_path, load_suit
from ...checks import at_least, check_seed
from ...envs.evaluation import FIRST_SEED, Evaluation, evaluate
from ...envs.evaluation.figures import motion_plots
from ...envs.evaluation.report import score_table
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.making import make_env
from ...envs.model import ASSISTED
from ...envs.rendering import RenderingUnavailableError
from ...hysteresis.parameter_table import parameter_table
from ...identification import Certified, Curves, Fit, Search, fit_curves, load_curves
from ...identification.figures import COLUMNS, compared, convergence_plot, loop_rows, loops_plot
from ...identification.report import fit_summary, quality_table, trial_columns
from ...text import say
from ..folders import RunFolder
from ..options import Force, Motions, Seed
from ..output import progress, telling
from ..writer import Report, conclude

COMPARED = ("sa-pso", "mpso", "certified")
ENV = "ActiveSuit/ArmTracking-v0"
PLANT = "mock-suit"
GRAVITIES = ("earth", "microgravity")
BELIEVING = ("feedforward", "compensation")
SIMULATED = ("none", "gravity", "feedforward", "compensation", "best-known-plan")
MOTIONS_DRAWN = ("trajectory", "torques", "motion-loops")
DRAWN = ("none", "feedforward", "compensation", "best-known-plan")
PICTURE_STEP = 150  # control periods into the motion

Fits = dict[str, dict[str, Fit]]


def demo(
    out: Path | None = None,
    trials: int = 30,
    motions: Motions = 20,
    seed: Seed = 0,
    force: Force = False,
) -> Report:
    """Do the whole job once: identify, simulate, compensate, report.

    The curves are synthetic, made from the published parameters; see the README. The simulated suit
    and the suit of the certified fits come from the same curves, so the demo shows the value of a
    good model, and does not show that the model is good.

    Args:
        out: Folder for suit.json, result.json, tables, figures and report.html: a new or an empty
            folder; by default runs/demo, or runs/demo-2, ...
        trials: Number of runs of each swarm, of which the best run counts; the paper has 30.

    Returns:
        Tables, sentences, figures and plain values.
    """
    at_least("trials", trials, 1)
    at_least("motions", motions, FEWEST_MOTIONS)
    check_seed(seed)
    folder = RunFolder.of(out, "demo", force=force)
    curves = {name: load_curves(curves_path(name)) for name in CURVES}
    fits: Fits = {name: {} for name in curves}
    try:
        with telling(lambda: _kept_fits(folder.path, fits)):
            _identify(curves, fits, trials, seed)
    finally:
        folder.json("fits.json", _summaries(fits, seed))
        folder.csv("trials.csv", *trial_columns(fits))
    suit = folder / "suit.json"
    Suit.from_fits(
        {joint: fits[name]["certified"] for name, joint in CURVES.items()},
        name="demo",
        description="Certified fits of the demo; abduction and wrist as assumed in mock-suit.",
        base=load_suit(PLANT),
    ).save(suit)
    kept = (
        f"fits.json, trials.csv and suit.json are kept in {folder.path}; go on with: "
        f"activesuit validate {suit} --plant {PLANT} --motions {motions} --seed "
        f"{FIRST_SEED + seed}"
    )
    with telling(lambda: kept):
        found = _simulate(suit, motions, seed)
        picture = _picture(seed)
        config = {"trials": trials, "motions": motions, "seed": seed, "env": ENV}
        config |= {"plant": PLANT, "methods": COMPARED, "gravities": GRAVITIES}
        report = _report(curves, fits, found, picture, config)
        conclude(report, folder)
        return report


def _identify(curves: dict[str, Curves], fits: Fits, trials: int, seed: int) -> None:
    """Runs all fits and puts them into `fits`, by joint and method."""
    methods = {
        name: Certified() if name == "certified" else Search(name, objective="paper", trials=trials)
        for name in COMPARED
    }
    runs = sum(method.trials for method in methods.values())
    with progress("identifying", runs * len(curves)) as bar:
        for name, family in curves.items():
            for label, method in methods.items():
                fit = fit_curves(family, method=method, seed=seed, on_trial=lambda _: bar.advance())
                fits[name][label] = fit
                if fit.interrupted:
                    raise KeyboardInterrupt


def _kept_fits(place: Path, fits: Fits) -> str:
    done, planned = sum(map(len, fits.values())), len(COMPARED) * len(fits)
    return (
        f"the finished fits ({done} of {planned}) are kept in {place}/fits.json and "
        "trials.csv; run the demo again with --force for the rest"
    )


def _summaries(fits: Fits, seed: int) -> dict[str, Any]:
    return {
        name: {method: fit_summary(fit, seed) for method, fit in methods.items()}
        for name, methods in fits.items()
    }


def _simulate(suit: Path, motions: int, seed: int) -> dict[str, Evaluation]:
    """Runs all policies on Earth and in microgravity."""
    found: dict[str, Evaluation] = {}
    policies = {
        name: {"name": name, "suit": str(suit)} if name in BELIEVING else name for name in SIMULATED
    }
    with progress("simulating", len(GRAVITIES) * (len(SIMULATED) + 2) * motions) as bar:
        for gravity in GRAVITIES:
            found[gravity] = evaluate(
                ENV,
                policies,
                motions=motions,
                seed=FIRST_SEED + seed,
                on_policy=lambda _, traces: bar.advance(len(traces)),
                suit=PLANT,
                gravity=gravity,
                threads=0,
            )
    return found


def _picture(seed: int) -> np.ndarray | None:
    """Returns a picture of the arm in the middle of a motion; None without OpenGL."""
    env, arm = make_env(
        ENV, suit=PLANT, render_mode="rgb_array", width=1280, height=960, render_quality="fine"
    )
    try:
        env.reset(seed=seed)
        for _ in range(PICTURE_STEP):
            env.step(np.zeros(len(ASSISTED)))
        return arm.render()
    except RenderingUnavailableError as error:
        say(f"no picture of the arm: {error}")
        return None
    finally:
        env.close()


def _report(
    curves: Mapping[str, Curves],
    fits: Fits,
    found: Mapping[str, Evaluation],
    picture: np.ndarray | None,
    config: Mapping[str, Any],
) -> Report:
    tables, answer, columns, plots = {}, [], {}, {}
    for gravity, one in found.items():
        title = f"What the wearer has to do: {ENV}, {gravity}, {config['motions']} motions"
        tables[title] = score_table([*one.scores.values()], one)
        answer += [f"{gravity}: {sentence}" for sentence in one.sentences()]
        drawn = {policy: one.traces[policy][0] for policy in DRAWN}
        for name, series in one.columns().items():
            columns[f"{Path(name).stem}-{gravity}.csv"] = series
        for name, plot in motion_plots(drawn, gravity).items():
            if name in MOTIONS_DRAWN:
                plots[f"{name}-{gravity}"] = plot
    models = {f"{n}\n{m}": fit.model for n, methods in fits.items() for m, fit in methods.items()}
    tables |= {"Identified models": parameter_table(models), "Their quality": quality_table(fits)}
    rows = []
    for name, methods in fits.items():
        beside = {label: compared(curves[name], fit) for label, fit in methods.items()}
        plots[f"loops-{name}"] = loops_plot(name, beside)
        rows += loop_rows(CURVES[name], beside["certified"])
    histories = {
        name: {m: [t.history for t in fit.trials] for m, fit in methods.items() if m != "certified"}
        for name, methods in fits.items()
    }
    return Report(
        heading="From measured loops to a compensated arm motion",
        about=f"{ENV}, {PLANT}",
        result={
            **config,
            "evaluation": {gravity: one.to_dict() for gravity, one in found.items()},
            "fits": _summaries(fits, config["seed"]),
        },
        tables=tables,
        answer=answer,
        columns={**columns, "loops.csv": (COLUMNS, rows)},
        plots={**plots, "convergence": convergence_plot(histories)},
        pictures={} if picture is None else {"arm": picture},
        settings=config,
    )
