"""`activesuit demo`: from measured loops to a compensated arm motion, in one command."""

from pathlib import Path
from typing import Any

import numpy as np

from ...assets import CURVES, Suit, curves_path, load_suit
from ...checks import at_least, check_seed
from ...envs.evaluation import FIRST_SEED, Evaluation, Trace, evaluate
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.figures import motion_loops_figure, torques_figure, trajectory_figure
from ...envs.making import make_env
from ...envs.model import ASSISTED
from ...envs.rendering import RenderingUnavailableError
from ...identification import Certified, Curves, Fit, Search, Trial, identify, load_curves
from ...identification.figures import convergence_figure, loops_figure
from ..html.loops import loop_rows, write_loops
from ..html.motions import kept_motion
from ..html.writing import write_report
from ..options import Force, Motions, Seed
from ..output import Rows, RunFolder, markdown_table, progress, say, table, telling
from ..reports.fits import fit_summary, quality_table, write_trials
from ..reports.motions import score_table, story, write_scores, write_trace
from ..reports.parameters import parameter_table
from ..reports.why import why_remarks

COMPARED = ("sa-pso", "mpso", "certified")
ENV = "ActiveSuit/ArmTracking-v0"
PLANT = "mock-suit"
GRAVITIES = ("earth", "microgravity")
BELIEVING = ("feedforward", "compensation")
SIMULATED = ("none", "gravity", "feedforward", "compensation", "best-known-plan")
DRAWN = ("none", "feedforward", "compensation", "best-known-plan")
PICTURE_STEP = 150  # control periods into the motion

Fits = dict[str, dict[str, Fit]]


def demo(
    out: Path = Path("runs/demo"),
    trials: int = 30,
    motions: Motions = 20,
    seed: Seed = 0,
    force: Force = False,
) -> None:
    """Do the whole job once: identify, simulate, compensate, report.

    The curves are synthetic, made from the published parameters; see the README.

    Args:
        out: Folder for the configuration, tables, suit file, figures, report.md and report.html: a
            new or an empty one.
        trials: Number of runs of each swarm, of which the best counts; the paper has 30.
    """
    at_least("trials", trials, 1)
    at_least("motions", motions, FEWEST_MOTIONS)
    check_seed(seed)
    folder = RunFolder(out, force=force)
    _run(folder, trials, motions, seed)
    say(f"report, figures, suit and data: {out}/report.html")


def _run(folder: RunFolder, trials: int, motions: int, seed: int) -> None:
    curves = {name: load_curves(curves_path(name)) for name in CURVES}
    fits: Fits = {name: {} for name in curves}
    try:
        with telling(lambda: _kept_fits(folder.path, fits)):
            _identify(curves, fits, trials, seed)
    finally:
        _write_fits(folder, fits, _config(trials, motions, seed))
    suit = folder.claim("suit.json")
    _identified_suit(fits).save(suit)
    kept = (
        f"fits.json, trials.csv and suit.json are kept in {folder.path}; go on with: "
        f"activesuit validate {suit} --plant {PLANT} --motions {motions} --seed "
        f"{FIRST_SEED + seed}"
    )
    with telling(lambda: kept):
        fit_tables = _show_fits(folder, curves, fits)
        scores, shown = _compare(folder, suit, motions, seed)
        pictured = _picture(folder, seed)
        folder.text("report.md", _report(fit_tables, scores, pictured))
        certified = ((CURVES[name], methods["certified"]) for name, methods in fits.items())
        write_loops(folder, (row for one in certified for row in loop_rows(*one, None)))
        write_report(
            *(folder, "demo", f"{ENV}, {PLANT}"),
            answer=[f"{place}: {said}" for place, one in scores.items() for said in story(one)],
            tables={gravity: _scores(one) for gravity, one in scores.items()} | fit_tables,
            settings=_config(trials, motions, seed),
            motions=shown,
        )


def _identify(curves: dict[str, Curves], fits: Fits, trials: int, seed: int) -> None:
    """Runs all fits and puts them into `fits`, by joint and method."""
    methods = {
        name: Certified() if name == "certified" else Search(name, objective="paper", trials=trials)
        for name in COMPARED
    }
    runs = sum(method.trials for method in methods.values())
    with progress("identifying", runs * len(curves)) as bar:

        def report(trial: Trial) -> None:
            del trial
            bar.advance()

        for name, family in curves.items():
            for label, method in methods.items():
                fit = identify(family, method=method, seed=seed, on_trial=report)
                fits[name][label] = fit
                if fit.interrupted:
                    raise KeyboardInterrupt


def _kept_fits(place: Path, fits: Fits) -> str:
    done, planned = sum(map(len, fits.values())), len(COMPARED) * len(fits)
    return (
        f"the finished fits ({done} of {planned}) are kept in {place}/fits.json and "
        "trials.csv; run the demo again with --force for the rest"
    )


def _config(trials: int, motions: int, seed: int) -> dict[str, Any]:
    simulated = {"env": ENV, "plant": PLANT, "methods": COMPARED, "gravities": GRAVITIES}
    return {"trials": trials, "motions": motions, "seed": seed, **simulated}


def _write_fits(folder: RunFolder, fits: Fits, config: dict[str, Any]) -> None:
    folder.json("config.json", config)
    write_trials(folder, "trials.csv", fits)
    summaries = {
        name: {method: fit_summary(fit, config["seed"]) for method, fit in methods.items()}
        for name, methods in fits.items()
    }
    folder.json("fits.json", summaries)


