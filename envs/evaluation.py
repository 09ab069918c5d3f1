"""Closed-loop evaluation: scores several policies on the same intended motions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..assets import JOINTS, AnySuit, Suit
from ..checks import at_least
from ..errors import InputError, shown
from .making import make_arms
from .model import ASSISTED
from .model.cuffs import CUFFS
from .person import EffortMetrics, effort_metrics
from .policies import Policy, make_policy, needed_options
from .rollout import Trace, rollout
from .vector_env import ArmVectorEnv

Policies = Sequence[str] | Mapping[str, Callable[[ArmVectorEnv], Policy]]  # names, or your own
TAKEOVER = 0.5  # s
ASSISTED_COLUMNS = [JOINTS.index(joint) for joint in ASSISTED]


@dataclass(frozen=True, kw_only=True)
class Score:
    """Score of a policy over some episodes; the joints are shoulder and elbow flexion.

    Attributes:
        policy: Name of the policy.
        human_rms: Root mean square of the wearer's torque [N·m] by joint.
        human_peak: Largest |torque| of the wearer [N·m] by joint.
        effort: Mean over episodes of the wearer's other `EffortMetrics`, by joint.
        tracking_rmse: Tracking error [rad] by joint.
        cuff_peak: Greatest force [N] by limb segment; None without cuffs.
        assist_energy: Mean energy of the motors in an episode [J].
        mean_return: Mean sum of the rewards of an episode.
        failures: Number of episodes that ended early.
        reduction: 1 - human_rms / human_rms of "none", by joint; None if "none" was not run.
    """

    policy: str
    human_rms: dict[str, float]
    human_peak: dict[str, float]
    effort: dict[str, dict[str, float]]
    tracking_rmse: dict[str, float]
    cuff_peak: dict[str, float] | None
    assist_energy: float
    mean_return: float
    failures: int
    reduction: dict[str, float] | None = None

    def to_dict(self) -> dict[str, Any]:
        """Returns the score as plain values."""
        return asdict(self)


def score(policy: str, traces: Sequence[Trace]) -> Score:
    """Summarizes the episodes of one policy.

    The first half second does not count for torque and tracking: the wearer carries everything at
    first, whatever the policy is, until the motors have taken over.
    """
    # An episode that fails before is scored whole.
    late = [trace.time > (TAKEOVER if trace.time[-1] > TAKEOVER else 0.0) for trace in traces]
    human = _stack([trace.human_torque for trace in traces], late)
    error = _stack([trace.angle - trace.target_angle for trace in traces], late)
    return Score(
        policy=policy,
        human_rms=_by_joint(np.sqrt(np.mean(human**2, axis=0))),
        human_peak=_by_joint(np.abs(human).max(axis=0)),
        effort=_effort(traces, late),
        tracking_rmse=_by_joint(np.sqrt(np.mean(error**2, axis=0))),
        cuff_peak=_cuff_peak(traces),
        assist_energy=float(np.mean([trace.assist_energy for trace in traces])),
        mean_return=float(np.mean([trace.rewards.sum() for trace in traces])),
        failures=sum(trace.terminated for trace in traces),
    )


def evaluate(
    env_id: str,
    policies: Policies,
    *,
    episodes: int = 5,
    seed: int = 0,
    believed_suit: AnySuit | None = None,
    on_policy: Callable[[str, list[Trace]], None] | None = None,
    **env_options: Any,
) -> list[Score]:
    """Runs every policy on the same `episodes` intended motions and scores it.

    The motions are rows of one vector environment, and a row is what a single environment would be
    with its seed. A named policy sees the sensor suites that it needs, one of your own those in
    `env_options`.

    Args:
        env_id: Id of a registered environment, such as "ActiveSuit/ElbowFlexion-v0".
        policies: Names that `make_policy` knows; or for policies of your own, a dict of their
            names and of functions from the vector environment to a policy.
        episodes: Number of episodes of each policy; episode i has the seed + i.
        seed: Seed of the first episode.
        believed_suit: Suit that the named policy "feedforward" believes in; by default the
            simulated one.
        on_policy: Function that is called after each policy with its name and its episodes.
        **env_options: Options of the environment (`suit`, `gravity`, ...).

    Raises:
        InputError: An environment or policy is unknown, `episodes` is below 1, a policy of your own
            is not a function or makes something that cannot act, or such policies are given
            together with `believed_suit`.
    """
    _check_policies(policies, believed_suit)
    at_least("episodes", episodes, 1)
    at_least("seed", seed, 0)
    scores = []
    for name in dict.fromkeys(policies):
        if isinstance(policies, Mapping):
            arms = make_arms(env_id, episodes, **env_options)
            policy = _checked(name, policies[name](arms))
        else:
            arms = make_arms(env_id, episodes, **{**env_options, **needed_options(name)})
            policy = make_policy(name, arms, believed_suit=believed_suit)
        traces = rollout(arms, policy, range(seed, seed + episodes))
        arms.close()
        if on_policy is not None:
            on_policy(name, traces)
        scores.append(score(name, traces))
    return _with_reduction(scores)


def share_of_oracle(scores: Sequence[Score], suit: Suit) -> dict[str, float]:
    """Returns the reduction by feed-forward, divided by the oracle's, at each joint of `suit`.

    Only assisted joints count. The oracle knows the torque of this instant, but its motors lag;
    feed-forward allows for that lag by the measured rate, so that a good model can reach a little
    more than 1. Where the oracle
    reduces nothing, the share is NaN.
    """
    reductions = {score.policy: score.reduction or {} for score in scores}
    oracle, feedforward = reductions["oracle"], reductions["feedforward"]
    return {
        joint: feedforward[joint] / oracle[joint] if oracle[joint] else np.nan
        for joint in ASSISTED
        if joint in suit.joints
    }


def _check_policies(policies: Policies, believed_suit: AnySuit | None) -> None:
    if isinstance(policies, str):
        raise InputError(f"policies is {policies!r}: give a list of names, such as [{policies!r}]")
    if not isinstance(policies, Mapping | Sequence):
        raise InputError(f"policies is {shown(policies)}: give a list of names, such as ['none']")
    if not policies:
        raise InputError("no policy given: name at least one")
    if not isinstance(policies, Mapping):
        for policy in policies:
            if not isinstance(policy, str):
                raise InputError(
                    f"policies has {policy!r}: give names, or a dict of a name and a function from "
                    "the environment to a policy for each"
                )
        return
    if believed_suit is not None:
        raise InputError(
            f"believed_suit is {shown(believed_suit)} and policies are your own: believed_suit "
            "is for named policies only, so give yours what it believes when you make it"
        )
    for name, make in policies.items():
        if not callable(make):
            raise InputError(
                f"policy {name!r} is {make!r}: give a function from the environment to a policy, "
                "such as the policy's class or lambda env: policy"
            )


def _checked(name: str, policy: Any) -> Policy:
    for method in ("reset", "act"):
        if not callable(getattr(policy, method, None)):
            raise InputError(
                f"policy {name!r} makes {shown(policy)}, which has no {method}(): give a function "
                "that returns an object with reset() and act(observation)"
            )
    return policy


def _with_reduction(scores: list[Score]) -> list[Score]:
    base = next((s for s in scores if s.policy == "none"), None)
    if base is None:
        return scores
    return [
        replace(s, reduction={j: 1 - s.human_rms[j] / base.human_rms[j] for j in ASSISTED})
        for s in scores
    ]


def _effort(
    traces: Sequence[Trace], parts: Sequence[NDArray[np.bool_]]
) -> dict[str, dict[str, float]]:
    """Returns mean effort metrics by joint; NaN if no record has the three samples they need."""
    found = [
        effort_metrics(trace.human_torque[part], trace.rate[part], trace.time[1] - trace.time[0])
        for trace, part in zip(traces, parts, strict=True)
        if part.sum() > 2
    ]
    names = [field.name for field in fields(EffortMetrics) if field.name not in ("rms", "peak")]
    return {
        joint: {
            name: float(np.mean([getattr(one, name)[column] for one in found])) if found else np.nan
            for name in names
        }
        for joint, column in zip(ASSISTED, ASSISTED_COLUMNS, strict=True)
    }


def _cuff_peak(traces: Sequence[Trace]) -> dict[str, float] | None:
    forces = [trace.cuff_force for trace in traces if trace.cuff_force is not None]
    if not forces:
        return None
    peak = np.linalg.norm(np.concatenate(forces), axis=-1).max(axis=0)
    return dict(zip(CUFFS, map(float, peak), strict=True))


def _stack(series: Sequence[Array], parts: Sequence[NDArray[np.bool_]]) -> Array:
    rows = [values[part] for values, part in zip(series, parts, strict=True)]
    return np.concatenate(rows)[:, ASSISTED_COLUMNS]


def _by_joint(values: Array) -> dict[str, float]:
    return dict(zip(ASSISTED, map(float, values), strict=True))
