"""Closed-loop evaluation: policies, references and bounds on the same intended motions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...arrays import Array
from ...checks import at_least, check_seed, flag
from ...errors import InputError, refuse_old_names, shown, unknown_name
from ...plots import Plot
from ...tables import Rows
from ..extras import SCORES, Scored
from ..making import make_arms
from ..model.config import NO_SUIT
from ..policies import POLICIES, AnyPolicy, PolicySpec, make_policy, needed_options, policy_spec
from ..policies.registry import is_own
from . import extra_scores, figures, report
from . import sentences as say
from .best_known_plan import BOUNDS
from .relief import relief_interval
from .rollout import Trace
from .run import FIRST_SEED, Make, Run, Runnable, drawn_seed, run
from .scores import REFERENCES, UNADAPTED, Score, root_mean_square, score
from .statistics import Interval, mean_interval, ratio_interval

OnPolicy = Callable[[str, list[Trace]], None]
Policies = Sequence[AnyPolicy | Make] | Mapping[str, AnyPolicy | Make]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Scores of policies, references and bounds on the same motions, and comparisons of these.

    Attributes:
        scores: Scores by the name of the policy, reference or bound, in the order of evaluation.
        adapted: Whether the scores are of wearers who have learned the motions.
        traces: Motions by the same names.
        first_seed: Seed of the first motion.
        drawn: Whether that seed was drawn after the policies were given.
        apart: Whether policies of the user had processes of their own, or there were none.
        extras: Scores of extras, by the name of the score and then by the same names.
    """

    scores: Mapping[str, Score]
    adapted: bool
    traces: Mapping[str, list[Trace]] = field(repr=False)
    first_seed: int
    drawn: bool = False
    apart: bool = True
    extras: Mapping[str, Mapping[str, Scored]] = field(default_factory=dict, repr=False)

    @property
    def suit_cost(self) -> Interval | None:
        """Effort with the suit less that without suit; None without references."""
        if any(name not in self.scores for name in REFERENCES):
            return None
        unsuited, suited = map(self._effort, REFERENCES)
        return mean_interval(suited - unsuited, motion=self._motion)

    def relief(self, policy: str) -> Interval | None:
        """Returns the relief of a policy, reference or bound; see `evaluation.relief`.

        None without references, or where the suit costs less than 1 % of strength.
        """
        return self._relief(policy, "effort")

    def assisted_relief(self, policy: str) -> Interval | None:
        """Returns the relief of the joints that can have a motor; None as for `relief`."""
        return self._relief(policy, "assisted_effort")

    def net_relief(self, policy: str) -> Interval | None:
        """Returns the relief of net torque, without co-contraction; None as for `relief`."""
        return self._relief(policy, "net_effort")

    def _relief(self, policy: str, effort: str) -> Interval | None:
        self._check(policy)
        found = [self.scores.get(name) for name in (*REFERENCES, policy)]
        efforts = [getattr(one, effort) for one in found if one is not None]
        return relief_interval(*efforts, motion=self._motion) if all(found) else None

    def relief_difference(self, policy: str, other: str) -> Interval | None:
        """Returns the paired difference of relief, policy less other; None as for `relief`."""
        if self.relief(policy) is None or self.relief(other) is None:
            return None
        unsuited, suited, one, two = map(self._effort, (*REFERENCES, policy, other))
        return ratio_interval(two - one, suited - unsuited, motion=self._motion)

    def share_of_bound(self, policy: str, bound: str = BOUNDS[1]) -> Interval | None:
        """Returns the relief of a policy over that of a bound; None where a relief is None."""
        self._check(policy)
        if bound not in BOUNDS:
            self._check(bound)
        if bound not in self.scores or self.relief(bound) is None:
            return None
        suited, one, other = map(self._effort, (REFERENCES[1], policy, bound))
        return ratio_interval(suited - one, suited - other, motion=self._motion)

    @property
    def _motion(self) -> tuple[int, ...]:
        """Numbers of the motions, which are the same for all policies."""
        return next(iter(self.scores.values())).motion

    def _effort(self, name: str) -> Array:
        return np.array(self.scores[name].effort)

    def _check(self, name: str) -> None:
        if name not in self.scores:
            raise unknown_name("policy of this evaluation", name, self.scores)

    @cached_property
    def _costs(self) -> dict[str, extra_scores.Costs]:
        """Costs by score, policy and name of the cost."""
        return {
            name: extra_scores.costs_of(name, found, self._motion)
            for name, found in self.extras.items()
        }

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        cost, found = self.suit_cost, {}
        for name, one in self.scores.items():
            found[name] = one.to_dict()
            for what in ("relief", "net_relief", "assisted_relief", "share_of_bound"):
                interval: Interval | None = getattr(self, what)(name)
                found[name][what] = interval and interval.to_dict()
            for extra, scored in self.extras.items():
                costs = self._costs[extra][name]
                found[name][extra] = extra_scores.plain(extra, scored[name], costs)
        return {
            "adapted": self.adapted,
            "seed": self.first_seed,
            "seed_drawn": self.drawn,
            "apart": self.apart,
            "suit_cost": cost and cost.to_dict(),
            "scores": found,
        }

    def tables(self, place: str = "") -> dict[str, Rows]:
        """Returns tables by title: scores with relief, costs of a motion, medians over motions."""
        scores, related = [*self.scores.values()], None if self.suit_cost is None else self
        tables = {
            f"Scores: {place}" if place else "Scores": report.score_table(scores, related),
            "Cost per motion": report.effort_table(scores),
            "Units of effort, medians": report.units_table(scores),
        }
        for name, scored in self.extras.items():
            tables[name] = extra_scores.cost_table(name, scored, self._costs[name])
        return tables

    def sentences(self) -> list[str]:
        """Returns sentences about cost and relief, failed motions, and limits of the numbers."""
        scores = [*self.scores.values()]
        found = [*say.story(self), *say.why_remarks(scores), *say.cuff_remarks(scores)]
        found += [*say.guard_remarks(scores), *say.motion_remarks(self)]
        for name, scored in self.extras.items():
            found += extra_scores.cost_remarks(name, scored, self._costs[name])
        return found

    def plots(self) -> dict[str, Plot]:
        """Returns figures by name: the reliefs, and the first motion of each policy."""
        relief = figures.relief_plot(self)
        return ({} if relief is None else {"relief": relief}) | figures.motion_plots(self.first())

    def pictures(self) -> dict[str, Any]:
        """Returns drawings of the scores of extras, by name."""
        draws = {name: SCORES.find(name).figure for name in self.extras}
        return {
            f"score-{name}": draw(self.first(extra_scores.drawn_policies(name, self.extras[name])))
            for name, draw in draws.items()
            if draw is not None
        }

    def columns(self) -> dict[str, Any]:
        """Returns columns of CSV files by name: every score, and the first motions over time."""
        return {
            "motions.csv": report.score_columns([*self.scores.values()], self.first_seed),
            "traces.csv": report.trace_columns(self.first()),
        }

    def first(self, policies: Sequence[str] | None = None) -> dict[str, Trace]:
        """Returns the first motion of some policies, by default of all policies."""
        return {name: self.traces[name][0] for name in policies or self.traces}


