"""Li et al. (2022), repeated: does SA-PSO identify a joint better than MPSO?

    python -m activesuit.reproductions.li_2022 --trials 30

Z. Li et al., "Jiles-Atherton-based hysteresis identification of joint resistant torque in active
spacesuit using SA-PSO algorithm", Int. J. Aerospace Eng. 7535450 (2022). The measurements of the
paper are not public. The shipped curves are responses of its SA-PSO parameters with 1 % noise, so
that the methods are compared, and not the data.
"""

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..assets import curves_path
from ..hysteresis import JilesAtherton
from ..identification import Certified, Curve, Fit, Search, bare, fit_curves, load_curves
from ..identification.data.curves import noise_floor
from ..published import LI_TABLE_2
from .li_2022_figures import drawn
from .results import Results, run
from .verdicts import RULE, judged, percent

JOINTS = ("shoulder", "elbow")
# The paper compares "sa-pso" and "mpso". Another SA-PSO has the textbook's first temperature in
# place of eq. (11), and the certified fit is our own.
METHODS = {"sa-pso": {}, "sa-pso, ln 5": {"temperature": "ln5"}, "mpso": {}, "certified": {}}
SUCCESS = 1.05  # largest ratio of a successful fitness to that of the noise
AS_WELL = 1.1  # a few hundred samples of noise alone differ by 3 %
CONVERGED = 1.01  # ratio to the final fitness at the iteration of convergence

# Each for SA-PSO and MPSO. Table 2, last row: the best fitness, read as times 1e-3. Section 5.2:
# the iteration of convergence. Section 5.3: the largest errors [N·m] on each predicted curve.
FITNESS = {"shoulder": (1.5473e-3, 1.7709e-3), "elbow": (1.1770e-3, 1.7243e-3)}
ITERATIONS = {"shoulder": (48, 51), "elbow": (69, 83)}
LARGEST = {
    "shoulder": {"0.70": (1.39, 1.84), "1.05": (0.41, 2.95)},
    "elbow": {"1.05": (1.84, 0.91), "1.40": (0.79, 1.08)},
}


class Runs(NamedTuple):
    """All trials of one method on one joint."""

    joint: str
    method: str
    fit: Fit  # the best trial, and all others
    fitness: Array  # eq. (7), (trials,)
    floor: float  # fitness of the noise alone
    converged: Array  # iteration of convergence, (trials,); 0 where a method has no iterations
    first_order: dict[str, Array]  # errors on curves that were not fitted [N·m], (trials, samples)
    more_turns: dict[str, Array]  # errors on motions that turn more than once, likewise
    motions: Sequence[Curve]  # these motions

    @property
    def best(self) -> int:
        """Number of the trial with the lowest fitness."""
        return int(np.argmin(self.fitness))

    @property
    def mean_largest(self) -> Array:
        """Mean over the first-order curves of the largest error [N·m], (trials,)."""
        return np.mean([np.abs(one).max(axis=1) for one in self.first_order.values()], axis=0)


def runs_of(
    joint: str,
    method: str,
    *,
    trials: int,
    seed: int,
    iterations: int = 100,
    velocity_limit: float = 0.2,
) -> Runs:
    """Identifies a joint by one of `METHODS`, again and again.

    Args:
        joint: One of `JOINTS`.
        method: One of `METHODS`.
        trials: Number of runs.
        seed: Seed of all random numbers.
        iterations: Number of moves of a swarm.
        velocity_limit: Vmax over the range of each parameter, of a swarm; assumed, since the paper
            does not print it.
    """
    curves = load_curves(curves_path(joint))
    motions = load_curves(curves_path(joint).with_stem(f"{joint}_multi_order"))
    chosen = Certified(trials=trials)
    if method != "certified":
        sizes = {"trials": trials, "max_iterations": iterations, "velocity_limit": velocity_limit}
        name = method.removesuffix(", ln 5")
        chosen = Search(name, objective="paper", **sizes, **METHODS[method])
    fit = fit_curves(curves, method=chosen, seed=seed + zlib.crc32(f"{joint} {method}".encode()))
    models = [replace(fit, model=trial.model) for trial in fit.trials]
    histories = [np.array(trial.history or [1.0]) for trial in fit.trials]
    # The scattered swarm is iteration 1.
    converged = [np.argmax(x <= CONVERGED * x[-1]) + float(x.size > 1) for x in histories]
    root = np.sqrt(sum(curve.torque.size for curve in curves.fitted()))
    first, more = (
        {one.name: np.array([fit.predict(one) - one.torque for fit in models]) for one in family}
        for family in (curves.held_out(), motions)
    )
    fitness = np.array([trial.nrmse for trial in fit.trials]) / root
    floor = noise_floor(curves.fitted()) / curves.fitted().peak / root
    return Runs(joint, method, fit, fitness, floor, np.array(converged), first, more, motions)


