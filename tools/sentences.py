"""Numbers in sentences that are written by hand: what they must be, from the measured results.

A test looks for each in its page; where it is missing, the result has changed, and the sentence
must follow.
"""

from collections.abc import Callable, Iterator

from ..envs.evaluation import REFERENCES
from .measure import kept
from .results import WEIGHTLESS, interval, relief_at, scores, settings, standing, standings


def _controllers() -> Iterator[str]:
    earth = scores("earth")
    bare, suited, off = (100 * earth[name]["effort"] for name in (*REFERENCES, "none"))
    yield f"from {bare:.1f} to {suited:.1f} % of strength"
    yield f"motors off adds {off - suited:.1f} points"
    both = [one for place in (earth, scores(WEIGHTLESS)) for one in place.values()]
    apart = max(abs(one["unadapted_effort"] - one["effort"]) for one in both)
    yield f"differ by at most {100 * apart:.1f} points"
    pairs = [
        f"{1e3 * one['unadapted_tracking']:.0f} against {1e3 * one['tracking']:.0f}"
        for one in (earth["suited"], scores(WEIGHTLESS)["none"])
    ]
    yield f"{pairs[0]} mrad in the suit on Earth, {pairs[1]} with the motors off, weightless"
    rigid = [one["scores"] for where, one in settings().items() if "rigid" in where]
    errors = [
        1e3 * max(one[name]["tracking"] for one in rigid) for name in ("none", "compensation")
    ]
    yield f"within {errors[0]:.0f} mrad of the intention"
    yield f"one under compensation within {errors[1]:.0f}"
    stiff = kept("cuffs-weightless")["result"]["scores"]
    corrected, usual = stiff["corrected"], stiff["compensation"]
    yield f"relief is {interval(corrected['relief'])} instead of {interval(usual['relief'])}"
    errors = (f"{1e3 * one['tracking']:.0f}" for one in (corrected, usual))
    yield f"the tracking error {' instead of '.join(errors)} mrad"
    found = kept("laws-earth")["result"]["scores"]
    errors = (f"{1e3 * found[name]['tracking']:.1f}" for name in ("impedance", "compensation"))
    yield f"to {' mrad on Earth, where compensation is at '.join(errors)}"


def _benchmark() -> Iterator[str]:
    best = [relief_at("best-known-plan", level) for level in standings().levels]
    yield f"most relief at every level: {best[0]}, {best[1]} and {best[2]}"
    alike = standing("predictive", "nominal").compared
    if alike is not None:
        yield f"about as much relief in {100 * alike[1]:.0f} % of the motions at nominal"
    adaptive = standing("adaptive", "shift").compared
    if adaptive is not None:
        yield f"in {100 * adaptive[0]:.0f} % of the motions, and less in {100 * adaptive[2]:.0f} %"


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
