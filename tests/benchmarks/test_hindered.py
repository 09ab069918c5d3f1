"""Exoskeletons that hinder the wearer succeed in no task."""

import pytest
from activesuit.benchmarks.hindered import hindered
from activesuit.envs.tasks import TASKS

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("task", TASKS)
def test_no_success_for_an_arm_that_is_hindered(task):
    (found,) = hindered([task], motions=2)
    assert not any(found.success.values())
    assert min(found.effort.values()) > 0.2
    assert found.frozen > 1.5 * found.tracking or task == "Hammer"  # which asks for blows