def _show_fits(folder: RunFolder, curves: dict[str, Curves], fits: Fits) -> dict[str, Rows]:
    """Prints the tables of the fits and draws them; returns the tables by title."""
    models = {f"{n}\n{m}": fit.model for n, methods in fits.items() for m, fit in methods.items()}
    tables = {"Identified models": parameter_table(models), "Their quality": quality_table(fits)}
    for title, rows in tables.items():
        table(title, *rows)
    histories = {
        name: {m: [t.history for t in fit.trials] for m, fit in methods.items() if m != "certified"}
        for name, methods in fits.items()
    }
    folder.figure("loops", loops_figure(curves, fits))
    folder.figure("convergence", convergence_figure(histories))
    return tables


def _identified_suit(fits: Fits) -> Suit:
    return Suit.from_fits(
        {joint: fits[name]["certified"] for name, joint in CURVES.items()},
        name="demo",
        description="Certified fits of the demo; abduction and wrist as assumed in mock-suit.",
        base=load_suit(PLANT),
    )


def _compare(
    folder: RunFolder, suit: Path, motions: int, seed: int
) -> tuple[dict[str, Evaluation], list[dict[str, Any]]]:
    """Compares all policies; prints, draws and writes the results.

    Returns the scores by gravity, and what a report has to know of the motions.
    """
    found, traces = _simulate(suit, motions, seed)
    shown = []
    for gravity, evaluation in found.items():
        scores = list(evaluation.scores.values())
        table(f"{ENV}, {gravity}, {motions} motions", *score_table(scores, evaluation))
        for sentence in (*why_remarks(scores), *story(evaluation)):
            say(sentence)
        write_scores(folder, f"motions-{gravity}.csv", scores, FIRST_SEED + seed)
        for policy, trace in traces[gravity].items():
            name = f"trace-{gravity}-{policy}.csv"
            write_trace(folder, name, trace)
            shown.append(kept_motion(gravity, policy, name, trace))
        folder.figure(f"trajectory-{gravity}", trajectory_figure(traces[gravity]))
        folder.figure(f"torques-{gravity}", torques_figure(traces[gravity]))
        folder.figure(f"motion-loops-{gravity}", motion_loops_figure(traces[gravity]))
    folder.json("evaluation.json", {g: one.to_dict() for g, one in found.items()})
    return found, shown


def _scores(evaluation: Evaluation) -> Rows:
    return score_table(list(evaluation.scores.values()), evaluation)


def _simulate(
    suit: Path, motions: int, seed: int
) -> tuple[dict[str, Evaluation], dict[str, dict[str, Trace]]]:
    """Runs all policies on Earth and in microgravity; keeps the first motion of some."""
    found: dict[str, Evaluation] = {}
    traces: dict[str, dict[str, Trace]] = {gravity: {} for gravity in GRAVITIES}
    policies = {
        name: {"name": name, "suit": str(suit)} if name in BELIEVING else name for name in SIMULATED
    }
    with progress("simulating", len(GRAVITIES) * (len(SIMULATED) + 2) * motions) as bar:
        for gravity in GRAVITIES:

            def report(policy: str, done: list[Trace], kept=traces[gravity]) -> None:
                if policy in DRAWN:
                    kept[policy] = done[0]
                bar.advance(len(done))

            found[gravity] = evaluate(
                ENV,
                policies,
                motions=motions,
                seed=FIRST_SEED + seed,
                on_policy=report,
                suit=PLANT,
                gravity=gravity,
                threads=0,
            )
    return found, traces


def _picture(folder: RunFolder, seed: int) -> bool:
    env, arm = make_env(
        ENV, suit=PLANT, render_mode="rgb_array", width=1280, height=960, render_quality="fine"
    )
    try:
        env.reset(seed=seed)
        for _ in range(PICTURE_STEP):
            env.step(np.zeros(len(ASSISTED)))
        picture = arm.render()
    except RenderingUnavailableError as error:
        say(f"no picture of the arm: {error}")
        return False
    finally:
        env.close()
    assert picture is not None
    folder.picture("arm", picture)
    return True


def _report(fit_tables: dict[str, Rows], found: dict[str, Evaluation], pictured: bool) -> str:
    parts = ["# From measured loops to a compensated arm motion"]
    if pictured:
        parts.append("![The arm](arm.png)")
    parts += [
        "The curves are synthetic: responses of the published parameters with 1 % noise.",
        *(f"## {title}\n\n{markdown_table(*rows)}" for title, rows in fit_tables.items()),
        "The margin is the certificate's: above 0 no motion can make the torque infinite.",
        "![Loops](loops.png)",
        "![Convergence](convergence.png)",
    ]
    for gravity, evaluation in found.items():
        parts += [
            f"## What the wearer has to do: {ENV}, {gravity}",
            " ".join(story(evaluation)),
            f"The simulated suit is {PLANT}; feed-forward and compensation believe the certified "
            "fit above. Both come from the same curves, so this shows what a good model is worth, "
            "not that it is good. Wearers have repeated each motion until nothing is left to "
            "learn. Unsuited and suited are without an exoskeleton; none has one whose motors are "
            "off; the best known plan knows the true suit and the whole motion, and is the bound.",
            markdown_table(*_scores(evaluation)),
            *(f"- {one}" for one in why_remarks(list(evaluation.scores.values()))),
        ]
        for name in ("trajectory", "torques", "motion-loops"):
            parts.append(f"![{name}]({name}-{gravity}.png)")
    return "\n\n".join(parts) + "\n"
