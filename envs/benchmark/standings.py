"""Comparison of results: success, relief, and which policy is better, by level and by task.

Motion i has the same wearer, sensors and, in tasks of one kind, the same movement in every setting.
So intervals over *motions* resample motions for all settings together. Intervals over *tasks*
resample tasks.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...arrays import Array
from ...errors import unknown_name
from ..domain.levels import LEVELS
from ..evaluation import BOUNDS, REFERENCES
from ..evaluation.relief import relief
from ..evaluation.statistics import (
    FEWEST_RUNS,
    Interval,
    difference_interval,
    interquartile_mean,
    interquartile_mean_interval,
)
from .results import SERIES, Result
from .suites import BASELINE, Setting, where

BOUND = BOUNDS[1]
FIXED = (*REFERENCES, BOUND)
MARGIN = 0.02  # difference of relief below which two policies are alike
Effort = Literal["effort", "assisted_effort"]


@dataclass(frozen=True)
class Standing:
    """The results of one policy over several tasks.

    Relief, and all that follows from relief, is None where no suit costs enough for relief to have
    a meaning; so are values of the baseline relative to itself. Reliefs are alike within `MARGIN`.
    """

    policy: str
    success: float  # share of motions
    relief: Interval | None  # interquartile mean over motions and settings, interval over motions
    assisted: Interval | None  # the same for the effort of the joints that can have a motor
    over_tasks: Interval | None  # as `relief`, with the interval over tasks, if 5 or more have one
    mean: float | None  # mean relief, in which harm counts in full
    worst: tuple[float, Setting] | None  # least mean relief in a setting, and the setting
    gain: Interval | None  # interquartile mean of relief less the baseline's in the same motions
    compared: tuple[float, float, float] | None  # shares with more, like, less relief
    failed: int  # number of trials in which the policy could not act


class Standings:
    """Results of one contract, such as `read_results` returns, by setting and policy.

    Attributes:
        results: The results.
        policies: Names of policies, references and bound, in the order of the results.
        levels: Names of the levels.
        settings: All settings.
        protocol: Protocol of the first result.
    """

    def __init__(self, results: Sequence[Result]) -> None:
        self.results, self._found = [*results], dict[Setting, dict[str, Result]]()
        for one in results:
            setting = Setting(one.task, one.level, one.believed)
            self._found.setdefault(setting, {})[one.policy] = one
        for setting in self._found:
            self._improve_bound(setting)
        self.settings = list(self._found)
        self.protocol = results[0].protocol
        self.policies = list(dict.fromkeys(one.policy for one in results))
        self.levels = [level for level in LEVELS if any(one.level == level for one in results)]

    def of(self, setting: Setting, policy: str) -> Result | None:
        """Returns the result of a policy in a setting; None if there is none.

        A policy without belief has one result for all believed suits at "shift".
        """
        for place in (setting, where(setting)):
            if policy in self._found.get(place, {}):
                return self._found[place][policy]
        return None

    def relief(
        self, setting: Setting, policy: str, motions: int | None = None, of: Effort = "effort"
    ) -> Array | None:
        """Returns the relief of effort by motion, shape (motions,); None where it has no meaning.

        Only the first `motions` count; by default all motions of the policy.
        """
        found = [self.of(setting, name) for name in (*REFERENCES, policy)]
        unsuited, suited, mine = (one and getattr(one, of) for one in found)
        if unsuited is None or suited is None or mine is None:
            return None
        common = min(len(unsuited), len(suited))  # results with more and with fewer motions merge
        return relief(unsuited[:common], suited[:common], mine[:common][:motions])

    def standing(self, policy: str, settings: Iterable[Setting]) -> Standing:
        """Returns the standing of a policy over some settings."""
        settings = list(settings)
        mine = [one for s in settings if (one := self.of(s, policy)) is not None]
        reliefs = self._reliefs(settings, policy)
        assisted = self._reliefs(settings, policy, "assisted_effort")
        means = [(float(np.mean(one)), setting) for setting, one in reliefs.items()]
        pairs = [self._paired(s, policy, BASELINE) for s in reliefs if policy != BASELINE]
        gains = [np.subtract(*pair) for pair in pairs if pair is not None]
        compared = None
        if gains:
            gain = np.concatenate(gains)
            better, worse = float(np.mean(gain > MARGIN)), float(np.mean(gain < -MARGIN))
            compared = better, float(np.mean(np.abs(gain) <= MARGIN)), worse
        return Standing(
            policy=policy,
            success=float(np.mean([ok for one in mine for ok in one.success])) if mine else np.nan,
            relief=_over_motions(reliefs.values()),
            assisted=_over_motions(assisted.values()),
            over_tasks=_over_tasks(reliefs),
            mean=float(np.mean(np.concatenate(list(reliefs.values())))) if reliefs else None,
            worst=min(means, key=lambda pair: pair[0], default=None),
            gain=_over_motions(gains),
            compared=compared,
            failed=sum(one.failed is not None for one in mine),
        )

    def _reliefs(
        self, settings: Iterable[Setting], policy: str, of: Effort = "effort"
    ) -> dict[Setting, Array]:
        """Returns relief by motion in those settings where it has a meaning."""
        found = {setting: self.relief(setting, policy, of=of) for setting in settings}
        return {setting: one for setting, one in found.items() if one is not None}

    def settings_at(self, level: str) -> list[Setting]:
        """Returns the settings of a level."""
        return [setting for setting in self.settings if setting.level == level]

    def policies_at(self, level: str) -> list[str]:
        """Returns the policies that have a result at a level."""
        settings = self.settings_at(level)
        return [name for name in self.policies if any(self.of(s, name) for s in settings)]

    def by_level(self, level: str) -> list[Standing]:
        """Returns the standings of the policies that ran at a level, the best relief first.

        References and bound come before all others.
        """
        settings = self.settings_at(level)
        found = [self.standing(policy, settings) for policy in self.policies_at(level)]

        def rank(one: Standing) -> tuple[float, str]:
            if one.policy in FIXED:
                return -np.inf, ""
            return -one.relief.value if one.relief else np.inf, one.policy

        return sorted(found, key=rank)

    def difference(self, setting: Setting, one: str, other: str) -> Interval | None:
        """Returns the paired difference of relief, one less other; None where there is none."""
        for name in (one, other):
            if name not in self.policies:
                raise unknown_name("policy in these results", name, self.policies)
        pair = self._paired(setting, one, other)
        if pair is None or not np.isfinite(pair).all():
            return None
        results = [self.of(setting, name) for name in (one, other)]
        motion = next((each.motion for each in results if each is not None and each.motion), ())
        return difference_interval(*pair, motion=motion[: pair[0].size])

    def profile(self, policy: str, level: str, thresholds: Array) -> Array:
        """Returns the share of motions with at least each relief (mean over tasks), shape (k,).

        This is the performance profile of Agarwal et al. (2021).
        """
        reliefs = self._reliefs(self.settings_at(level), policy).values()
        shares = [np.mean(one[:, None] >= thresholds, axis=0) for one in reliefs]
        return np.mean(shares, axis=0) if shares else np.full(thresholds.shape, np.nan)

    def _improve_bound(self, setting: Setting) -> None:
        """Replaces the plan by a policy that succeeds with less effort, motion by motion.

        At "shift" policies with any believed suit count, since the simulated suit is the same.
        """
        bound = self._found[setting].get(BOUND)
        if bound is None:
            return
        best = [bound] * len(bound.effort)
        alike = [of for place, of in self._found.items() if where(place) == setting]
        for rival in (one for of in alike for name, one in of.items() if name not in FIXED):
            for i in range(min(len(best), len(rival.effort))):
                if rival.success[i] and rival.effort[i] < best[i].effort[i]:
                    best[i] = rival
        series = {
            name: tuple(getattr(one, name)[i] for i, one in enumerate(best)) for name in SERIES
        }
        self._found[setting][BOUND] = replace(bound, **series)

    def _paired(self, setting: Setting, one: str, other: str) -> tuple[Array, Array] | None:
        """Returns relief of two policies in the motions of both, with the same cost of the suit."""
        results = [self.of(setting, name) for name in (one, other)]
        motions = min((len(each.effort) for each in results if each is not None), default=0)
        mine, theirs = (self.relief(setting, name, motions) for name in (one, other))
        return None if mine is None or theirs is None else (mine, theirs)


def _over_motions(values: Iterable[Array]) -> Interval | None:
    """Returns the interquartile mean of values of settings, with the interval over motions.

    Only the motions that all settings have are counted.
    """
    values = [*values]
    if not values:
        return None
    motions = min(one.size for one in values)
    return _clustered(np.array([one[:motions] for one in values]).T)


def _over_tasks(reliefs: dict[Setting, Array]) -> Interval | None:
    """Returns the interquartile mean of relief, with the interval over tasks."""
    tasks: dict[str, list[Array]] = {}
    for setting, values in reliefs.items():
        tasks.setdefault(setting.task, []).append(values)
    found = [np.concatenate(values) for values in tasks.values()]
    if len(found) < FEWEST_RUNS or len({one.size for one in found}) > 1:
        return None
    return _clustered(np.array(found))


def _clustered(values: Array) -> Interval:
    """Returns the interquartile mean of values, shape (clusters, size), with its interval.

    The interval is infinite if a value is not finite or there are too few clusters.
    """
    if len(values) < FEWEST_RUNS or not np.isfinite(values).all():
        return Interval(float(interquartile_mean(values.ravel())), -np.inf, np.inf)
    return interquartile_mean_interval(values)
