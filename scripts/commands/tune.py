"""`activesuit benchmark tune`: finds the options of a policy within a given budget."""

from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import Array
from ...checks import at_least, check_seed
from ...envs.benchmark.tuning import tunable, tuning_cost
from ...envs.policies import PolicySpec, policy_spec
from ...errors import InputError
from ...files import check_target, replacing
from ...identification.optimizers.libraries import cma_es
from ..backends import check_backend, run_all
from ..conclusion import conclude
from ..options import Force, Json, PolicyName, Seed, Trust
from ..output import progress, say, to_json

BUDGET = 200  # evaluations
DIGITS = 4


def tune(
    policy: PolicyName,
    out: Path | None = None,
    evaluations: int = BUDGET,
    seed: Seed = 0,
    workers: int = -1,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
) -> None:
    """Tune the options of a policy within a budget, the same for all.

    CMA-ES minimizes the effort of adapted wearers at the level randomized, in motions that no
    evaluation shows. The result is data, which --policies takes.

    Args:
        policy: Policy to tune; options that are given stay as they are.
        out: New JSON file for the policy with its options.
        evaluations: Number of evaluations, 200 in the benchmark.
        workers: Number of evaluations at once; -1 uses all cores.
    """
    given = policy_spec(policy, trust=trust)
    at_least("evaluations", evaluations, 1)
    check_seed(seed)
    check_backend("loky", workers)
    if out:
        check_target(out, force=force)
    ranges = {name: ends for name, ends in tunable(given.name).items() if name not in given.options}
    if not ranges:
        raise InputError(f"all options of policy {given.name!r} are given: leave one out")
    before = tuning_cost(given)
    with progress(f"tuning {given.name}", evaluations) as bar:

        def cost(points: Array) -> Array:
            calls = [(i, _with(given, ranges, point)) for i, point in enumerate(points)]
            found = np.empty(len(calls))
            for i, value in run_all(_numbered, calls, "loky", workers):
                found[i] = value
                bar.advance()
            return found

        # CMA-ES needs two parameters: one that means nothing is beside a single one.
        best = cma_es(cost, [(0.0, 1.0)] * max(2, len(ranges)), evaluations, seed)
    spec, after = _with(given, ranges, best.x), float(best.fun)
    if after >= before:
        spec, after = given, before
    if out:
        with replacing(out, force=force) as scratch:
            scratch.write_text(to_json(spec.to_dict()) + "\n", encoding="utf-8")
    result: dict[str, Any] = {"policy": spec.to_dict(), "before": before, "after": after}
    result |= {"evaluations": evaluations, "seed": seed}
    rows = [
        [name, f"{low:g} to {high:g}", f"{spec.options.get(name, 'usual')}"]
        for name, (low, high) in ranges.items()
    ]
    tables = {f"tuned {given.name}": (["option", "range", "value"], rows)}
    remark = f"mean effort {100 * before:.2f} % of strength before, {100 * after:.2f} % after"
    conclude(result, tables, [remark], folder=None, json=json)
    if out:
        say(f"wrote {out}")


def _with(given: PolicySpec, ranges: dict[str, tuple[float, float]], point: Array) -> PolicySpec:
    """Returns the policy at a point of the unit box; options are on a logarithmic scale."""
    values = {
        name: float(f"{low * (high / low) ** share:.{DIGITS}g}")
        for (name, (low, high)), share in zip(ranges.items(), point, strict=False)
    }
    return PolicySpec(given.name, {**given.options, **values})


def _numbered(number: int, spec: PolicySpec) -> tuple[int, float]:
    return number, tuning_cost(spec)
