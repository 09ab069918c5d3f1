"""Numbers in sentences that are written by hand: what they must be, from the measured results.

A test looks for each in its page; where it is missing, the result has changed, and the sentence
must follow.
"""

from collections.abc import Callable, Iterator

from ..envs.evaluation import REFERENCES
from .measure import kept
from .results import WEIGHTLESS, interval, relief_at, scores, standing, standings


def _controllers() -> Iterator[str]:
    earth = scores("earth")
    bare, suited, off = (100 * earth[name]["effort"] for name in (*REFERENCES, "none"))
    yield f"from {bare:.1f} to {suited:.1f} % of strength"
    yield f"motors off adds {off - suited:.1f} points"
    stiff = kept("cuffs-weightless")["result"]["scores"]
    corrected, usual = stiff["corrected"], stiff["compensation"]
    yield f"relief is {interval(corrected['relief'])} instead of {interval(usual['relief'])}"
    errors = (f"{1e3 * one['tracking']:.0f}" for one in (corrected, usual))
    yield f"the tracking error {' instead of '.join(errors)} mrad"
    found = kept("laws-earth")["result"]["scores"]
    errors = (f"{1e3 * found[name]['tracking']:.1f}" for name in ("impedance", "compensation"))
    yield f"to {' mrad on Earth, where compensation is at '.join(errors)}"


def _benchmark() -> Iterator[str]:
    def change(policy: str, level: str = "nominal") -> str:
        return f"from {relief_at(policy, level)} to {relief_at(f'{policy}-tuned', level)}"

    yield f"`proportional` rises {change('proportional')}"
    yield f"`impedance` {change('impedance')}"
    yield f"`iterative` falls {change('iterative')}"
    yield f"`disturbance-observer` falls {change('disturbance-observer', 'shift')}"
    yield f"`observer` rises {change('observer', 'shift')}"
    best = [relief_at("clairvoyant", level) for level in standings().levels]
    yield f"most relief at every level: {best[0]}, {best[1]} and {best[2]}"
    alike = standing("predictive", "nominal").compared
    if alike is not None:
        yield f"about as much relief in {100 * alike[1]:.0f} % of the motions at nominal"
    adaptive = standing("adaptive", "shift").compared
    if adaptive is not None:
        yield f"in {100 * adaptive[0]:.0f} % of the motions, and less in {100 * adaptive[2]:.0f} %"
    tuned = standing("adaptive-tuned", "shift").compared
    if tuned is not None:
        yield f"more relief than compensation in {100 * tuned[0]:.0f} % of the motions at shift"


def _environments() -> Iterator[str]:
    earth, space = scores("earth"), scores(WEIGHTLESS)
    pairs = {
        name: f"{earth[name]['reward']:.2f}{between}{space[name]['reward']:.2f}"
        for name, between in (("suited", " on Earth and "), ("unsuited", " and "))
    }
    both = f"{earth['compensation']['reward']:.2f} and {space['compensation']['reward']:.2f}"
    yield f"earns {pairs['suited']} weightless, the unsuited one {pairs['unsuited']}"
    yield f"compensation {both}"
    rows = {(one["what"], one["against"]): one for one in kept("bench-env")["result"]["rows"]}
    reset = rows["reset of 1024 rows", ""]["ours"]
    yield f"takes {reset:.2f} ms a row"
    yield f"their process {rows['memory of 1024 rows', '']['ours']:.0f} MB"


FACTS: dict[str, Callable[[], Iterator[str]]] = {
    "controllers.md": _controllers,
    "benchmark.md": _benchmark,
    "environments.md": _environments,
}
"""Parts of sentences by the page that has them."""
