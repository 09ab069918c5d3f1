"""`activesuit benchmark tune`: finds the options of a policy within a given budget."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import Array
from ...checks import at_least, check_seed
from ...envs.benchmark.tuning import tunable, tuning_cost
from ...envs.policies import PolicySpec, policy_spec
from ...errors import InputError, install_line
from ...files import check_target, replacing
from ..backends import check_backend, run_all
from ..conclusion import conclude
from ..options import Force, Json, PolicyName, Seed, Trust
from ..output import progress, say, to_json

BUDGET = 200  # evaluations
DIGITS = 4
STEP = 0.25  # first step size, relative to the box, as pycma advises


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
        best, after = _least(cost, max(2, len(ranges)), evaluations, seed)
    spec = _with(given, ranges, best)
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


def _least(
    cost: Callable[[Array], Array], dimensions: int, evaluations: int, seed: int
) -> tuple[Array, float]:
    """Returns the best point of the unit box, and its cost, by CMA-ES within the budget.

    Each restart has twice the population of the one before.
    """
    try:
        import cma
    except ImportError as error:
        raise InputError(
            f"CMA-ES needs the package cma, which is not installed: run {install_line('tune')} in "
            "the clone of the repository"
        ) from error
    rng = np.random.default_rng(seed)
    options: dict[str, Any] = {
        "bounds": [0.0, 1.0],
        "verbose": -9,
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": np.nan,  # NaN leaves NumPy's global generator alone
    }
    best, least = np.zeros(dimensions), np.inf
    while evaluations:
        strategy = cma.CMAEvolutionStrategy(rng.random(dimensions), STEP, options)
        while evaluations and not strategy.stop():
            asked = np.clip(strategy.ask(), 0, 1)
            values = cost(asked[:evaluations])
            evaluations -= len(values)
            if values.min() < least:
                best, least = asked[values.argmin()], float(values.min())
            if len(values) == len(asked):
                strategy.tell(asked, values)
        options["popsize"] = 2 * strategy.popsize
    return best, least


def _with(given: PolicySpec, ranges: dict[str, tuple[float, float]], point: Array) -> PolicySpec:
    """Returns the policy at a point of the unit box; options are on a logarithmic scale."""
    values = {
        name: float(f"{low * (high / low) ** share:.{DIGITS}g}")
        for (name, (low, high)), share in zip(ranges.items(), point, strict=False)
    }
    return PolicySpec(given.name, {**given.options, **values})


def _numbered(number: int, spec: PolicySpec) -> tuple[int, float]:
    return number, tuning_cost(spec)
