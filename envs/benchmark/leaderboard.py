"""The benchmark as tables, sentences, a page and a figure."""

import sys
from collections.abc import Iterator, Sequence
from json import loads
from typing import Any

import numpy as np

from ...errors import InputError, shown
from ...plots import Line, Panel, Plot
from ...tables import Rows, markdown_table
from ...text import without_markup
from ..domain.levels import COMPARED
from ..evaluation import FIRST_SEED
from ..evaluation.reasons import Frequent
from ..evaluation.sentences import exceeded, motions_text
from ..evaluation.statistics import interval_text
from ..policies import POLICIES, needed_options
from ..policies.trained import shipped_policies
from .results import Result
from .standings import FIXED, MARGIN, Standings
from .suites import BASELINE, BELIEVED, SUITES, VERSION, Setting

PACKAGES = ("activesuit", "mujoco", "numpy", "gymnasium")
TITLE, FIGURE = "# Controllers compared", "profiles.png"
READING = (
    "**How to read this.** Each table is a level: how much differs from what a controller was "
    "made for. *Success* is the share of motions that meet the limits of their task. *Relief* "
    "is the share of the suit's cost that the wearer gets back: 0 is the suit without an "
    "exoskeleton, 1 is no suit. It is the interquartile mean over settings, and a setting is "
    "a task with a believed suit. The 95 % interval beside it is what *other motions* of these "
    "tasks would tell; the next column is what *other tasks* like these would. *Relief "
    "of joints with motors* counts the effort of shoulder flexion and elbow alone. *Mean* "
    "counts harm in full, which the interquartile mean leaves out. *Worst setting* is the "
    f"least mean relief. *Relief less {BASELINE}'s* compares both in the same motions. "
    "*Better / alike / "
    f"worse* are the shares of these motions with at least {MARGIN:g} more relief, about as "
    "much, and less. *Sensors* are the suites that a policy needs. `best-known-plan` is a plan "
    "that knows the true suit and the whole motion; it is the bound, not a controller."
)
CELLS = "Each row is a setting. Each cell has the success of a policy there, then its mean relief."
LOWEST = -1.0  # relief at which the figure begins
MOST_COLORED = 8  # policies
FAINT = "#b9bdc4"


class Leaderboard(Standings):
    """Results of a benchmark beside each other, as tables, sentences and figures."""

    def to_dict(self) -> dict[str, Any]:
        """Returns all trials as plain values."""
        return {"trials": [loads(one.to_json()) for one in self.results]}

    def tables(self) -> dict[str, Rows]:
        """Returns the tables of all levels by title."""
        tables = {f"{one}: all tasks": _level_rows(self, one) for one in self.levels}
        for one in self.levels:
            tables[f"{one}: success and relief by task"] = _task_rows(self, one)
        return tables

    def sentences(self) -> list[str]:
        """Returns sentences about best policies, limits, and failed motions and trials."""
        return [
            *_best_policies(self),
            *benchmark_remarks(self.results),
            *_contract_remarks(self),
            *_motion_remarks(self),
            *(
                f"{one.policy} failed in {one.task} at {one.level}: {one.failed}"
                for one in self.results
                if one.failed
            ),
        ]

    def plots(self) -> dict[str, Plot]:
        """Returns the performance profiles: the share of motions with at least a relief."""
        return {"profiles": _profile_plot(self)}

    def differences(self, policies: Sequence[str]) -> dict[str, Rows]:
        """Returns the paired differences of relief to the first policy, by the names of the others.

        Each table has a row per setting, with the 95 % interval.
        """
        if len(policies) < 2:
            raise InputError("compare needs two policies: add --policies with both names")
        first, *others = policies
        header = ["task", "level", "believed", "difference\n(95 % interval)"]
        return {
            other: (
                header,
                [[*s, interval_text(self.difference(s, other, first))] for s in self.settings],
            )
            for other in others
        }

    def page(self, title: str = TITLE, figure: str = FIGURE) -> str:
        """Returns all tables as Markdown, with heading, figure of profiles and protocol."""
        protocol = {key: without_markup(str(value)) for key, value in self.protocol.items()}
        versions = ", ".join(f"{name} {protocol[name]}" for name in PACKAGES if name in protocol)
        parts = [
            f"{title}\n\n{READING}{_best(self)}\n\n"
            f"![Share of motions with at least a relief, by policy and level]({figure})\n"
        ]
        for level in self.levels:
            parts.append(f"## {level}\n\n{_safe(_level_rows(self, level))}\n")
        for level in self.levels:
            title = f"## {level}, by task: success and relief"
            parts.append(f"{title}\n\n{CELLS}\n\n{_safe(_task_rows(self, level))}\n")
        parts.append(
            f"Made by `activesuit benchmark table` from {len(self.results)} trials of suite "
            f"version {protocol.get('suite_version')}, with seeds from "
            f"{protocol.get('first_seed')} ({versions}; contract {protocol.get('contract')}). "
            "Results are taken as they are: nothing proves that a file of results comes from the "
            "runs that it names.\n"
        )
        return "\n".join(parts)


