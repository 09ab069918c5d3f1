"""Closed-loop evaluation: policies, references and bounds on the same intended motions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...checks import at_least, flag
from ...errors import InputError, shown, unknown_name
from ..model.config import NO_SUIT
from ..policies import (
    POLICIES,
    AnyPolicy,
    Policy,
    PolicySpec,
    make_policy,
    needed_options,
    policy_spec,
)
from ..policies.outside import own_policy
from ..randomization import Randomization
from ..vector_env import ArmVectorEnv
from .bounds import BOUNDS, clairvoyant
from .rollout import Trace
from .scores import Score, score
from .settled import Wearers
from .statistics import Interval, mean_interval, ratio_interval

Make = Callable[[ArmVectorEnv], Policy]
Policies = Sequence[AnyPolicy | Make] | Mapping[str, AnyPolicy | Make]
FIRST_SEED = 10_000  # first seed of evaluations, far from those of training
REFERENCES = ("unsuited", "suited")
LEAST_COST = 0.01  # share of strength that a suit must cost for relief to have a meaning
_EXO = ("exo", "misalignment", "belief", "sensors", "sensing")
_SUIT = ("pressure", "preconditioned", "allow_uncertified")


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Scores on the same motions, and what they say beside each other.

    Attributes:
        scores: Score of each policy, reference and bound, by name, in the order of evaluation.
        settled: Whether the scores are of wearers who have learned the motions.
    """

    scores: Mapping[str, Score]
    settled: bool

    @property
    def suit_cost(self) -> Interval | None:
        """Effort that the suit costs: suited less unsuited; None without references."""
        if any(name not in self.scores for name in REFERENCES):
            return None
        unsuited, suited = (np.array(self.scores[name].effort) for name in REFERENCES)
        return mean_interval(suited - unsuited)

    def relief(self, policy: str) -> Interval | None:
        """Returns the share of the suit's cost that a policy gives back.

        That is (E suited - E) / (E suited - E unsuited) with the mean efforts E: 0 is no better
        than leaving the exoskeleton at home, 1 moves as without a suit, more carries the person,
        and less than 0 is worse than no exoskeleton.

        Args:
            policy: Name of a policy, reference or bound.

        Returns:
            Relief with its 95 % interval; None without references, or where the suit costs less
            than 1 % of strength.
        """
        self._check(policy)
        cost = self.suit_cost
        if cost is None or cost.value < LEAST_COST:
            return None
        unsuited, suited = (np.array(self.scores[name].effort) for name in REFERENCES)
        return ratio_interval(suited - np.array(self.scores[policy].effort), suited - unsuited)

    def relief_difference(self, policy: str, other: str) -> Interval | None:
        """Returns the relief of a policy less that of another, motion by motion; None likewise."""
        if self.relief(policy) is None or self.relief(other) is None:
            return None
        unsuited, suited, one, two = (
            np.array(self.scores[name].effort) for name in (*REFERENCES, policy, other)
        )
        return ratio_interval(two - one, suited - unsuited)

    def share_of_bound(self, policy: str, bound: str = "clairvoyant") -> Interval | None:
        """Returns the relief of a policy over that of a bound; None where there is none."""
        self._check(policy)
        if bound not in BOUNDS:
            self._check(bound)
        if bound not in self.scores or self.relief(bound) is None:
            return None
        suited = np.array(self.scores["suited"].effort)
        efforts = (np.array(self.scores[name].effort) for name in (policy, bound))
        return ratio_interval(*(suited - effort for effort in efforts))

    def _check(self, name: str) -> None:
        if name not in self.scores:
            raise unknown_name("policy of this evaluation", name, self.scores)

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        found = {}
        for name, one in self.scores.items():
            relief, share = self.relief(name), self.share_of_bound(name)
            found[name] = {
                **one.to_dict(),
                "relief": relief and relief.to_dict(),
                "share_of_bound": share and share.to_dict(),
            }
        cost = self.suit_cost
        return {"settled": self.settled, "suit_cost": cost and cost.to_dict(), "scores": found}


