"""Curves without memory."""

import numpy as np
from activesuit.assets import load_suit
from activesuit.hysteresis.branches import Branches, spring, spring_with_friction, two_branches

ANGLE = 0.8 + 0.5 * np.sin(np.linspace(0, 4 * np.pi, 400))
WAY = np.where(np.diff(ANGLE, prepend=0) > 0, 1.0, -1.0)


def test_they_find_what_made_the_data():
    line = 2.0 + 3.0 * ANGLE
    np.testing.assert_allclose(spring(ANGLE, line).rising, (2, 3), atol=1e-9)
    rubbing = spring_with_friction(ANGLE, line + 0.7 * WAY)
    np.testing.assert_allclose(rubbing.rising, (2.7, 3), atol=0.02)
    np.testing.assert_allclose(rubbing.falling, (1.3, 3), atol=0.02)
    cubic = np.where(WAY > 0, 1 + ANGLE**3, ANGLE**2)
    found = two_branches(ANGLE, cubic)
    ends = [np.polyval(way[::-1], 0.9) for way in (found.rising, found.falling)]
    np.testing.assert_allclose(ends, (1.729, 0.81), atol=0.05)


def test_more_knowledge_fits_better():
    entry = load_suit("mock-suit").joints["elbow_flexion"]
    angle = np.concatenate([np.linspace(0.6, 1.4, 200), np.linspace(1.4, 0.6, 200)[1:]])
    torque = entry.response(angle)
    errors = []
    for fit in (spring, spring_with_friction, two_branches):
        errors.append(np.sqrt(np.mean((fit(angle, torque).response(angle) - torque) ** 2)))
    assert errors[0] > errors[1] > errors[2]


def test_the_direction_lasts_through_a_rest():
    path = np.array([0.1, 0.1, 0.05, 0.05, 0.2])
    assert Branches((1.0,), (-1.0,)).response(path).tolist() == [1, 1, -1, -1, 1]