def _level_rows(standings: Standings, level: str) -> Rows:
    """Returns a row per policy over all tasks of a level."""
    header = [
        *("policy", "sensors", "success", "relief\n(other motions)", "other tasks"),
        "relief of\njoints with motors",
        *("mean", "worst setting", f"relief less\n{BASELINE}'s", "better / alike / worse"),
    ]
    rows = []
    for one in standings.by_level(level):
        gain, compared = (None, None) if one.policy in FIXED else (one.gain, one.compared)
        cells = [
            one.policy if not one.failed else f"{one.policy} ({one.failed} failed)",
            _sensors(one.policy),
            f"{one.success:.0%}",
            interval_text(one.relief),
            interval_text(one.over_tasks).partition(" ")[2].strip("()"),
            interval_text(one.assisted),
            "" if one.mean is None else f"{one.mean:.2f}",
            "" if one.worst is None else f"{one.worst[0]:.2f} {one.worst[1].task}",
            interval_text(gain),
            " / ".join(f"{share:.0%}" for share in compared or ()),
        ]
        rows.append([cell or "-" for cell in cells])
    return header, rows


def _sensors(policy: str) -> str:
    """Returns the sensor suites that a policy needs, by its label; a dash if unknown.

    The suites of a user's class are known if its module is imported; this function imports nothing.
    """
    name, _, attribute = policy.partition(":")
    name = name.removesuffix("-tuned")
    if name in shipped_policies():
        return ", ".join(needed_options(name)["sensors"])
    own = getattr(sys.modules.get(name), attribute.partition(":")[0], None)
    sensors = getattr(POLICIES.get(name, own), "sensors", None)
    known = isinstance(sensors, list | tuple) and all(isinstance(one, str) for one in sensors)
    return ", ".join(sensors) if known and sensors else "-"


def _contract_remarks(standings: Standings) -> Iterator[str]:
    """Yields a sentence with the reasons why results cannot be compared with the leaderboard."""
    protocol = standings.protocol
    contract = str(protocol.get("contract"))
    if contract in {known.contract for known in SUITES.values()}:
        return
    suits = {setting.believed for setting in standings.settings} - {*BELIEVED}
    levels = {setting.level for setting in standings.settings} - {*COMPARED}
    options, version = protocol.get("options"), protocol.get("suite_version")
    reasons = [f"the suit {one}" for one in sorted(suits)]
    reasons += [f"the level {one}" for one in sorted(levels)]
    if isinstance(options, dict):
        reasons.append(f"the options {', '.join(options)}")
    if protocol.get("first_seed") != FIRST_SEED:
        reasons.append(f"the seeds from {protocol.get('first_seed')}")
    if version != VERSION:
        reasons.append(f"version {version} of the suites")
    because = " and ".join(reasons) or "other tasks, levels, suits or wearers in their version"
    yield (
        f"note: because of {because} these results can be compared with each other, and not with "
        f"the leaderboard; their contract is {shown(contract)} (docs/benchmark.md#contract)"
    )


def _motion_remarks(standings: Standings) -> Iterator[str]:
    """Yields a sentence for each task in which some motions are the same."""
    fewest: dict[str, Result] = {}
    for one in standings.results:
        if len({*one.motion}) < len(one.motion):
            fewest.setdefault(one.task, one)
    for task, one in fewest.items():
        yield (
            f"{task}: {len(one.motion)} motions are {len({*one.motion})} different ones at "
            f"{one.level}, so that intervals over motions are too narrow there"
        )


def _task_rows(standings: Standings, level: str) -> Rows:
    """Returns a row per setting of a level: success and mean relief of every policy."""
    settings = standings.settings_at(level)
    names = [name for name in standings.policies_at(level) if name not in FIXED[:2]]
    cells = [[_cell(standings, setting, name) for name in names] for setting in settings]
    rows = [[f"{s.task}\n{s.believed}", *row] for s, row in zip(settings, cells, strict=True)]
    return ["task\nand suit", *names], rows


