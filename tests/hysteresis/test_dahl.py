"""Dahl's friction beside a spring."""

import numpy as np
import pytest
from activesuit.hysteresis.dahl import Dahl, fit_dahl

ANGLE = 0.8 + 0.4 * np.sin(np.linspace(0, 6 * np.pi, 600)) * np.linspace(1, 0.3, 600)
TRUE = Dahl((1.0, 2.0, -3.0, 1.5), stiffness=30.0, friction=2.0, start_angle=float(ANGLE[0]))


def test_it_solves_its_equation():
    """The exact solution, beside many small steps of Euler's method."""
    fine = np.interp(np.linspace(0, 599, 600_001), np.arange(600), ANGLE)
    friction = 0.0
    for step in np.diff(fine):
        friction += TRUE.stiffness * (step - abs(step) * friction / TRUE.friction)
    spring = np.polynomial.polynomial.polyval(ANGLE[-1], TRUE.spring)
    assert TRUE.response(ANGLE)[-1] == pytest.approx(spring + friction, abs=1e-3)


def test_the_fit_finds_what_made_the_data():
    rng = np.random.default_rng(0)
    found = fit_dahl(ANGLE, TRUE.response(ANGLE) + 0.01 * rng.standard_normal(ANGLE.size))
    assert found.stiffness == pytest.approx(TRUE.stiffness, rel=0.02)
    assert found.friction == pytest.approx(TRUE.friction, rel=0.02)
    np.testing.assert_allclose(found.response(ANGLE), TRUE.response(ANGLE), atol=0.01)


def test_a_belief_advances_many_memories_and_looks_ahead():
    memories = np.repeat(TRUE.begin()[None], 3, axis=0)
    angle = np.array([0.9, 1.0, 1.1])
    ahead = TRUE.advance(memories, angle, angle + 0.02)
    np.testing.assert_array_equal(memories[:, 0], angle)
    there = TRUE.advance(memories, angle + 0.02, angle + 0.02)
    np.testing.assert_allclose(ahead, there, rtol=1e-12)
    rest = memories.copy()
    TRUE.advance(memories, memories[:, 0].copy(), memories[:, 0].copy())
    np.testing.assert_array_equal(memories, rest)
