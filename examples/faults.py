"""What policies do when a sensor or a motor fails.

The wearers learn the motions of `ElbowFlexion` while everything works, and then a part fails that
they do not expect. No policy detects the fault ([all faults](../../environments.md)).

Encoders and motors fail after 3 s, other parts at the beginning. Moved and loaded are the largest
difference of an angle and of the wearer's torque from the same motion without the fault, means with
95 % intervals. Relief is the share of the suit's cost that the policy gives back.

- A motor that stops throws its load on the wearer, whatever the policy.
- A stuck encoder stops the memory of `compensation` at the last angle. `observer` also compares
  with the torque that the pads measure.
- Errors of the pads go into `observer` and into what `adaptive` learns. `compensation` and
  `impedance` have no pads.
- Late and lost readings of single control periods change the relief of no policy.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import tyro
from activesuit.arrays import Array
from activesuit.envs.evaluation import FIRST_SEED, Interval, Trace, evaluate, rollout, score
from activesuit.envs.evaluation.relief import relief_interval
from activesuit.envs.evaluation.statistics import mean_interval
from activesuit.envs.evaluation.wearers import Wearers
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy, needed_options
from matplotlib.figure import Figure

SINCE = 3.0  # s
NONE = "none"
FAULTS = {  # fields of `activesuit.envs.simulation.faults.Faults`
    NONE: {},
    "pads: +5 N·m": {"torque_bias": 5.0},
    "pads: drift 0.5 N·m/s": {"torque_drift": 0.5},
    "10 % of readings late": {"late": 0.1},
    "10 % of readings lost": {"lost": 0.1},
    "elbow's encoder stuck": {"stuck": ("elbow_flexion",), "since": SINCE},
    "elbow's motor stops": {"stopped": ("elbow_flexion",), "since": SINCE},
    "both motors stop": {"stopped": ("shoulder_flexion", "elbow_flexion"), "since": SINCE},
}


def main(
    policies: tuple[str, ...] = ("compensation", "adaptive", "observer", "impedance"),
    task: str = "ElbowFlexion",
    motions: int = 20,
    quick: bool = False,
) -> None:
    """Compares motions with a fault with the same motions without.

    Args:
        policies: Policies of the exoskeleton.
        task: Task of the wearers.
        motions: Number of motions, at least 8.
        quick: Few motions and one policy, to see that the program runs.
    """
    if quick:
        policies, motions = policies[:1], 8
    env_id, seeds = f"ActiveSuit/{task}-v0", range(FIRST_SEED, FIRST_SEED + motions)
    found = evaluate(env_id, ["none"], motions=motions).scores
    references = found["unsuited"].effort, found["suited"].effort
    moved: dict[str, dict[str, Interval]] = {}
    print(f"{task}, {motions} motions\n")
    print(f"{'policy':14}{'fault':23}success  {'relief':24}{'moved [mrad]':18}loaded [N·m]")
    for policy in policies:
        moved[policy] = {}
        for fault, (usual, traces) in failed(policy, env_id, seeds).items():
            scored = score(policy, traces)
            success = f"{np.mean(scored.success):.0%}"
            relief = shown(relief_interval(*references, scored.effort), 2)
            moved[policy][fault] = mean_interval(1e3 * largest(usual, traces, "angle"))
            loaded = shown(mean_interval(largest(usual, traces, "human_torque")), 1)
            change = shown(moved[policy][fault], 0)
            print(f"{policy:14}{fault:23}{success:>7}  {relief:24}{change:18}{loaded}")
    drawn(moved).savefig("faults.png", dpi=150)


def failed(
    policy: str, env_id: str, seeds: Sequence[int]
) -> dict[str, tuple[list[Trace], list[Trace]]]:
    """Returns the usual motions, and those with each fault, of wearers who do not expect it."""
    options: dict[str, Any] = needed_options(policy)
    wearers, found = Wearers(env_id, len(seeds), **options), {}
    learned, usual = wearers.learn(partial(make_policy, policy, wearers.arms), seeds)
    for fault, fields in FAULTS.items():
        arms = make_arms(env_id, len(seeds), **options, faults=fields, **wearers.unlearning)
        traces = rollout(arms, make_policy(policy, arms), seeds, learned=learned)
        found[fault] = usual, traces
        arms.close()
    wearers.close()
    return found


def largest(usual: Sequence[Trace], traces: Sequence[Trace], series: str) -> Array:
    """Returns the largest difference of a series in each motion, until one of both ends."""
    found = []
    for one, other in zip(usual, traces, strict=True):
        end = min(len(one.time), len(other.time))
        found.append(np.abs(getattr(other, series)[:end] - getattr(one, series)[:end]).max())
    return np.array(found)


def shown(one: Interval | None, digits: int) -> str:
    """Returns an interval with so many decimals."""
    if one is None:
        return "-"
    return f"{one.value:.{digits}f} ({one.low:.{digits}f} to {one.high:.{digits}f})"


def drawn(moved: Mapping[str, Mapping[str, Interval]]) -> Figure:
    """Draws how far each fault moves the arm under each policy."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    ax = figure.subplots()
    faults = [fault for fault in FAULTS if fault != NONE]
    height = 0.8 / len(moved)
    for i, (policy, found) in enumerate(moved.items()):
        place = np.arange(len(faults)) + (i - (len(moved) - 1) / 2) * height
        values = np.array([found[fault].value for fault in faults])
        low = np.array([found[fault].low for fault in faults])
        high = np.array([found[fault].high for fault in faults])
        ends = [values - low, high - values]
        ax.barh(place, values, height, xerr=ends, error_kw={"lw": 0.8}, label=policy)
    ax.set_yticks(range(len(faults)), faults)
    ax.invert_yaxis()
    ax.set_xlabel("largest change of an angle [mrad]")
    ax.grid(axis="x", alpha=0.3)
    ax.legend(frameon=False)
    return figure


if __name__ == "__main__":
    tyro.cli(main)