def spread(values: Array, form: str = ".2f") -> list[str]:
    """Returns the median, and the quartiles as "0.40 to 0.53"."""
    # Between a finite and an infinite value there is no middle.
    method = "linear" if np.isfinite(values).all() else "higher"
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75], method=method)
    return [f"{middle:{form}}", f"{low:{form}} to {high:{form}}"]


def table_2(results: Results, found: Sequence[Runs]) -> None:
    """Prints the best parameters beside those of the paper."""
    rows = []
    for one in found:
        model = bare(one.fit.trials[one.best].model)
        assert isinstance(model, JilesAtherton)
        sets = {}
        if printed := LI_TABLE_2.get(f"{one.joint}-{one.method}"):
            sets["paper"] = (*printed, FITNESS[one.joint][one.method == "mpso"])
        sets["here"] = (model.Ms, model.a, model.alpha, model.c, model.k, one.fitness.min())
        for source, values in sets.items():
            rows.append([one.joint, one.method, source, *(f"{value:.6g}" for value in values)])
    results.table(
        "Table 2: parameters of the best trial",
        "Ms is in N·m, a and k are in degrees, alpha is in degrees per N·m, and the fitness is "
        "eq. (7). The fitness of the paper is that of its own measurements.",
        "joint | method | from | Ms | a | alpha | c | k | fitness",
        rows,
    )


def all_trials(results: Results, found: Sequence[Runs]) -> None:
    """Prints how often and how soon each method is at the noise."""
    rows = []
    for one in found:
        reached = f"{np.sum(one.fitness <= SUCCESS * one.floor)} of {one.fitness.size}"
        runs = f"{np.median([trial.evaluations or 0 for trial in one.fit.trials]):,.0f}"
        converged = spread(one.converged, ".0f") if one.converged.any() else ["-", "-"]
        numbers = [*spread(one.fitness, ".2e"), reached, *converged, runs]
        rows.append([one.joint, one.method, *numbers])
    results.table(
        "Figure 4: fitness and convergence of all trials",
        "Medians and quartiles over the trials. At the noise: trials within 5 % of the fitness of "
        "the noise. The iteration of convergence is the first within 1 % of a trial's own best; a "
        "swarm that stagnates early converges early. Runs are those of the model in one trial.",
        "joint | method | fitness | quartiles | at the noise | iteration | quartiles | runs",
        rows,
    )


def predictions(results: Results, found: Sequence[Runs]) -> None:
    """Prints the errors on held-out first-order curves beside those of the paper."""
    rows = []
    for one in found:
        for name, errors in one.first_order.items():
            is_printed, largest = (
                f"{one.joint}-{one.method}" in LI_TABLE_2,
                np.abs(errors).max(axis=1),
            )
            printed = f"{LARGEST[one.joint][name][one.method == 'mpso']:.2f}" if is_printed else "-"
            numbers = [printed, f"{largest[one.best]:.2f}", *spread(largest)]
            rows.append([one.joint, name, one.method, *numbers])
    results.table(
        "Figure 8: largest errors on curves that were not fitted",
        "In N·m, on curves that turn back at the given angle [rad].",
        "joint | curve | method | printed | best trial | median | quartiles",
        rows,
    )