def evaluate(
    env_id: str,
    policies: Policies,
    *,
    motions: int = 20,
    seed: int | None = None,
    references: bool = True,
    adapted: bool = True,
    scores: Sequence[str] = (),
    apart: bool = True,
    on_policy: OnPolicy | None = None,
    **env_options: Any,
) -> Evaluation:
    """Runs every policy on the same intended motions and scores the policy.

    The motions are rows of one vector environment, and a row is equal to a single environment with
    the same seed. A named policy observes the sensor suites that it needs, a policy of your own
    observes those in `env_options`.

    Args:
        env_id: Id of a registered environment, such as "ActiveSuit/ElbowFlexion-v0".
        policies: Policies as in `policy_spec`, names of bounds ("clairvoyant-suit",
            "best-known-plan"), or functions from a `Plant` to a policy of your own, such as its
            class; or a dict of these by names of your choice.
        motions: Number of motions of each policy; motion i has the seed `seed` + i.
        seed: Seed of the first motion. By default 10,000; with a policy of your own a seed that is
            drawn now, so that no policy can know the motions beforehand. `first_seed` of the result
            repeats the evaluation.
        references: Whether to run the references too: "unsuited", without suit and exoskeleton, and
            "suited", without exoskeleton.
        adapted: Whether wearers have learned the motions. The scores then have the effort of
            wearers who have not learned as `unadapted_effort`.
        scores: Names of further scores of the motions, from extras, such as "muscles".
        apart: Whether each motion of each rollout of your own policies has a process of its own,
            which can leave no message to later ones. Without, as for a policy that talks to a
            device, the policies run here, do not practice, and the result says so.
        on_policy: Function that is called with name and motions of each policy after its motions,
            and again after each further score.
        **env_options: Options of the environment (`suit`, `gravity`, ...).
    """
    named = named_policies(policies)
    at_least("motions", motions, 1)
    drawn = seed is None and any(map(is_own, named.values()))
    first = check_seed(seed) if seed is not None else drawn_seed() if drawn else FIRST_SEED
    flag("references", references)
    flag("adapted", adapted)
    flag("apart", apart)
    if on_policy is not None and not callable(on_policy):
        raise InputError(f"on_policy is {shown(on_policy)}: give a function of name and motions")
    refuse_old_names(env_options, {"settled": "adapted"})
    for name in ("learned_torque", "effort_scale"):
        if name in env_options:
            raise InputError(f"evaluate sets {name} itself: leave {name} out")
    if env_options.get("coupling") == "none":
        for given in named.values():
            if not callable(given) and str(given) != "none":
                raise InputError(
                    f"policy {str(given)!r} needs motors, and coupling is 'none': use 'rigid' or "
                    "'cuffs', or the policy 'none'"
                )
    if references and env_options.get("suit") == NO_SUIT:
        raise InputError(
            "references need a suit, and suit is 'none': name a suit, or use references=False"
        )
    scale, found = None, {}
    before = reversed(REFERENCES) if references else ()
    for name in (*before, *sorted(named, key=lambda name: name == BOUNDS[1])):  # that bound last
        rivals = least_effort([found[other].traces for other in named if other in found])
        one = run(
            *(name, named.get(name, name), env_id, range(first, first + motions)),
            rivals=rivals if name == BOUNDS[1] else (),
            apart=apart,
            **{**env_options, "adapted": adapted, "unadapted": True, "effort_scale": scale},
        )
        if name in REFERENCES:
            scale = one.effort_scale  # of the suited arm, for all policies
        if name == BOUNDS[1]:
            one = _best_known(one, rivals)
        found[name] = one
        if on_policy is not None:
            on_policy(name, one.traces)
    order = [name for name in (*REFERENCES, *named) if name in found]
    traces = {name: found[name].traces for name in order}
    extras = {name: _scored(name, traces, on_policy) for name in scores}
    scored = {name: found[name].score for name in order}
    alone = apart or not any(map(is_own, named.values()))
    return Evaluation(scored, adapted, traces, first, drawn, alone, extras)


