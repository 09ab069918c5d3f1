"""One policy on the motions of one setting: its traces and its score.

`evaluate`, the benchmark and validation all run policies by `run`, and so get the same score.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict
from functools import partial
from typing import Any, NamedTuple

from ...errors import InputError, unknown_name
from ..domain.randomization import OF_SUIT, Randomization
from ..model.config import NO_SUIT
from ..plant import Plant
from ..policies import Policy, PolicySpec, make_policy, needed_options
from ..policies.registry import OwnPolicy
from .best_known_plan import BOUNDS, clairvoyant
from .rollout import Trace
from .scores import REFERENCES, Score, score
from .wearers import Wearers

Make = Callable[[Plant], Policy]
Runnable = PolicySpec | str | Make
"""A policy as data, the name of a reference or bound, or a function that makes a policy."""

FIRST_SEED = 10_000  # first seed of evaluations, far from those of training
FIRST_PRACTICE = 10**9  # first seed of the practice of policies that learn over episodes
_EXO = ("exo", "misalignment", "belief", "sensors", "sensing", "faults")


class Run(NamedTuple):
    """Score and motions of a policy, and the effort of the suited arm that scales rewards."""

    score: Score
    traces: list[Trace]
    effort_scale: float


def run(
    name: str,
    given: Runnable,
    env_id: str,
    seeds: Sequence[int],
    *,
    adapted: bool = True,
    unadapted: bool = False,
    **options: Any,
) -> Run:
    """Runs a policy, reference or bound, with a name for its score, on the motions of some seeds.

    `adapted` says whether the wearers have learned the motions under the policy, `unadapted`
    whether wearers who have not learned are scored too. Options are those of the environment with
    an exoskeleton, and of `ArmVectorEnv`.
    """
    if options.get("reward") is not None:
        raise InputError("scores need the shipped reward: leave the option reward out")
    wearers = Wearers(env_id, len(seeds), **_options_of(given, options))
    try:
        make = _practiced(_maker(name, given, wearers, seeds), wearers)
        first = wearers.unadapted(make(), seeds) if unadapted or not adapted else []
        traces = wearers.adapted(make, seeds) if adapted else first
        return Run(score(name, traces, first), traces, wearers.arms.episodes.effort_scale)
    finally:
        wearers.close()


def _options_of(given: Runnable, options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options of the environment in which a policy, reference or bound acts."""
    if isinstance(given, str) and given in REFERENCES:
        return reference_options(given, options)
    needed = needed_options(given) if isinstance(given, PolicySpec) else {}
    kept = {name: value for name, value in options.items() if not (needed and name == "belief")}
    return {**kept, **needed}


def reference_options(reference: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options of an environment of the same wearers, "unsuited" or "suited"."""
    given = options.get("randomize") or {}
    terms = asdict(given) if isinstance(given, Randomization) else dict(given)
    without, dropped = _EXO, {"misalignment", "sensor_noise", "encoder_offset"}
    if reference == "unsuited":
        without += ("suit", "pressure", "preconditioned", "allow_uncertified")
        dropped |= {*OF_SUIT}
    kept = {name: value for name, value in options.items() if name not in without}
    if reference == "unsuited":
        kept["suit"] = NO_SUIT
    if terms:
        kept["randomize"] = {name: term for name, term in terms.items() if name not in dropped}
    return {**kept, "coupling": "none"}


def _maker(
    name: str, given: Runnable, wearers: Wearers, seeds: Sequence[int]
) -> Callable[[], Policy]:
    """Returns a function that makes a new policy for each rollout."""
    plant = Plant.of(wearers.arms.episodes)
    if isinstance(given, PolicySpec):
        return partial(make_policy, given, plant)
    if callable(given):
        return partial(OwnPolicy, name, plant.motors, given, plant)
    if given in REFERENCES:
        return partial(make_policy, "none", plant)
    if not plant.motors:
        raise unknown_name("policy without motors", given, ("none",))
    plan = clairvoyant(wearers, seeds, suit_only=given == BOUNDS[0])
    return lambda: plan


def _practiced(make: Callable[[], Policy], wearers: Wearers) -> Callable[[], Policy]:
    """Lets a policy practice on other motions; returns a function that copies the policy.

    Returns `make` for a policy without practice.
    """
    policy, rows = make(), wearers.arms.num_envs
    rollouts = getattr(policy, "practice", 0)
    for first in range(FIRST_PRACTICE, FIRST_PRACTICE + rollouts * rows, rows):
        wearers.unadapted(policy, range(first, first + rows))
    return partial(deepcopy, policy) if rollouts else make
