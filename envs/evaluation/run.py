"""One policy on the motions of one setting: its traces and its score.

`evaluate`, the benchmark and validation all run policies by `run`, and so get the same score.
"""

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any, NamedTuple

from ...errors import InputError, unknown_name
from ..domain.randomization import OF_SUIT, Randomization
from ..model.config import NO_SUIT
from ..plant import Plant
from ..policies import Policy, PolicySpec, make_policy, needed_options
from ..policies.registry import OwnPolicy, is_own
from .apart import Apart
from .best_known_plan import BOUNDS, clairvoyant
from .rollout import Trace
from .scores import REFERENCES, Score, score
from .wearers import Wearers

Make = Callable[[Plant], Policy]
Runnable = PolicySpec | str | Make
"""A policy as data, the name of a reference or bound, or a function that makes a policy."""

FIRST_SEED = 10_000  # first seed of evaluations, far from those of training
FIRST_DRAWN, DRAWN = 10**8, 8 * 10**8  # least drawn first seed of evaluations, and their number
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
    rivals: Sequence[Trace] = (),
    apart: bool = True,
    **options: Any,
) -> Run:
    """Runs a policy, reference or bound, with a name for its score, on the motions of some seeds.

    `adapted` says whether the wearers have learned the motions under the policy, `unadapted`
    whether wearers who have not learned are scored too. `rivals` has the motion of each seed under
    a policy, from whose torques the best known plan begins, too. `apart` says whether a user's
    policy has processes of its own. Options are those of the environment with an exoskeleton, and
    of `ArmVectorEnv`.
    """
    if options.get("reward") is not None:
        raise InputError("scores need the shipped reward: leave the option reward out")
    wearers = Wearers(env_id, len(seeds), **_options_of(given, options))
    try:
        make, close = _maker(name, given, wearers, seeds, rivals, apart)
        try:
            first = wearers.unadapted(make(), seeds) if unadapted or not adapted else []
            traces = wearers.adapted(make, seeds) if adapted else first
        finally:
            close()
        return Run(score(name, traces, first), traces, wearers.arms.episodes.effort_scale)
    finally:
        wearers.close()


def drawn_seed() -> int:
    """Returns a random first seed of motions, of which code that was written before knows none."""
    return FIRST_DRAWN + secrets.randbelow(DRAWN)


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
    name: str,
    given: Runnable,
    wearers: Wearers,
    seeds: Sequence[int],
    rivals: Sequence[Trace],
    apart: bool,
) -> tuple[Callable[[], Policy], Callable[[], None]]:
    """Returns a function that makes a new policy for each rollout, and one that ends them all."""
    plant = Plant.of(wearers.arms.episodes)
    made: Make | None = None
    if isinstance(given, PolicySpec):
        made = partial(make_policy, given)
    elif callable(given):
        made = partial(OwnPolicy, name, plant.motors, given)
    if made is not None:
        if apart and is_own(given):
            return _apart(Apart(name, made, plant), wearers)
        return partial(made, plant), _nothing
    if given in REFERENCES:
        return partial(make_policy, "none", plant), _nothing
    if not plant.motors:
        raise unknown_name("policy without motors", given, ("none",))
    plan = clairvoyant(wearers, seeds, suit_only=given == BOUNDS[0], given=rivals)
    return lambda: plan, _nothing


def _apart(policy: Apart, wearers: Wearers) -> tuple[Callable[[], Policy], Callable[[], None]]:
    """Lets a user's policy practice on other motions; returns what `_maker` does."""
    rows = wearers.arms.num_envs
    try:
        for first in range(FIRST_PRACTICE, FIRST_PRACTICE + policy.practice * rows, rows):
            wearers.unadapted(policy, range(first, first + rows))
    except BaseException:
        policy.close()
        raise
    return lambda: policy, policy.close


def _nothing() -> None:
    """Ends nothing, since no process has begun."""
