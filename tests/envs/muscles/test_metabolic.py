"""Metabolic power against values worked out by hand, and what both models promise."""

import numpy as np
import pytest
from activesuit.envs.muscles import MyoArm
from activesuit.envs.muscles.metabolic import MODELS, bhargava, muscle_masses, umberger
from activesuit.envs.muscles.myoarm import Geometry


@pytest.fixture(scope="module")
def arm():
    return MyoArm.load()


def geometry(arm, *, length=1.0, speed=0.0, full=1.0, isometric=1.0):
    """One sample in which all muscles have the same length, speed in lengths/s and force."""
    ones = np.ones((1, len(arm.muscles)))
    return Geometry(
        length=length * ones,
        speed=speed * arm.optimal * ones,
        arms=np.zeros((1, 7, len(arm.muscles))),
        full=full * arm.peak * ones,
        isometric=isometric * arm.peak * ones,
        passive=0 * ones,
        outside=np.zeros(1, bool),
    )


def test_masses_follow_from_force_length_tension_and_density(arm):
    i = arm.muscles.index("BRA")
    expected = arm.peak[i] / 0.5e6 * arm.optimal[i] * 1059.7
    assert muscle_masses(arm)[i] == pytest.approx(expected)
    assert 2 < muscle_masses(arm).sum() < 6  # kg


def test_umberger_of_an_isometric_muscle(arm):
    found = umberger(arm, geometry(arm), np.full((1, 32), 0.3)) / muscle_masses(arm)
    assert found == pytest.approx(1.5 * (25 + 128 * 0.5) * 0.3**0.6 * np.ones((1, 32)))
    long = umberger(arm, geometry(arm, length=1.2, isometric=0.5), np.full((1, 32), 0.3))
    assert long / muscle_masses(arm) == pytest.approx(0.7 * found)


def test_umberger_of_shortening_and_lengthening(arm):
    a, active = np.full((1, 32), 0.3), 1.5 * 89 * 0.3**0.6
    fast = arm.fastest
    heat = 1.5 * 0.09 * (0.5 * 250 / fast + 0.5 * 153 / fast) * 0.1
    work = 0.3 * 0.8 * arm.peak * 0.1 * arm.optimal
    found = umberger(arm, geometry(arm, speed=-0.1, full=0.8), a)
    assert found[0] == pytest.approx(muscle_masses(arm) * (active + heat) + work)
    found = umberger(arm, geometry(arm, speed=0.1, full=1.2), a)
    assert found[0] == pytest.approx(
        muscle_masses(arm) * (active + 1.5 * 0.3 * 0.3 * 250 / fast * 0.1)
    )


def test_bhargava(arm):
    slow, fast = 0.5 * np.sin(0.15 * np.pi), 0.5 * (1 - np.cos(0.15 * np.pi))
    heat = (40 + 74) * slow + (133 + 111) * fast
    a = np.full((1, 32), 0.3)
    assert bhargava(arm, geometry(arm), a)[0] == pytest.approx(muscle_masses(arm) * heat)
    short = (40 + 0.75 * 74) * slow + (133 + 0.75 * 111) * fast
    force, speed = 0.3 * 0.8 * arm.peak, 0.1 * arm.optimal
    found = bhargava(arm, geometry(arm, length=0.75, speed=-0.1, full=0.8, isometric=0.9), a)[0]
    shortening = (0.16 * 0.3 * 0.9 * arm.peak + 0.18 * force) * speed
    assert found == pytest.approx(muscle_masses(arm) * short + shortening + force * speed)


@pytest.mark.parametrize("model", MODELS.values())
def test_a_resting_muscle_has_a_watt_a_kilogram(arm, model):
    rest = model(arm, geometry(arm, speed=0.5), np.zeros((1, 32)))[0]
    assert rest == pytest.approx(muscle_masses(arm))
    pulled = model(arm, geometry(arm, speed=2.0, full=1.4), np.full((1, 32), 0.5))
    assert (pulled >= rest).all()  # a muscle that is pulled long gives nothing back