def more_turns(results: Results, found: Sequence[Runs]) -> None:
    """Prints how motions of more turns are predicted, the future work of the paper."""
    rows = []
    for one in found:
        first, more = (
            np.sqrt(np.mean([np.mean(errors**2, axis=1) for errors in family.values()], axis=0))
            / one.fit.curves.fitted().peak
            for family in (one.first_order, one.more_turns)
        )
        numbers = [*(spread(values, ".2%")[0] for values in (first, more)), *spread(more / first)]
        as_well = f"{np.sum(more <= AS_WELL * first)} of {more.size}"
        rows.append([one.joint, one.method, *numbers, as_well])
    results.table(
        "Section 6: motions that turn more than once",
        "NRMSE on curves that were not fitted, medians over the trials: first-order curves, and "
        "three random motions of eight turns inside the fitted range. The ratio is that of the two "
        f"in each trial; the last column counts the trials with a ratio of at most {AS_WELL}.",
        "joint | method | first-order | more turns | ratio | quartiles | as well",
        rows,
    )


def claims(results: Results, found: Sequence[Runs], seed: int) -> None:
    """Prints the verdict on each claim of section 5."""
    rows, by_name = [], {(one.joint, one.method): one for one in found}
    for joint in JOINTS:
        sa_pso, mpso = by_name[joint, "sa-pso"], by_name[joint, "mpso"]
        errors = tuple(np.mean([*LARGEST[joint].values()], axis=0))
        for title, printed, ours, other in (
            ("iteration of convergence", ITERATIONS[joint], sa_pso.converged, mpso.converged),
            ("best fitness", FITNESS[joint], sa_pso.fitness, mpso.fitness),
            ("mean largest error [N·m]", errors, sa_pso.mean_largest, mpso.mean_largest),
        ):
            # Of predictions the paper prints the errors, and no percentage.
            wanted = 0.0 if printed is errors else printed[1] / printed[0] - 1
            shown = percent(wanted) if wanted else "better"
            of_best = percent(other[mpso.best] / ours[sa_pso.best] - 1)
            verdict = judged(ours, other, wanted, seed=seed)
            numbers = [f"{printed[0]:.5g} / {printed[1]:.5g}", shown, of_best, *verdict.cells]
            rows.append([f"{joint}, {title}", *numbers])
    results.table(
        "Section 5: the claims for SA-PSO",
        f"The paper compares the best of 30 trials; the verdict is that of the medians. {RULE}",
        "claim: SA-PSO / MPSO | printed | printed advantage | advantage of our best trials | "
        "our medians | our advantage | verdict",
        rows,
        on_page=True,
    )


def main(
    trials: int = 30,
    seed: int = 0,
    iterations: int = 100,
    out: Path = Path("runs/li_2022"),
    page: Path | None = None,
) -> None:
    """Compare SA-PSO with MPSO as Li et al. (2022) do, and judge the claims of the paper.

    Args:
        trials: Number of runs of each method on each joint; the paper has 30.
        seed: Seed of all random numbers.
        iterations: Number of moves of a swarm; the paper has 100.
        out: Folder for the figures, tables.md and trials.csv.
        page: Page of the documentation that gets the tables between its marks.
    """
    sizes = {"trials": trials, "iterations": iterations}
    found = [runs_of(joint, method, seed=seed, **sizes) for joint in JOINTS for method in METHODS]
    results = Results(out)
    claims(results, found, seed)
    for show in (table_2, all_trials, predictions, more_turns):
        show(results, found)
    numbers = [np.transpose([one.fitness, one.converged, one.mean_largest]) for one in found]
    rows = [[*one[:2], *row] for one, trials in zip(found, numbers, strict=True) for row in trials]
    header = ["joint", "method", "fitness", "converged_at", "mean_largest_error_nm"]
    results.csv("trials.csv", header, rows)
    results.figures(drawn(found))
    results.finish(page)


if __name__ == "__main__":
    run(main)