def _best_policies(standings: Standings) -> Iterator[str]:
    """Yields a sentence per level: the policy with the most relief, and the bound."""
    for level in standings.levels:
        found = [one for one in standings.by_level(level) if one.relief is not None]
        best = next((one for one in found if one.policy not in FIXED), None)
        if best is not None:
            bound = [interval_text(one.relief) for one in found if one.policy == FIXED[2]]
            beside = f"; that of the best known plan is {bound[0]}" if bound else ""
            yield (
                f"{level}: {best.policy} has the most relief, {interval_text(best.relief)}, and "
                f"succeeds in {best.success:.0%} of its motions{beside}."
            )


def _safe(rows: Rows) -> str:
    """Returns a table as Markdown, without markup from names of files."""
    header, body = rows
    safe = [[*map(without_markup, row)] for row in body]
    return markdown_table([*map(without_markup, header)], safe)


def _best(standings: Standings) -> str:
    """Returns a sentence if the policy with the best relief has not the most success."""
    level = standings.levels[0]
    found = [
        (one.relief.value, one.success, f"`{one.policy.replace('`', '')}`")
        for one in standings.by_level(level)
        if one.policy not in FIXED and one.relief is not None
    ]
    if not found:
        return ""
    (relief, success, name), most = found[0], max(found, key=lambda one: one[1])
    if success == most[1]:
        return ""
    return (
        f" **The best relief is not the best success**: at {level} {name} has the most "
        f"relief ({relief:.2f}) and succeeds in {success:.0%} of its motions; "
        f"{most[2]} succeeds in {most[1]:.0%} with a relief of {most[0]:.2f}."
    )


def _profile_plot(standings: Standings) -> Plot:
    """Returns performance profiles, with the policies of most mean relief in color."""
    names = [name for name in standings.policies if name not in FIXED]
    means = dict.fromkeys((name for name in names if not name.endswith("-tuned")), -np.inf)
    for name in means:
        found = (standings.standing(name, standings.settings_at(x)) for x in standings.levels)
        if reliefs := [one.relief.value for one in found if one.relief is not None]:
            means[name] = float(np.mean(reliefs))
    best = sorted(means, key=means.__getitem__, reverse=True)[:MOST_COLORED]
    best += [FIXED[2]] * (FIXED[2] in standings.policies)
    relief, panels = np.linspace(LOWEST, 1.5, 251), []
    for level in standings.levels:
        share = {name: standings.profile(name, level, relief) for name in (*names, *best)}
        behind = [Line(relief, share[n], width=0.8, color=FAINT) for n in names if n not in best]
        marks = [*behind, *(Line(relief, share[name], name) for name in best)]
        panels.append(Panel(x="relief", y="share of motions", marks=marks, title=level))
    return Plot(title="Share of motions with at least a relief", panels=panels, height=2.8)


def _cell(standings: Standings, setting: Setting, policy: str) -> str:
    """Returns the success of a policy in a setting, and below it the mean relief."""
    found = standings.of(setting, policy)
    if found is None:
        return "-"
    if found.failed:
        return "failed"
    relief = standings.relief(setting, policy)
    value = f"{np.mean(found.success):.0%}"
    return value if relief is None else f"{value}\n{np.mean(relief):.2f}"


def benchmark_remarks(results: Sequence[Result]) -> Iterator[str]:
    """Yields a sentence for each level and policy with failed motions.

    The numbers of each limit are of the task in which most motions exceeded the limit.
    """
    for level, policy in dict.fromkeys((one.level, one.policy) for one in results):
        mine = [one for one in results if (one.level, one.policy) == (level, policy)]
        motions = [success for one in mine for success in one.success]
        found: dict[str, list[tuple[Frequent, str]]] = {}
        for one in mine:
            for why in one.why:
                found.setdefault(why.name, []).append((why, one.task))
        parts = []
        for same in found.values():
            why, task = max(same, key=lambda pair: pair[0].motions)
            most = f", most in {task}" if len({one.task for one in mine}) > 1 else ""
            total = sum(one.motions for one, _ in same)
            parts.append((total, f"{exceeded(why)} ({motions_text(total)}{most})"))
        if parts:
            failed = f"{motions.count(False)} of {len(motions)} motions"
            text = "; ".join(part for _, part in sorted(parts, key=lambda pair: -pair[0]))
            yield f"{policy} at {level} failed in {failed}: {text}"
