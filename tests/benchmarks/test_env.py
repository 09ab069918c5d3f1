"""The environments' benchmark, whose ratios test_cli tests; an arm that is hindered fails."""

import importlib.util

import pytest
from activesuit.benchmarks import env
from activesuit.benchmarks.hindered import hindered
from activesuit.envs.tasks import TASKS

pytestmark = pytest.mark.slow


def test_without_stable_baselines_its_row_is_left_out(monkeypatch, capsys):
    for part in ("_some_rows", "_resets", "_memory"):
        monkeypatch.setattr(env, part, lambda *_: [])
    for part in ("_single", "_many_rows"):
        monkeypatch.setattr(env, part, lambda *_: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert env.rows(1) == [None, None]
    assert "Stable-Baselines3 is left out" in capsys.readouterr().err


@pytest.mark.parametrize("task", TASKS)
def test_no_success_for_an_arm_that_is_hindered(task):
    (found,) = hindered([task], motions=2)
    assert not any(found.success.values())
    assert min(found.effort.values()) > 0.2
    assert found.frozen > 1.5 * found.tracking or task == "Hammer"  # which asks for blows