def evaluate(
    env_id: str,
    policies: Policies,
    *,
    episodes: int = 20,
    seed: int = FIRST_SEED,
    references: bool = True,
    settled: bool = True,
    on_policy: Callable[[str, list[Trace]], None] | None = None,
    **env_options: Any,
) -> Evaluation:
    """Runs every policy on the same `episodes` intended motions and scores it.

    The motions are rows of one vector environment, and a row is what a single environment would be
    with its seed. A named policy sees the sensor suites that it needs, one of your own those in
    `env_options`.

    Args:
        env_id: Id of a registered environment, such as "ActiveSuit/ElbowFlexion-v0".
        policies: Policies as `policy_spec` takes them, names of bounds ("clairvoyant-suit",
            "clairvoyant"), or functions from the vector environment to a policy of your own, such
            as its class; or a dict of these by names of your choice.
        episodes: Number of motions of each policy; motion i has the seed + i.
        seed: Seed of the first motion.
        references: Whether to run the references too: "unsuited", without suit and exoskeleton, and
            "suited", without exoskeleton.
        settled: Whether wearers have learned the motions; those who have not are scored beside.
            Otherwise only those are.
        on_policy: Function that is called after each of them with its name and its motions.
        **env_options: Options of the environment (`suit`, `gravity`, ...).

    Raises:
        InputError: An environment or policy is unknown, `episodes` is below 1, a policy of your own
            is not a function or makes something that cannot act, references are asked for where
            there is no suit, or a policy ends episodes, so that no wearer can settle.
    """
    named = named_policies(policies)
    at_least("episodes", episodes, 1)
    at_least("seed", seed, 0)
    flag("references", references)
    flag("settled", settled)
    if on_policy is not None and not callable(on_policy):
        raise InputError(f"on_policy is {shown(on_policy)}: give a function of name and motions")
    for name in ("taught", "effort_scale"):
        if name in env_options:
            raise InputError(f"{name} is what evaluate sets itself: leave it out")
    if env_options.get("coupling") == "none":
        for given in named.values():
            if not callable(given) and str(given) != "none":
                raise InputError(
                    f"policy {str(given)!r} needs motors, and coupling is 'none': use 'rigid' or "
                    "'cuffs', or the policy 'none'"
                )
    if references and env_options.get("suit") == NO_SUIT:
        raise InputError(
            "references are asked for, and suit is 'none': there is no suit whose cost could be "
            "given back, so name a suit or use references=False"
        )
    seeds, scores = range(seed, seed + episodes), {}
    scale = None
    for name in reversed(REFERENCES) if references else ():
        options = reference_options(name, env_options)
        wearers = Wearers(env_id, episodes, **options, effort_scale=scale)
        scale = wearers.arms.episodes.effort_scale  # the suited arm's, for all
        scores[name] = _score(
            name, make_policy("none", wearers.arms), wearers, seeds, settled, on_policy
        )
        wearers.close()
    scores = {name: scores[name] for name in REFERENCES if name in scores}
    for name, given in named.items():
        needed = needed_options(given) if isinstance(given, PolicySpec) else {}
        kept = {k: v for k, v in env_options.items() if not (needed and k == "belief")}
        options = {**kept, **needed, "effort_scale": scale}
        wearers = Wearers(env_id, episodes, **options)
        policy = _made(name, given, wearers, seeds)
        scores[name] = _score(name, policy, wearers, seeds, settled, on_policy)
        wearers.close()
    return Evaluation(scores, settled)


def reference_options(reference: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options of an environment of the same wearers without an exoskeleton.

    Args:
        reference: "unsuited" or "suited".
        options: Options of the environment with an exoskeleton.
    """
    kept = {name: value for name, value in options.items() if name not in _EXO}
    given = kept.get("randomize") or {}
    terms = asdict(given) if isinstance(given, Randomization) else dict(given)
    dropped = {"misalignment", "sensor_noise", "encoder_offset"}
    if reference == "unsuited":
        kept = {name: value for name, value in kept.items() if name not in _SUIT}
        dropped |= {"suit", "suits", "pressure"}
        kept["suit"] = NO_SUIT
    if terms:
        kept["randomize"] = {name: term for name, term in terms.items() if name not in dropped}
    return {**kept, "coupling": "none"}


def named_policies(policies: Policies) -> dict[str, PolicySpec | str | Make]:
    """Returns what to evaluate, by name: a policy as data, the name of a bound, or a function.

    Raises:
        InputError: A policy is unknown or no policy, two have one name, or there is none.
    """
    if isinstance(policies, str):
        raise InputError(f"policies is {policies!r}: give a list of names, such as [{policies!r}]")
    if not isinstance(policies, Mapping | Sequence):
        raise InputError(f"policies is {shown(policies)}: give a list of names, such as ['none']")
    named: dict[str, PolicySpec | str | Make] = {}
    if isinstance(policies, Mapping):
        named |= {name: _checked(name, given) for name, given in policies.items()}
    else:
        for given in policies:
            found = _checked(None, given)
            name = getattr(found, "__name__", repr(found)) if callable(found) else str(found)
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
                f"a policy of your own has the label {name!r}, the name of another one: choose "
                "another label"
            )
    for name in named:
        if name in REFERENCES:
            raise InputError(
                f"policy {name!r} is a reference, which has no exoskeleton: leave it out, as "
                "references=True runs it"
            )
    return named


def _checked(name: str | None, given: AnyPolicy | Make) -> PolicySpec | str | Make:
    if isinstance(given, str) and (given in BOUNDS or given in REFERENCES):
        return given
    if isinstance(given, str | Mapping | PolicySpec):
        return policy_spec(given, beside=BOUNDS)
    if not callable(given):
        what = "a policy" if name is None else f"policy {name!r}"
        raise InputError(
            f"{what} is {shown(given)}: give a name, or a function from the environment to a "
            "policy, such as the policy's class or lambda env: policy"
        )
    return given


def _made(
    name: str, given: PolicySpec | str | Make, wearers: Wearers, seeds: Sequence[int]
) -> Policy:
    if isinstance(given, str):
        if not wearers.arms.episodes.motors:
            raise unknown_name("policy without motors", given, ("none",))
        return clairvoyant(wearers, seeds, suit_only=given != "clairvoyant")
    if isinstance(given, PolicySpec):
        return make_policy(given, wearers.arms)
    return own_policy(name, given, wearers.arms.episodes.motors, wearers.arms)


def _score(
    name: str,
    policy: Policy,
    wearers: Wearers,
    seeds: Sequence[int],
    settled: bool,
    on_policy: Callable[[str, list[Trace]], None] | None,
) -> Score:
    naive = wearers.naive(policy, seeds)
    traces = wearers.settled(policy, seeds) if settled else naive
    if on_policy is not None:
        on_policy(name, traces)
    return score(name, traces, naive)
