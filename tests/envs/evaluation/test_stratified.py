"""Intervals over several tasks."""

import numpy as np
import pytest
from activesuit.envs.evaluation.stratified import (
    interquartile_mean,
    paired_improvement,
    stratified_interval,
)
from activesuit.errors import InputError
from scipy import stats

TASKS, MOTIONS = 6, 20


def test_the_mean_is_that_of_the_middle_half():
    scores = np.random.default_rng(0).normal(size=400)
    assert interquartile_mean(scores) == pytest.approx(stats.trim_mean(scores, 0.25))
    assert interquartile_mean([0, 1, 2, 1000]) == 1.5


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["normal", "gamma", "t"])
def test_coverage_of_the_interquartile_mean(kind):
    """95 % intervals hold the truth in 93 to 97 % of 2,000 repeats."""
    rng = np.random.default_rng(0)
    middle, spread = rng.normal(0.5, 0.4, TASKS), rng.uniform(0.05, 0.3, TASKS)

    def draw(repeats):
        size = repeats, TASKS, MOTIONS
        noise = {
            "normal": lambda: rng.normal(size=size),
            "gamma": lambda: (rng.gamma(2, size=size) - 2) / np.sqrt(2),
            "t": lambda: rng.standard_t(5, size) / np.sqrt(5 / 3),
        }[kind]()
        return middle[:, None] + spread[:, None] * noise

    truth = interquartile_mean(draw(20_000).reshape(20_000, -1)).mean()
    kept = 0
    for repeat, scores in enumerate(draw(2000)):
        found = stratified_interval(list(scores), resamples=400, seed=repeat)
        kept += found.low <= truth <= found.high
    assert 0.93 <= kept / 2000 <= 0.97


@pytest.mark.parametrize("truth", [0.5, 0.8, 0.95])
def test_coverage_of_the_probability_of_improvement(truth):
    rng = np.random.default_rng(1)
    ours = (rng.random((2000, TASKS, MOTIONS)) < truth).astype(float)
    theirs = [np.full(MOTIONS, 0.5)] * TASKS
    intervals = [paired_improvement(list(one), theirs) for one in ours]
    assert 0.93 <= np.mean([one.low <= truth <= one.high for one in intervals]) <= 0.97


def test_the_same_seed_gives_the_same_interval():
    scores = list(np.random.default_rng(0).normal(size=(3, 10)))
    first, again = (stratified_interval(scores, seed=4) for _ in range(2))
    assert first == again
    assert stratified_interval(scores, seed=5) != first


def test_all_wins_keep_a_width_and_ties_count_half():
    all_better = paired_improvement([np.ones(20)], [np.zeros(20)])
    assert all_better.value == 1
    assert 0.8 < all_better.low < 0.9
    assert paired_improvement([[1, 1]], [[1, 1]]).value == 0.5


def test_a_failed_policy_has_no_limits():
    found = stratified_interval([np.full(8, -np.inf)])
    assert (found.low, found.high) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: stratified_interval([]), "at least 2 motions of each"),
        (lambda: stratified_interval([[1.0]]), "at least 2 motions of each"),
        (lambda: stratified_interval([[1, 2]], level=2), "level is 2"),
        (lambda: stratified_interval([[1, 2]], resamples=3), "resamples is 3"),
        (lambda: paired_improvement([[1, 2]], [[1]]), "one has 2 motions and other 1"),
    ],
)
def test_mistakes(call, message):
    with pytest.raises(InputError, match=message):
        call()
