"""Intervals hold the truth as often as they say, and values by hand."""

import json

import numpy as np
import pytest
from activesuit.envs.evaluation.statistics import (
    Interval,
    difference_interval,
    interquartile_mean_interval,
    interval_of,
    mean_interval,
    ratio_interval,
)
from helpers import assert_refused
from scipy.stats import trim_mean

LEVEL, REPEATS, MOTIONS = 0.95, 2000, 20
RESAMPLES = 200  # ranks are exact at any number; fewer only move the ends more from seed to seed


def tolerance(repeats: int) -> float:
    """Four standard errors of a coverage: 93 to 97 % in 2,000 repeats."""
    return 4 * np.sqrt(LEVEL * (1 - LEVEL) / repeats)


def paired(rng, n, **given):
    one, noise = rng.standard_normal((2, n))
    other = 0.9 * one + np.sqrt(1 - 0.9**2) * noise + 0.3
    return difference_interval(other, one, **given)


def ratio(rng, n, **given):
    under = rng.gamma(1 / 0.3**2, 0.3**2, n)  # mean 1, coefficient of variation 0.3
    over = under * rng.beta(4, 2, n)
    return ratio_interval(over, under, **given)


CASES = {  # an interval, and the truth
    "normal": (lambda rng, n, **given: mean_interval(rng.normal(1, 1, n), **given), 1),
    "skewed": (lambda rng, n, **given: mean_interval(rng.gamma(2, 1, n), **given), 2),
    "heavy tails": (lambda rng, n, **given: mean_interval(rng.standard_t(5, n), **given), 0),
    "paired": (paired, 0.3),
    "ratio": (ratio, 4 / 6),
}


@pytest.mark.parametrize(("interval", "truth"), CASES.values(), ids=CASES)
def test_coverage(interval, truth):
    rng = np.random.default_rng(1)
    found = [interval(rng, MOTIONS, resamples=RESAMPLES, seed=seed) for seed in range(REPEATS)]
    kept = np.mean([one.low <= truth <= one.high for one in found])
    assert kept == pytest.approx(LEVEL, abs=tolerance(REPEATS))


def test_coverage_of_interquartile_means_of_runs_that_differ():
    rng, repeats, kept = np.random.default_rng(2), 500, 0
    for seed in range(repeats):
        scores = rng.standard_normal((10, 1)) + 0.5 * rng.standard_normal((10, 20))
        found = interquartile_mean_interval(scores, resamples=RESAMPLES, seed=seed)
        kept += found.low <= 0 <= found.high
    assert kept / repeats == pytest.approx(LEVEL, abs=tolerance(repeats))


def test_seeds_and_levels():
    values = np.random.default_rng(0).gamma(2, 1, MOTIONS)
    one, same, other = (mean_interval(values, seed=seed) for seed in (0, 0, 1))
    assert one == same and one != other
    width = one.high - one.low
    assert abs(one.low - other.low) < 0.1 * width
    assert abs(one.high - other.high) < 0.1 * width
    narrow, wide = (mean_interval(values, level=level) for level in (0.5, 0.99))
    assert wide.low < narrow.low < narrow.value < narrow.high < wide.high


def test_relief_by_hand():
    suited, assisted = np.arange(10.0, 18.0), np.array([6, 5, 8, 7, 7, 9, 8, 10.0])
    bare = np.array([4, 4, 5, 5, 6, 6, 7, 7.0])
    found = ratio_interval(suited - assisted, suited - bare)
    assert found.value == pytest.approx(48 / 64)  # sums: 108, 60 and 44
    assert found.low < found.value < found.high
    same = interval_of(lambda s, a, b: (s - a) / (s - b), suited, assisted, bare)
    assert same.to_dict() == pytest.approx(found.to_dict())
    endless = ratio_interval(np.ones(10), np.tile([-1.0, 1.1], 5))
    assert (endless.low, endless.high) == (-np.inf, np.inf)


@pytest.mark.parametrize("shape", [(7, 5), (6, 1)])
def test_interquartile_mean(shape):
    scores = np.random.default_rng(0).gamma(2, 1, shape)
    found = interquartile_mean_interval(scores)
    assert found.value == pytest.approx(trim_mean(scores, 0.25, axis=None))
    assert found.low < found.value < found.high


@pytest.mark.parametrize("value", [0.0, 0.1, -3e7])
def test_equal_values(value):
    for found in (
        mean_interval(np.full(MOTIONS, value)),
        interquartile_mean_interval(np.full((5, 3), value)),
        ratio_interval(np.full(MOTIONS, value), np.full(MOTIONS, 0.7)),
    ):
        assert found.low == found.value == found.high


def test_one_odd_motion_keeps_the_ends_finite():
    found = mean_interval([0] * 19 + [1])  # a third of the resamples are constant
    assert -0.1 < found.low < 0.05 < found.high < 0.5


def test_text_and_json():
    rows = [
        ((0.8712, 0.8101, 0.9312), "0.87 (0.81 to 0.93)"),
        ((1234.5, 1200.1, 1270.2), "1234 (1200 to 1270)"),
        ((0.5, 0.5, 0.5), "0.5 (0.5 to 0.5)"),
        ((0.5, -np.inf, np.inf), "0.5 (-inf to inf)"),
    ]
    assert [str(Interval(*values)) for values, _ in rows] == [text for _, text in rows]
    interval = Interval(0.8712, 0.8101, 0.9312)
    assert json.loads(json.dumps(interval.to_dict())) == interval.to_dict()


VALUES = np.arange(10.0)


def test_what_cannot_be_used():
    rows = [
        (lambda: mean_interval(VALUES[:7]), "needs at least 8 motions, and there are 7: give more"),
        (lambda: mean_interval([*VALUES, np.nan]), r"values\[10\] is nan: give finite numbers"),
        (lambda: difference_interval(VALUES, VALUES[1:]), "one, other have 10 and 9 motions: give"),
        (lambda: ratio_interval(VALUES, VALUES - 4.5), "the denominators sum to 0: a ratio needs"),
        (lambda: interval_of(np.mean), "no series is given: give at least one"),
        (lambda: interval_of(np.mean, VALUES), r"the statistic returns shape \(\) for means of sh"),
        (lambda: interval_of(np.log, VALUES - 9), "is nan with a standard error of nan: give a"),
        (lambda: mean_interval(VALUES, level=1.0), "level is 1.0: use a number from 0.5 to 0.99"),
        (lambda: mean_interval(VALUES, resamples=10), "resamples is 10: use at least 200"),
        (lambda: mean_interval(VALUES, seed=-1), "seed is -1: use at least 0"),
        (lambda: interquartile_mean_interval(np.ones((4, 9))), "at least 5 runs, and scores has 4"),
        (lambda: interquartile_mean_interval("many"), "scores is no table of numbers: give the"),
    ]
    assert_refused(lambda call: call(), rows)


def test_equal_motions_count_once():
    values = np.random.default_rng(0).normal(size=10)
    assert mean_interval(values, motion=range(10)) == mean_interval(values)
    twice = np.repeat(values, 2)
    doubled = mean_interval(twice, motion=np.repeat(range(10), 2).tolist())
    assert doubled == mean_interval(values)
    few = mean_interval(values, motion=[0, 1] * 5)
    assert (few.low, few.high) == (-np.inf, np.inf) and few.value == pytest.approx(values.mean())
    ratio = ratio_interval(values, values + 9, motion=[0, 1] * 5)
    assert (ratio.low, ratio.high) == (-np.inf, np.inf)
