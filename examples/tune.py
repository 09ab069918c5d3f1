"""What does it buy to tune the options of a policy?

CMA-ES (package `cma`) tunes the options of each policy with the same number of evaluations: the
mean effort of adapted wearers in arm tracking and at the ratchet, at level randomized in the suit
emu-like. Usual and tuned options are then compared in other motions, of these two tasks and of two
others.

Options that are given with a policy, as in `compensation:lead=0.02`, stay. Relief is the share of
the suit's cost that a policy gives back, here its mean over the tasks. No options of compensation
were better than the usual ones, which follow from the motors. The disturbance observer gains much
in the tasks of its tuning, and hardly anything in the others.

The tuned policy is written to `NAME-tuned.json`, which is a policy wherever one is named.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cma
import numpy as np
import tyro
from activesuit.envs.benchmark.suites import Setting
from activesuit.envs.evaluation import evaluate
from activesuit.envs.evaluation.run import run
from activesuit.envs.evaluation.wearers import ArmLost
from activesuit.envs.policies import PolicySpec, policy_spec
from activesuit.errors import InputError, unknown_name
from numpy.typing import NDArray

LEAD, FRICTION = (0.005, 0.06), (0.3, 1.0)  # s, share of the motors' friction
RANGES: dict[str, dict[str, tuple[float, float]]] = {  # what may change, from and to
    "feedforward": {"lead": LEAD},
    "complement": {"lead": LEAD, "friction": FRICTION},
    "compensation": {"lead": LEAD, "friction": FRICTION},
    "adaptive": {"forgetting": (3.0, 100.0), "lead": LEAD, "friction": FRICTION},
    "iterative": {"gain": (0.1, 1.0), "lead": LEAD, "friction": FRICTION},
    "predictive": {"horizon": (0.05, 0.3), "spread": (0.003, 0.1)},
    "impedance": {"bandwidth": (0.1, 3.0), "damping_ratio": (0.3, 3.0)},
    "observer": {"bandwidth": (1.0, 20.0), "lead": LEAD},
    "disturbance-observer": {"bandwidth": (0.3, 5.0)},
}
SUIT, LEVEL = "emu-like", "randomized"
TUNED, OTHERS = ("ArmTracking", "Ratchet"), ("RangeOfMotion", "Handrail")
SEEDS = range(6)  # of the motions of an evaluation
STEP = 0.25  # first step, of a box from 0 to 1
WORST = 10.0  # times strength, where a policy loses the arm


def scene(task: str) -> tuple[str, dict[str, Any]]:
    """Returns the id of a task and the options of its environment, as the benchmark has them."""
    return f"ActiveSuit/{task}-v0", Setting(task, LEVEL, SUIT).options


def cost(policy: PolicySpec) -> float:
    """Returns the mean effort of adapted wearers over strength, in the motions of the tuning."""
    found = []
    for env, options in map(scene, TUNED):
        try:
            score = run(policy.name, policy, env, SEEDS, **options).score
            found.append(WORST if score.failures else float(np.mean(score.effort)))
        except ArmLost:
            found.append(WORST)
    return float(np.mean(found))


def tuned(policy: PolicySpec, evaluations: int, seed: int) -> tuple[PolicySpec, float, float]:
    """Returns a policy with the options of the least cost, and its costs before and after.

    Args:
        policy: Policy; options that are given stay as they are.
        evaluations: Number of evaluations.
        seed: Seed of CMA-ES.
    """
    if policy.name not in RANGES:
        raise unknown_name("policy with options to tune", policy.name, RANGES)
    free = {name: ends for name, ends in RANGES[policy.name].items() if name not in policy.options}
    if not free:
        raise InputError(f"all options of policy {policy.name!r} are given: leave one out")

    def at(point: NDArray[Any]) -> PolicySpec:
        pairs = zip(free.items(), point, strict=False)
        values = {name: float(f"{a * (b / a) ** share:.4g}") for (name, (a, b)), share in pairs}
        return PolicySpec(policy.name, {**policy.options, **values})

    # CMA-ES needs two parameters: one that means nothing is beside a single one.
    options = {"bounds": [0, 1], "maxfevals": evaluations, "seed": seed + 1, "verbose": -9}
    search = cma.CMAEvolutionStrategy([0.5] * max(2, len(free)), STEP, options)
    search.optimize(lambda point: cost(at(point)))
    before, after = cost(policy), float(search.result.fbest)
    best = at(search.result.xbest)
    return (best, before, after) if after < before else (policy, before, before)


def reliefs(task: str, policies: dict[str, PolicySpec], motions: int) -> dict[str, float]:
    """Returns the relief of each policy in a task, in motions that tuning has not seen."""
    env, options = scene(task)
    found = evaluate(env, policies, motions=motions, **options)
    intervals = {name: found.relief(name) for name in policies}
    return {name: np.nan if one is None else one.value for name, one in intervals.items()}


def main(
    policies: tuple[str, ...] = ("compensation", "disturbance-observer"),
    evaluations: int = 16,
    seed: int = 0,
    motions: int = 10,
    quick: bool = False,
) -> None:
    """Tune the options of policies within a budget, the same for all.

    Args:
        policies: Policies to tune.
        evaluations: Number of evaluations of each.
        seed: Seed of CMA-ES.
        motions: Number of motions of the comparison in each task, at least 8.
        quick: Tune one policy with two evaluations, and compare in one task.
    """
    tasks: tuple[Sequence[str], ...] = (TUNED, OTHERS)
    if quick:
        policies, evaluations, motions, tasks = policies[-1:], 2, 8, (TUNED[:1],)
    usual = {one: policy_spec(one) for one in policies}
    print(f"{'policy':22}{'effort':>17}{'option':>16}{'from':>8}{'to':>8}{'tuned':>9}")
    better: dict[str, PolicySpec] = {}
    for text, policy in usual.items():
        better[text], before, after = tuned(policy, evaluations, seed)
        effort = f"{before:.2%} to {after:.2%}"
        for name, (low, high) in RANGES[policy.name].items():
            value = better[text].options.get(name, "usual")
            print(f"{text:22}{effort:>17}{name:>16}{low:8g}{high:8g}{value:>9}", flush=True)
        path = Path(f"{policy.name}-tuned.json")
        path.write_text(json.dumps(better[text].to_dict(), indent=1) + "\n", encoding="utf-8")
    print(f"\n{'relief, usual to tuned':22}" + "".join(f"{' and '.join(one):>28}" for one in tasks))
    both = {
        f"{text} {way}": one
        for way, group in (("usual", usual), ("tuned", better))
        for text, one in group.items()
    }
    by_task = {task: reliefs(task, both, motions) for group in tasks for task in group}
    for text in policies:
        means = (
            [
                np.mean([by_task[task][f"{text} {way}"] for task in group])
                for way in ("usual", "tuned")
            ]
            for group in tasks
        )
        print(f"{text:22}" + "".join(f"{a:>19.2f} to {b:.2f}" for a, b in means))


if __name__ == "__main__":
    tyro.cli(main)
