"""Figures of learning curves."""

import pytest
from activesuit.scripts.reports.learning import study_figure

NAMES = {"task": "ArmTracking", "level": "shift"}
BESIDE = [{**NAMES, "policy": "compensation:suit=mock-suit", "in_training": 0.5}]


def panel(*ends):
    """A panel of ways that train so many steps each, with an interval as wide as the first one."""
    curves = [
        {**NAMES, "way": f"way {i}", "steps": steps, "value": value, "low": -9.0, "high": 9.0}
        for i, end in enumerate(ends)
        for steps, value in ((1000, -0.5), (end, 0.3))
    ]
    (ax,) = study_figure(curves, BESIDE).axes
    return ax


def test_all_means_are_seen_and_wide_intervals_are_cut():
    assert panel(2000).get_ylim() == pytest.approx((-0.65, 0.65))
    one = [{**NAMES, "way": "ppo", "steps": 1000, "value": 0.5}]
    (ax,) = study_figure(one, BESIDE).axes  # all at one height
    low, high = ax.get_ylim()
    assert low < 0.5 < high


def test_steps_are_logarithmic_where_trainings_differ_much():
    assert panel(2000, 6000).get_xscale() == "linear"
    assert panel(2000, 20_000).get_xscale() == "log"
