"""Coverage of the intervals of the benchmark, where motions share draws, and where tasks vary."""

import numpy as np
import pytest
from activesuit.envs.evaluation.statistics import interquartile_mean, interquartile_mean_interval

SETTINGS, MOTIONS, TASKS, REPEATS = 24, 20, 12, 1000


def covered(draw):
    """Returns the share of repeats whose nominal 95 % interval holds the truth."""
    truth = np.mean([interquartile_mean(draw().ravel()) for _ in range(20_000)])
    found = (interquartile_mean_interval(draw(), resamples=400, seed=i) for i in range(REPEATS))
    return np.mean([one.low <= truth <= one.high for one in found])


@pytest.mark.slow
@pytest.mark.parametrize(("motions", "shared"), [(5, 0.5), (MOTIONS, 0.0), (MOTIONS, 0.9)])
def test_other_motions(shared, motions):
    """Motion i has a share of its variance in common in all settings, as at `randomized`."""
    rng = np.random.default_rng(0)
    middle, spread = rng.normal(0.5, 0.4, SETTINGS), rng.uniform(0.05, 0.3, SETTINGS)

    def draw():
        common = np.sqrt(shared) * rng.normal(size=(motions, 1))
        own = np.sqrt(1 - shared) * rng.normal(size=(motions, SETTINGS))
        return middle + spread * (common + own)

    assert 0.93 <= covered(draw) <= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("tail", [False, True])
def test_other_tasks(tail):
    """Each task has a middle of its own, and with a tail some are much worse."""
    rng = np.random.default_rng(1)

    def draw():
        middle = rng.normal(0.8, 0.3, (TASKS, 1))
        if tail:
            middle -= rng.gamma(0.3, 1.0, (TASKS, 1))
        return middle + 0.1 * rng.normal(size=(TASKS, 2 * MOTIONS))

    assert 0.92 <= covered(draw) <= 0.97
