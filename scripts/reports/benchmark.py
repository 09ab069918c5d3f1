"""The benchmark as tables, a page and a figure."""

from typing import TYPE_CHECKING

import numpy as np

from ...envs.benchmark.standings import FIXED, Standings
from ...envs.benchmark.suite import BASELINE, Setting
from ..output import Rows, markdown_table
from .motions import interval_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PACKAGES = ("activesuit", "mujoco", "numpy", "gymnasium")
LOWEST = -1.0  # relief at which the figure begins
LINE = 0.2  # [inch], line of the legend


def level_rows(standings: Standings, level: str) -> Rows:
    """Returns a row per policy over all tasks of a level."""
    header = ["policy", "success", "relief\n(95 % interval)", f"better than\n{BASELINE}"]
    header.append("in most motions\nof the tasks")
    rows = []
    for one in standings.by_level(level):
        improvement = None if one.policy in FIXED else one.improvement
        rows.append(
            [
                one.policy if not one.failed else f"{one.policy} ({one.failed} failed)",
                f"{one.success:.0%}",
                interval_text(one.relief),
                interval_text(improvement),
                "-" if improvement is None or one.better is None else f"{one.better:.0%}",
            ]
        )
    return header, rows


def task_rows(standings: Standings, level: str) -> Rows:
    """Returns a row per setting of a level: success and mean relief of every policy."""
    settings = standings.settings_at(level)
    names = [name for name in standings.policies_at(level) if name not in FIXED[:2]]
    header = ["policy", *(f"{s.task}\n{s.believed}" for s in settings)]
    return header, [[name, *(_cell(standings, s, name) for s in settings)] for name in names]


def difference_rows(standings: Standings, one: str, other: str) -> Rows:
    """Returns a row per setting: the paired difference of relief with its interval."""
    rows = [
        [s.task, s.level, s.believed, interval_text(standings.difference(s, one, other))]
        for s in standings.settings
    ]
    return ["task", "level", "believed", "difference\n(95 % interval)"], rows


def page(standings: Standings, title: str, figure: str) -> str:
    """Returns all tables as Markdown, with the protocol above them.

    Args:
        standings: Results.
        title: Heading of the page.
        figure: Name of the file of the performance profiles.
    """
    protocol = standings.protocol
    versions = ", ".join(f"{name} {protocol[name]}" for name in PACKAGES if name in protocol)
    parts = [
        f"{title}\n\n"
        f"Made by `activesuit benchmark table` from {standings.count} trials of suite version "
        f"{protocol.get('suite_version')}, contract {protocol.get('contract')}, seeds from "
        f"{protocol.get('first_seed')} ({versions}). Success is the share of motions that went "
        "well; relief is the share of the suit's cost that is given back, the interquartile mean "
        f"over tasks, with its 95 % interval; then the probability of less effort than {BASELINE} "
        "on the same motion, and the share of settings in which that is at least 0.9.\n\n"
        f"![Performance profiles]({figure})\n"
    ]
    for level in standings.levels:
        parts.append(f"## {level}\n\n{markdown_table(*level_rows(standings, level))}\n")
    for level in standings.levels:
        header, rows = task_rows(standings, level)
        turned = [list(column) for column in zip(header, *rows, strict=True)]
        title = f"## {level}, by task: success and relief"
        parts.append(f"{title}\n\n{markdown_table(turned[0], turned[1:])}\n")
    return "\n".join(parts)


def profile_figure(standings: Standings) -> "Figure":
    """Draws performance profiles: which share of the motions has at least a relief."""
    from matplotlib.figure import Figure

    names = [name for name in standings.policies if name not in FIXED[:2]]
    size = 4.2 * len(standings.levels) + 1.6, max(4.2, LINE * len(names))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(1, len(standings.levels), squeeze=False, sharey=True)[0]
    relief = np.linspace(LOWEST, 1.5, 251)
    for ax, level in zip(axes, standings.levels, strict=True):
        for i, name in enumerate(names):
            style = ("-", "--", ":")[i // 10 % 3]
            color = "black" if name in FIXED else f"C{i % 10}"
            ax.plot(relief, standings.profile(name, level, relief), style, color=color, label=name)
        ax.set(title=level, xlabel="relief", xlim=(LOWEST, 1.5), ylim=(0, 1.01))
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("share of motions with at least that relief")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, fontsize=8)
    return figure


def _cell(standings: Standings, setting: Setting, policy: str) -> str:
    found = standings.of(setting, policy)
    if found is None:
        return "-"
    if found.failed:
        return "failed"
    relief = standings.relief(setting, policy)
    success = f"{np.mean(found.success):.0%}"
    return success if relief is None else f"{success}\n{np.mean(relief):.2f}"
