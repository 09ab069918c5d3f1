"""Promises of the protocol, tested in the same way for every model."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit.benchmarks.references import EXAMPLES, Example, integrate, reference_of
from activesuit.errors import InputError
from activesuit.hysteresis import (
    MODELS,
    TABLE_2,
    Asymmetric,
    BoucWen,
    Duhem,
    JilesAtherton,
    Preisach,
    model_from_dict,
)
from activesuit.hysteresis.protocol import responder
from helpers import assert_refused, is_safe, sweep
from hypothesis import given, settings
from hypothesis import strategies as st
from known_models import KNOWN
from stop_models import hinged, stops

SEQUENCES = 40  # random motions per example; with 300 examples 12,000 sequences
# Where a torque does not rise everywhere, the model has no inverse.
RISING = [name for name in KNOWN if name != "preisach"]


@pytest.fixture(params=KNOWN)
def model(request):
    return KNOWN[request.param]


def walk(seed=0, size=300, scale=0.2):
    angle = 0.5 + np.cumsum(np.random.default_rng(seed).normal(0, scale, size))
    angle[100:104] = angle[100]
    return angle


def test_every_model_is_asked():
    assert {one.name for one in KNOWN.values()} == set(MODELS)


def test_step_is_the_bitwise_twin_of_response(model):
    angle = walk()
    torque = model.response(angle, initial_torque=0.2)
    assert torque[0] == 0.2
    assert torque[100] == torque[103]
    state = model.start(angle[0], 0.2)
    for i in range(1, angle.size):
        before = state.memory.copy()
        after, stepped = model.step(state, angle[i])
        np.testing.assert_array_equal(state.memory, before)
        assert stepped == torque[i] == after.torque
        assert after.angle == angle[i]
        state = after
    with pytest.raises(ValueError, match="read-only"):
        state.memory[0] = 1.0


EQUATIONS = {one.name: one for examples in EXAMPLES.values() for one in examples}
for known, published in TABLE_2.items():
    EQUATIONS[f"J-A {known}"] = Example(name=known, model=published, low=0.4, high=1.1)


@pytest.mark.parametrize("name", EQUATIONS)
def test_the_torque_is_that_of_the_readable_model_and_of_its_equation(name):
    one = EQUATIONS[name]
    shares = (0, 1, 0.14, 0.71, 0.07, 0.9, 0)
    turns = np.array([one.low + share * (one.high - one.low) for share in shares])
    torque = one.model.response(turns, one.start_torque)
    fine = one.model.response(sweep(*turns, samples=40), one.start_torque)[::39]
    solved = integrate(reference_of(one.model, turns, one.start_torque), turns, 1e-12)
    readable = reference_of(one.model, turns, one.start_torque)
    np.testing.assert_allclose(fine, solved, atol=2e-8)
    np.testing.assert_allclose(torque, solved, atol=2e-7)
    np.testing.assert_allclose([readable.move(angle) for angle in turns], solved, atol=1e-6)


def test_many_memories_are_moved_as_one(model):
    """`advance` gives the torques of `step`, to the last bit."""
    rng = np.random.default_rng(2)
    states = [model.start(angle, 0.1) for angle in rng.uniform(0.5, 1, 6)]
    memories = np.array([state.memory for state in states])
    for here, soon in rng.uniform(-0.4, 1.4, (10, 2, 6)):
        ahead = model.advance(memories, here, soon)
        states = [model.step(state, angle)[0] for state, angle in zip(states, here, strict=True)]
        np.testing.assert_array_equal(memories, [state.memory for state in states])
        expected = [model.step(state, end)[1] for state, end in zip(states, soon, strict=True)]
        np.testing.assert_array_equal(ahead, expected)


def test_a_motion_to_no_number_changes_no_memory(model):
    p, s = model.parameter_vector.copy(), model.start(0.5, 0.1).memory.copy()
    before, torque = s.copy(), np.empty(4)
    for angle in (math.nan, math.inf, -math.inf):
        assert math.isnan(model.kernels.move(p, s, angle)[0])
        assert math.isnan(model.kernels.commit(p, s, angle))
        np.testing.assert_array_equal(s, before)
        responder(model.kernels)(p, s.copy(), np.array([0.5, 0.7, angle, 0.6]), torque)
        np.testing.assert_array_equal(np.isnan(torque), [False, False, True, True])


def test_splitting_a_motion_changes_nothing(model):
    turns = (0.4, 1.3, 0.1, 0.9, 0.2, 1.5)
    fine = model.response(sweep(*turns, samples=500))[::499]
    np.testing.assert_allclose(model.response(turns), fine, atol=2e-7)


def test_tangent_is_the_slope(model):
    state = model.start(0.5, 0.1)
    for angle in (0.83, 0.61, 0.3, 0.9):
        state, torque = model.step(state, angle)
        for direction in (1, -1):
            step = 1e-7 * direction
            slope = (model.step(state, angle + step)[1] - torque) / step
            assert model.tangent(state, direction) == pytest.approx(slope, rel=1e-4, abs=1e-4)


def test_work_is_stored_plus_dissipated(model):
    turns = (0.5, 1.2, 0.3, 0.8, 0.2)
    angle = sweep(*turns, samples=20_000)
    work = np.trapezoid(model.response(angle), angle)
    first = last = model.start(turns[0])
    for target in turns[1:]:
        last, _ = model.step(last, target)
    change = np.subtract(model.energy(last), model.energy(first)).sum()
    assert change == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("name", RISING)
def test_inverse_takes_the_response_back(name):
    model, angle = KNOWN[name], sweep(0.5, 1.1, 0.4, 0.9, samples=12)
    torque = model.response(angle)
    found = model.inverse(torque, angle[0])
    # In a gap all angles give no torque, and the inverse is where contact opens.
    loaded = (np.abs(torque) > 1e-8) | ("gap" not in json.dumps(model.to_dict()))
    np.testing.assert_allclose(found[loaded], angle[loaded], atol=1e-9)
    np.testing.assert_allclose(model.response(found), torque, atol=1e-9)


def test_json_round_trip(model):
    again = model_from_dict(json.loads(json.dumps(model.to_dict())))
    assert again == model
    angle = walk(3)
    np.testing.assert_array_equal(again.response(angle), model.response(angle))


def test_scalings_are_exact(model):
    angle = walk(1)
    scaled = model.scaled(torque=1.35, angle=2.5)
    torque = scaled.response(2.5 * angle)
    np.testing.assert_allclose(torque, 1.35 * model.response(angle), rtol=1e-9, atol=1e-9)


def test_bad_motions(model):
    series = ([], [[0.1]], [0.1, math.nan], [0.0, math.inf])
    other = (["a"], {}, 1 + 2j, None, [10**400])
    assert_refused(model.response, [(bad, "angle") for bad in (*series, *other)])
    assert_refused(model.inverse, [(bad, "torque") for bad in (*other, [0.0, math.nan])])
    assert_refused(model.start, [(math.inf, "angle is inf"), (0.0, math.nan, "torque is nan")])
    for follow in (model.response, model.inverse):
        with pytest.raises(InputError, match="is not a series of real numbers"):
            follow([[1, 2], [3]])
    state, scales = model.start(0.5), (0.0, -1.0, math.inf, math.nan)
    assert_refused(lambda angle: model.step(state, angle), [(math.nan, "angle is nan")])
    assert_refused(lambda one: model.scaled(torque=one), [(x, "torque scale is") for x in scales])
    assert_refused(lambda one: model.scaled(angle=one), [(x, "angle scale is") for x in scales])
    wrong = [(one, "give a number") for one in ("x", None, True, [1.0])]
    assert_refused(lambda angle: model.step(state, angle), wrong)
    assert_refused(lambda torque: model.start(0.5, torque), wrong)
    assert_refused(lambda torque: model.scaled(torque=torque), wrong)
    ranges = ((1.0, 1.0), (1.0, 0.5), (math.nan, 1.0), "ab", 3.0, (1, 2, 3))
    rows = [(one, "angle_range is .*two ascending angles") for one in ranges]
    assert_refused(model.certificate, rows)


def test_bad_dictionaries():
    known = KNOWN["bouc-wen, n = 1"].to_dict()
    rows = [
        ({"model": "maxwell"}, "unknown model 'maxwell'"),
        ({}, "unknown model 'None'"),
        ({"model": ["x"]}, "unknown model"),
        ({"model": "bouc-wen", "elastic": 1}, "model 'bouc-wen' has no hysteretic"),
        (known | {"color": 1}, "unknown parameter of 'bouc-wen' 'color'"),
        ([1, 2], "described by a dictionary"),
    ]
    assert_refused(model_from_dict, rows)


@st.composite
def dissipative_models(draw):
    """A certified, dissipative model of any kind."""
    kind = draw(st.integers(0, 5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    if kind == 0:
        Ms, a, c = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(-1, 3.7), 1 + 10 ** rng.uniform(-2, 1)
        alpha = rng.uniform(-1.9, 0.99) * 3 * a / ((2 * c - 1) * Ms)
        k = 10 ** rng.uniform(0, 3.3)
        model = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    elif kind == 1:
        beta = 10 ** rng.uniform(-1, 1.5)
        gamma, n = beta * rng.uniform(-0.99, 1), rng.choice([1, 1.3, 2, 4.5])
        elastic, hysteretic = rng.uniform(0, 5), 10 ** rng.uniform(-1, 1)
        model = BoucWen(elastic=elastic, hysteretic=hysteretic, beta=beta, gamma=gamma, n=n)
    elif kind == 2:
        size = int(rng.integers(1, 9))
        levels = np.cumsum(rng.uniform(0.05, 0.5, size + 1)) - 1
        density = [rng.uniform(0, 1, i + 1).tolist() for i in range(size)]
        model = Preisach(levels=levels, density=density, elastic=rng.uniform(-1, 3, size))
    elif kind == 5:
        stiffness, up, down = 10 ** rng.uniform(-1, 1, 3)
        spring = np.append(0.0, rng.normal(size=rng.integers(0, 4)))
        model = Duhem(spring=spring, stiffness=stiffness, friction_up=up, friction_down=down)
    elif kind == 3:
        model = replace(draw(stops(idle=False)), rest_angle=0.0)
    else:
        model = replace(draw(hinged()), rest_angle=0.0, offset=0.0)
    if draw(st.booleans()):
        model = Asymmetric(model=model, polynomial=rng.normal(size=3).tolist())
    return model


@settings(max_examples=300, deadline=None)
@given(model=dissipative_models(), seed=st.integers(0, 2**32))
def test_no_random_reversals_break_a_certificate(model, seed):
    rng = np.random.default_rng(seed)
    assert is_safe(model, (-7.0, 7.0))
    p, kernels = model.parameter_vector.copy(), model.kernels
    inner = model.model if isinstance(model, Asymmetric) else model
    bound = inner.certificate((-7.0, 7.0)).torque_bound
    for _ in range(SEQUENCES):
        start = inner.start(0.0)
        if isinstance(inner, BoucWen | Duhem):  # any start that is covered
            other = inner.start(0.0, rng.uniform(-bound, bound))
            start = other if inner.start_is_certified(other) else start
        s = start.memory.copy()
        turns = np.clip(rng.normal(0, 10 ** rng.uniform(-2, 0.3), rng.integers(2, 25)), -7, 7)
        lost = kernels.dissipated(p, s, s[0], s[1], 0.0)
        for angle in turns:
            torque = kernels.commit(p, s, angle)
            assert abs(torque) <= bound * (1 + 1e-9)
            now = kernels.dissipated(p, s, s[0], s[1], 0.0)
            assert now >= lost - 1e-7 * bound
            lost = now
