"""The score of muscles: metabolic power and activation of motions, and a figure of activations."""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from ...errors import InputError, unknown_name
from ..evaluation.rollout import Trace
from ..evaluation.scores import root_mean_square
from ..extras import Score, Scored
from .analysis import (
    CONVENTIONS,
    RELAXED,
    STANDARD,
    Demand,
    Shared,
    check_wearer,
    demand_of,
    muscle_activation,
    share_among_muscles,
)
from .metabolic import LEAST_HEAT, muscle_masses
from .myoarm import GROUPS, MyoArm

FULL = 0.999  # activation from which a muscle counts as saturated
LOADED = 3  # muscles that are named
FEWEST_SAMPLES = 3
MOST_OUTSIDE = 0.5
COLORS = "magma_r"
DARKEST = 99.5  # percentile of all activations that has the darkest color


def muscle_scores(
    motions: Sequence[Trace],
    *,
    conventions: Iterable[str] = tuple(CONVENTIONS),
    threads: int = 0,
    on_motion: Callable[[], None] = lambda: None,
) -> Scored:
    """Returns metabolic power and activation of the wearer's muscles (needs the extra `muscles`).

    MyoArm's muscles give the wearer's torque of every control period; method and conventions are in
    `analysis`.

    Args:
        motions: Motions of one policy, from `rollout` or `Evaluation.traces`.
        conventions: Names of conventions; the standard convention is always among them.
        threads: Number of threads; 0 uses all cores.
        on_motion: Function that is called after each motion.

    Returns:
        The costs are `power`, the metabolic power of all muscles as a mean over time [W], and
        `effort`, the root mean square activation over time and muscles. A motion that ended before
        its third sample has NaN. The facts are under the standard convention: `loaded`, the three
        muscles with the greatest root mean square activation; `without`, the power without
        co-contraction [W], if its convention is computed; `rest`, the power of muscles at rest [W],
        which `power` includes; `reserve`, the root mean square of the torque that muscles could not
        give over that of the wanted torque, and `largest_reserve` [N·m]; `saturated`, the share of
        time in which a muscle was fully active and its load may be larger; `outside`, the share of
        time in which the posture was outside a range of MyoArm.
    """
    names = tuple(dict.fromkeys((STANDARD, *conventions)))
    for name in names:
        if name not in CONVENTIONS:
            raise unknown_name("convention", name, CONVENTIONS)
    if not motions:
        raise InputError("there are no motions: give at least one")
    arm = MyoArm.load()
    power, effort = np.full((2, len(names), len(motions)), np.nan)
    squares, limits, rest = [], [], np.nan
    for i, motion in enumerate(motions):
        if len(motion.time) >= FEWEST_SAMPLES:
            demand = demand_of(motion, arm, threads=threads)
            shared = [share_among_muscles(arm, demand, CONVENTIONS[name]) for name in names]
            power[:, i] = [one.power.sum(axis=1).mean() for one in shared]
            effort[:, i] = [root_mean_square(one.activation) for one in shared]
            squares.append((shared[0].activation ** 2).mean(axis=0))
            limits.append(_limits(demand, shared[0]))
            rest = demand.scale * LEAST_HEAT * muscle_masses(arm).sum()
        on_motion()
    if not limits:
        raise InputError(
            f"no motion has {FEWEST_SAMPLES} samples, which accelerations need: give longer ones"
        )
    wanted, left, most, full, outside = np.array(limits).T
    if outside.mean() > MOST_OUTSIDE:
        raise InputError(
            f"{outside.mean():.0%} of the postures are outside the ranges of MyoArm's joints, "
            "and at most half may be: score a motion inside these ranges"
        )
    loads, relaxed = np.sqrt(np.mean(squares, axis=0)), power[[one == RELAXED for one in names]]
    loaded = np.argsort(-loads, kind="stable")[:LOADED]
    return Scored(
        costs={
            what: {name: tuple(row) for name, row in zip(names, found.tolist(), strict=True)}
            for what, found in (("power", power), ("effort", effort))
        },
        facts={
            "loaded": {arm.muscles[i]: float(loads[i]) for i in loaded},
            "without": {"co-contraction": float(np.nanmean(relaxed))} if relaxed.size else {},
            "rest": float(rest),
            "reserve": float(np.sqrt(left.mean() / max(wanted.mean(), 1e-12))),
            "largest_reserve": float(most.max()),
            "saturated": float(full.mean()),
            "outside": float(outside.mean()),
        },
    )


def _limits(demand: Demand, shared: Shared) -> list[float]:
    """Returns mean squares of wanted torque and reserve, greatest reserve, and shares of time."""
    return [
        np.square(demand.torque).sum(axis=1).mean(),
        np.square(shared.reserve).sum(axis=1).mean(),
        np.abs(shared.reserve).max(),
        (shared.activation > FULL).any(axis=1).mean(),
        demand.geometry.outside.mean(),
    ]


def activation_figure(motions: Mapping[str, Trace]) -> Figure:
    """Draws activation over time as one heat map per motion, with the muscles by group.

    The motions, by names of conditions, have the same intended motion.
    """
    names = MyoArm.load().muscles
    rows = [names.index(name) for group in GROUPS.values() for name in group]
    found = {title: muscle_activation(motion) for title, motion in motions.items()}
    most = float(np.percentile(np.concatenate(list(found.values())), DARKEST))
    figure = Figure(figsize=(2.2 + 4.3 * len(motions), 7.2), layout="constrained")
    grid = figure.subplots(1, len(motions), sharey=True, squeeze=False)[0]
    ends, shown = np.cumsum([len(group) for group in GROUPS.values()]), None
    for ax, (title, motion) in zip(grid, motions.items(), strict=True):
        style = {"aspect": "auto", "cmap": COLORS, "interpolation": "nearest"}
        extent = (0, motion.time[-1], len(rows) - 0.5, -0.5)
        shown = ax.imshow(found[title][:, rows].T, vmin=0, vmax=most, extent=extent, **style)
        mean = np.sqrt(np.mean(found[title] ** 2))
        ax.set(title=f"{title}: root mean square {mean:.1%}", xlabel="time [s]")
        for end in ends[:-1]:
            ax.axhline(end - 0.5, color="0.4", lw=0.8)
    grid[0].set_yticks(range(len(rows)), [names[row] for row in rows], fontsize=7.5)
    style = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "center", "fontsize": 9}
    for end, (name, group) in zip(ends, GROUPS.items(), strict=True):
        grid[0].annotate(name.replace(" ", "\n"), (-0.17, end - (len(group) + 1) / 2), **style)
    figure.colorbar(shown, ax=grid, label="activation", extend="max", pad=0.01)  # pyright: ignore
    return figure


SCORE = Score(
    check=check_wearer,
    scored=muscle_scores,
    figure=activation_figure,
    least={"power": 0.5, "effort": 0.002},
    units={
        **dict.fromkeys(("power", "without", "rest"), "W, not validated"),
        "largest_reserve": "N·m",
        **dict.fromkeys(("effort", "loaded", "reserve", "saturated", "outside"), "1"),
    },
    limits={
        "saturated": (
            0.0,
            "a muscle is fully active in {:.1%} of the time, so that its load may be larger than "
            "these numbers",
        ),
        "outside": (0.0, "{:.1%} of the postures are outside the ranges of MyoArm's joints"),
        "reserve": (0.01, "muscles cannot give {:.1%} of the torque"),
    },
)
"""The score that `evaluate` finds under the name muscles."""