def _scored(
    score: str, traces: Mapping[str, list[Trace]], on_policy: OnPolicy | None
) -> dict[str, Scored]:
    """Returns the score of an extra for each policy."""
    found = {}
    for name, motions in traces.items():
        found[name] = SCORES.find(score).scored(motions, threads=0, on_motion=lambda: None)
        if on_policy is not None:
            on_policy(name, motions)
    return found


def check_policy(
    env_id: str, policy: AnyPolicy, scores: Sequence[str] = (), **env_options: Any
) -> None:
    """Checks a policy or bound, and scores of extras, on one arm, without any simulation."""
    needed = {} if policy in BOUNDS else needed_options(policy)
    arms = make_arms(env_id, 1, **{**env_options, **needed})
    try:
        for name in scores:
            SCORES.find(name).check(arms.episodes.simulation)
        if policy not in BOUNDS:
            make_policy(policy, arms)
    finally:
        arms.close()


def least_effort(motions: Sequence[Sequence[Trace]]) -> list[Trace]:
    """Returns the motion of each seed with the least effort, of those that succeed if any does."""
    return [
        min(same, key=lambda one: (not one.success, root_mean_square(one.effort)))
        for same in zip(*motions, strict=True)
    ]


def _best_known(plan: Run, rivals: Sequence[Trace]) -> Run:
    """Returns the motions of the plan, or of a policy that succeeds with less effort.

    The torque of a policy over time is a known plan as well.
    """
    best = list(plan.traces)
    for i, one in enumerate(rivals):
        if one.success and root_mean_square(one.effort) < root_mean_square(best[i].effort):
            best[i] = one
    unadapted = {name: getattr(plan.score, name) for name in UNADAPTED}
    return plan._replace(score=replace(score(BOUNDS[1], best), **unadapted), traces=best)


def named_policies(policies: Policies) -> dict[str, Runnable]:
    """Returns policies as data, names of bounds, and functions, by names."""
    if isinstance(policies, str):
        raise InputError(f"policies is {policies!r}: give a list of names, such as [{policies!r}]")
    if not isinstance(policies, Mapping | Sequence):
        raise InputError(f"policies is {shown(policies)}: give a list of names, such as ['none']")
    named: dict[str, Runnable] = {}
    given_by = policies.items() if isinstance(policies, Mapping) else ((None, p) for p in policies)
    for label, given in given_by:
        found = _checked(label, given)
        usual = getattr(found, "__name__", repr(found)) if callable(found) else str(found)
        name = usual if label is None else label
        if name in named:
            raise InputError(
                f"two policies are named {name!r}: name each one once, or give a dict of your "
                "own names"
            )
        named[name] = found
    if not named:
        raise InputError("no policy given: name at least one")
    for name, given in named.items():
        if name in (*POLICIES, *BOUNDS) and name not in (given, getattr(given, "name", None)):
            raise InputError(
                f"a policy of your own has the label {name!r}, which is the name of a shipped "
                "policy or bound: choose another label"
            )
        if name in REFERENCES:
            raise InputError(
                f"policy {name!r} is a reference without exoskeleton: leave it out, and use "
                "references=True"
            )
    return named


def _checked(name: str | None, given: AnyPolicy | Make) -> Runnable:
    if isinstance(given, str) and given in (*BOUNDS, *REFERENCES):
        return given
    if isinstance(given, str | Mapping | PolicySpec):
        return policy_spec(given, beside=BOUNDS)
    if not callable(given):
        what = "a policy" if name is None else f"policy {name!r}"
        raise InputError(
            f"{what} is {shown(given)}: give a name, or a function from a plant to a policy, such "
            "as the policy's class or lambda plant: policy"
        )
    return given
