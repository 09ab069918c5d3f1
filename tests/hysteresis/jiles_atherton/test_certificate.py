"""Guarantees of the certificate, tested by random motions."""

import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import JilesAtherton, PoleError, nearest_certified
from activesuit.hysteresis.jiles_atherton import kernels
from activesuit.hysteresis.jiles_atherton.langevin import langevin
from activesuit.hysteresis.jiles_atherton.margins import field_at
from activesuit.published import LI_RANGES
from helpers import is_safe, sweep
from hypothesis import given, settings
from hypothesis import strategies as st


def test_margins_of_table_2(table_2):
    steepness = {name: 1 - model.certificate().margin for name, model in table_2.items()}
    for name, expected in (
        ("shoulder-mpso", 1.36),
        ("shoulder-sa-pso", 1.24),
        ("elbow-mpso", 0.86),
    ):
        assert steepness[name] == pytest.approx(expected, abs=0.005)
    assert table_2["elbow-sa-pso"].certificate().certified
    assert not table_2["shoulder-sa-pso"].certificate().certified
    for name, model in table_2.items():  # where the sets were identified, all are safe
        assert is_safe(model, LI_RANGES[name.split("-")[0]])


def test_recoverable_energy_is_what_turning_back_returns(elbow):
    state = elbow.start(0.5)
    state, _ = elbow.step(state, 1.3)
    p, s = elbow.parameter_vector.copy(), state.memory.copy()
    claimed = kernels.recoverable(p, s[0], s[1])
    returned = [-kernels.move(p, s, target)[1] for target in np.linspace(1.3, 0.3, 4001)]
    assert claimed == pytest.approx(max(returned), rel=1e-5)
    assert claimed > 0


def test_the_range_certificate_is_tight(shoulder):
    # The published shoulder meets its pole on the way back from 90 degrees, not from 70.
    assert shoulder.certificate((0.0, 1.22)).margin < shoulder.certificate((0.35, 1.22)).margin
    assert not shoulder.certificate((0.0, np.pi / 2)).certified
    with pytest.raises(PoleError):
        shoulder.response([0.0, np.pi / 2, 0.0])
    highs = np.linspace(1.0, 1.9, 91)
    certified = max(h for h in highs if shoulder.certificate((0.35, h)).certified)
    meets = min(h for h in highs if not swings(shoulder, 0.35, h))
    assert 0 <= meets - certified < 0.5


def swings(model, low, high):
    try:
        model.response([low, high, low, high, low])
    except PoleError:
        return False
    return True


@st.composite
def models_and_ranges(draw):
    """A model with a range of angles, or one that is certified for all of them."""
    Ms, a = 10 ** draw(st.floats(0, 2)), 10 ** draw(st.floats(-1, 3.7))
    c, k = 1 + 10 ** draw(st.floats(-2, 1)), 10 ** draw(st.floats(0, 3.3))
    low, width = draw(st.floats(-100, 100)), 10 ** draw(st.floats(-1, 2.3))
    everywhere = draw(st.booleans())
    steepness = draw(st.floats(-1.9, 0.99) if everywhere else st.floats(-6, 3))
    alpha = steepness * 3 * a / ((2 * c - 1) * Ms)
    model = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    low, high = (-400, 400) if everywhere else (low, low + width)
    return model, (math.radians(low), math.radians(high)), everywhere


@settings(max_examples=900, deadline=None)
@given(
    drawn=models_and_ranges(),
    parts=st.lists(st.floats(0, 1), min_size=2, max_size=40),
    lag=st.floats(-1, 1),
)
def test_no_certified_motion_meets_the_pole_and_the_bounds_hold(drawn, parts, lag):
    model, (low, high), everywhere = drawn
    certificate = model.certificate() if everywhere else model.certificate((low, high))
    assert not everywhere or (certificate.certified and certificate.dissipative)
    if not certificate.certified:
        return
    angles = low + (high - low) * np.array(parts)
    Ms, a, alpha = model.parameter_vector[:3]
    lag *= certificate.memory_bound  # any start that is covered
    field = field_at(angles[0], lag, Ms, a, alpha)
    state = model.start(angles[0], Ms * langevin(field / a)[0] + lag)
    for angle in angles:
        state, torque = model.step(state, angle)
        assert abs(torque) <= certificate.torque_bound * (1 + 1e-9)
        lag = abs(torque - model.anhysteretic(state))
        allowed = certificate.memory_bound * (1 + 1e-6) + 1e-9 * model.Ms
        assert not everywhere or lag <= allowed


def test_nearest_certified_set(shoulder, elbow):
    near, change = nearest_certified(shoulder)
    assert is_safe(near)
    assert 0.005 < change < 0.02
    angle = sweep(0.0, 0.5, -0.5, 0.5)
    moved = near.response(angle) - shoulder.response(angle)
    assert np.sqrt(np.mean(moved**2)) / np.abs(shoulder.response(angle)).max() < 0.02
    assert nearest_certified(elbow) == (elbow, 0.0)


def test_the_nearest_of_a_clamped_or_driving_model_is_certified():
    base = JilesAtherton(Ms=1, a=1, alpha=0, c=2, k=1)
    for change in (
        {"clamp": "irreversible"},
        {"clamp": "jiles", "c": 0.5, "allow_active": True},
        {"form": "original", "c": 0.5, "allow_active": True},
    ):
        assert is_safe(nearest_certified(replace(base, **change))[0])
    with pytest.raises(InputError, match="give a JilesAtherton model"):
        nearest_certified(None)


def test_a_start_outside_the_certificate_is_named():
    model = JilesAtherton(Ms=41.2445, a=28.63447, alpha=-0.073931, c=2.645412, k=0.125618)
    assert model.certificate().certified
    assert not model.start_is_certified(model.start(6.596))
    with pytest.raises(PoleError, match="began outside the model's certificate, further than"):
        model.response([6.596, 0])
