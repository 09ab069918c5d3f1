"""The comparison in drawn suits: what counts, and trials that are kept."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.tools import robustness
from activesuit.tools.robustness import BEST, FITTED, GAINS, Place, Trials, compared

RNG = np.random.default_rng(0)
UNSUITED, COST = RNG.uniform(0.1, 0.15, 20), RNG.uniform(0.08, 0.12, 20)


def trial(relief, success=1.0):
    effort = UNSUITED + COST * (1 - np.asarray(relief) * np.ones(20))
    succeeds = np.arange(20) < 20 * success
    return {"effort": effort.tolist(), "success": succeeds.tolist(), "chatter": [0.5] * 20}


def trials(**more):
    found = {"unsuited": trial(1.0), "suited": trial(0.0), "compensation": trial(0.5)}
    return found | more


def test_a_policy_is_compared_with_compensation_in_the_same_draws():
    each = np.linspace(0.2, 1.0, 20)
    scores = compared(trials(mine=trial(each, 0.75), lost=trial(np.inf)), "unseen")
    one = scores["mine"]
    assert one["relief"]["value"] == pytest.approx((each * COST).sum() / COST.sum())
    assert one["difference"]["value"] == pytest.approx(one["relief"]["value"] - 0.5)
    assert one["relief"]["low"] < 0.6 < one["relief"]["high"]
    assert (one["success"], one["chatter"], one["draws"]) == (0.75, 0.5, 20)
    assert one["worst_quarter"] == pytest.approx(np.sort(one["each"])[:5].mean())
    assert scores["compensation"]["difference"] == {"value": 0.0, "low": 0.0, "high": 0.0}
    assert scores["lost"]["relief"] is scores["lost"]["difference"] is None


def test_beyond_counts_where_the_best_known_plan_succeeds():
    found = trials(mine=trial(1.2, 0.5), **{BEST: trial(1.1, 0.7)})
    inside, outside = compared(found, "unseen"), compared(found, "beyond")
    assert inside["mine"]["draws"] == 20 and outside["mine"]["draws"] == 14
    assert outside["mine"]["success"] == pytest.approx(10 / 14)
    # The commands of a policy that succeeds are a known plan, too.
    assert 1.1 < inside[BEST]["relief"]["value"] < 1.2
    few = compared(trials(**{BEST: trial(1.1, 0.2)}) | {"compensation": trial(0.5, 0.2)}, "beyond")
    assert few[BEST]["draws"] == 4 and few[BEST]["relief"] is None


def test_trials_are_kept_and_the_gain_has_the_least_effort(tmp_path, monkeypatch):
    ran = []

    def run(name, given, env, seeds, *, level, **options):
        ran.append((name, str(given), level, seeds[0], options.get("faults")))
        gain = dict(getattr(given, "options", {})).get("gain", 1.0)
        size, chatter = len(seeds), {"chatter": [0.0] * len(seeds)}
        effort = tuple([0.1 + (gain - 1.25) ** 2] * size)
        score = SimpleNamespace(effort=effort, success=(True,) * size, costs=chatter)
        return SimpleNamespace(score=score)

    monkeypatch.setattr(robustness, "run", run)
    kept = Trials(tmp_path, {})
    assert kept.fitted("ArmTracking", 8) == 1.25
    assert len(ran) == len(GAINS)
    assert {(level, first) for _, _, level, first, _ in ran} == {("randomized", 40_000)}
    assert Trials(tmp_path, {}).fitted("ArmTracking", 8) == 1.25 and len(ran) == len(GAINS)
    place = Place("ArmTracking", "unseen", range(10_000, 10_008))
    kept.of(place, FITTED, 1.25)
    kept.of(place, "adaptive-biased")
    assert ran[-2][1] == "compensation:gain=1.25"
    assert ran[-1][1] == "adaptive" and ran[-1][4] == {"torque_bias": 2.0}
    file = tmp_path / "ArmTracking.unseen.10000-10007.adaptive-biased.json"
    assert json.loads(file.read_text())["result"]["success"] == [True] * 8
    with pytest.raises(InputError, match="give another --out"):
        Trials(tmp_path, {"gravity": "mars"}).of(place, "adaptive-biased")
