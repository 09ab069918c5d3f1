"""The model against single relays, its memory and energy laws, and its borders."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from activesuit.benchmarks.references import reference_of
from activesuit.hysteresis import PoleError
from activesuit.hysteresis.preisach import kernels
from activesuit.hysteresis.preisach.model import Preisach
from activesuit.hysteresis.protocol import follow
from helpers import assert_refused, sweep
from hypothesis import given, settings
from hypothesis import strategies as st

angles = st.floats(-0.2, 2.2)
paths = st.lists(angles, min_size=2, max_size=25)
seeds = st.integers(0, 2**31)


def random_model(seed, segments=6):
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.2, 1, segments)
    levels = 2 * np.concatenate([[0], np.cumsum(steps) / steps.sum()])
    density = [rng.uniform(0, 2, i + 1) for i in range(segments)]
    return Preisach(levels=levels, density=density, elastic=rng.uniform(-2, 9, segments))


def uniform_model(elastic=5.0):
    """A density of 3 N·m per square radian on 0 to 2 rad."""
    density = [[0.75] * i + [0.375] for i in range(4)]
    return Preisach(levels=np.linspace(0, 2, 5), density=density, elastic=[elastic] * 4)


def relays(model, path, initial=0.0):
    """The torque of the readable model, whose relays are single patches of the half plane."""
    reference = reference_of(model, np.array(path), initial)
    with np.errstate(over="ignore"):  # where patches are as narrow as numbers can be
        return [initial, *(reference.move(angle) for angle in path[1:])]


def work(model, state, angle, turns=()):
    """Work of a motion, exactly: Simpson's rule on pieces along which the torque is quadratic."""
    low, high = sorted((state.angle, angle))
    pieces = sorted({low, high, *(x for x in (*model.levels, *turns) if low < x < high)})
    total = 0.0
    for a, b in pairwise(pieces):
        ends = [model.step(state, x)[1] for x in (a, (a + b) / 2, b)]
        total += (b - a) * (ends[0] + 4 * ends[1] + ends[2]) / 6
    return math.copysign(total, total * (angle - state.angle))


def ledger(model, path, initial=0.0):
    """Work, stored and dissipated energy after each motion of a path."""
    state, done = model.start(path[0], initial), 0.0
    rows = [(done, *model.energy(state))]
    for angle in path[1:]:
        done += work(model, state, angle, path)
        state, _ = model.step(state, angle)
        rows.append((done, *model.energy(state)))
    return np.array(rows).T


def balanced(model, path):
    """The dissipated energy along a path, on which work is stored or dissipated."""
    done, stored, dissipated = ledger(model, path, 0.7)
    np.testing.assert_allclose(done, stored - stored[0] + dissipated, atol=1e-11)
    assert np.diff(dissipated).min() >= -1e-13
    return dissipated


@given(path=paths, seed=seeds)
@settings(deadline=None, max_examples=30)
def test_agrees_with_single_relays(path, seed):
    model = random_model(seed)
    np.testing.assert_allclose(model.response(path, 0.7), relays(model, path, 0.7), atol=1e-11)
    balanced(model, path)


@given(path=paths, turn=angles, inner=st.lists(st.floats(0, 1), max_size=12), tail=paths)
@settings(deadline=None)
def test_a_closed_loop_leaves_no_trace(path, turn, inner, tail):
    model = random_model(4)
    loop = [min(max(path[-1] + x * (turn - path[-1]), -0.2), 2.2) for x in inner]
    loop = [min(max(x, min(path[-1], turn)), max(path[-1], turn)) for x in loop]
    plain = model.response([*path, turn, *tail])
    wiped = model.response([*path, turn, *loop, turn, *tail])
    assert plain[len(path) :].tolist() == wiped[len(path) + len(loop) + 1 :].tolist()


def test_uniform_density_in_closed_form():
    # E(alpha, beta) = weight (alpha - beta)^2 / 2, loss = weight (alpha - beta)^3 / 12.
    model = uniform_model()
    turn, back = 1.7, np.linspace(1.7, 0.0, 40)
    torque = model.response([0.0, turn, *back[1:]])[1:]
    expected = 5 * back - 3 / 2 * (turn**2 - (turn - back) ** 2)
    np.testing.assert_allclose(torque, expected, atol=1e-13)
    loss = ledger(model, [0.0, turn])[2]
    assert loss[1] == pytest.approx(3 * turn**3 / 12, rel=1e-13)


def assert_tangents(model, state):
    for way in (1e-8, -1e-8):
        slope = (model.step(state, state.angle + way)[1] - state.torque) / way
        assert model.tangent(state, way) == pytest.approx(slope, abs=1e-4)


def test_tangent_is_the_slope_on_levels():
    model = random_model(3)
    for last in (0.9, model.levels[0], model.levels[3], model.levels[-1]):
        assert_tangents(model, follow(model, model.start(0.1), (1.7, 0.3, 1.2, last)))


def test_deeper_loops_than_the_stack_holds():
    model = random_model(8)
    path = [0.0, *(x for k in range(60) for x in (1.9 - 0.01 * k, 0.1 + 0.01 * k))]
    balanced(model, path)
    state = model.start(0.0)
    for angle in path[1:]:
        state, _ = model.step(state, angle)
    assert state.memory[kernels.COUNT] == kernels.CAPACITY
    np.testing.assert_allclose(model.response(path)[:64], relays(model, path)[:64], atol=1e-12)
    # Continuous on the way out, and right again outside the loop that was not remembered.
    for out in (sweep(path[-1], 2.1, samples=20_000), sweep(path[-1], -0.1, samples=20_000)):
        torque = model.response([*path[:-1], *out])[len(path) - 1 :]
        assert np.abs(np.diff(torque)).max() < 40 * abs(out[1] - out[0])
        end = [*path, out[-1], 1.0]
        assert model.response(end)[-1] == pytest.approx(relays(model, end)[-1], abs=1e-12)
        balanced(model, end)
    assert_tangents(model, state)


def test_jumps_far_outside_the_levels():
    model = random_model(9)
    first, last = model.elastic[0], model.elastic[-1]
    torque = model.response([0.5, 1e9, 2.5, -1e9, -0.5, 3.0, 2.5])
    assert torque[1] - torque[2] == pytest.approx(last * (1e9 - 2.5), rel=1e-12)
    assert torque[4] - torque[3] == pytest.approx(first * (1e9 - 0.5), rel=1e-12)
    assert torque[6] == torque[2]
    flat = replace(model, elastic=())
    torque = flat.response([-1.0, 1e300, -1e300, 1.0])
    assert torque[1] == pytest.approx(-sum(map(sum, flat.density)), rel=1e-14)
    assert torque[2] == 0.0
    with pytest.raises(PoleError, match="infinite"):
        model.response([0.0, 1.7e308])


def test_garbage_in_the_memory_stays_inside():
    for count in [-5.0, 3.7, 64, 65, 1e300, math.nan, math.inf, -math.inf]:
        model = random_model(1)
        rng = np.random.default_rng(0)
        for junk in (rng.uniform(-1, 3, 400), rng.normal(0, 1e200, 400), np.full(400, math.nan)):
            guarded = np.full(kernels.MEMORY_SIZE + 200, 12345.0)
            s = guarded[100:-100]
            s[:] = junk[: s.size]
            s[kernels.COUNT] = count
            p = model.parameter_vector.copy()
            for angle in rng.uniform(-1, 3, 200):
                kernels.move(p, s, angle)
                kernels.stiffness(p, s, angle, 0.0, rng.choice([-1.0, 1.0]))
                kernels.stored(p, s, angle, 0.0, 0.0)
                kernels.commit(p, s, angle)
            assert (guarded[:100] == 12345).all()
            assert (guarded[-100:] == 12345).all()


def test_certificate():
    model = uniform_model()
    assert model.certificate().torque_bound == math.inf
    assert model.certificate((0, 2)).torque_bound == pytest.approx(5 * 2 + 3 * 2**2 / 2)
    # Relays that go up between 0.5 and 1 rad, wherever they go down.
    assert model.certificate((0.5, 1)).torque_bound == pytest.approx(5 / 2 + 3 * (1 - 0.5**2) / 2)
    free = Preisach(levels=[0, 1], density=[[2]])
    assert free.certificate().torque_bound == 2
    assert not Preisach(levels=[0, 1], density=[[-2]]).certificate().dissipative


def test_bad_parameters():
    good = {"levels": [0, 1, 2], "density": [[1], [1, 1]], "elastic": [1, 1]}
    rows = [
        ({"levels": [1.0]}, "give at least 2 angles"),
        ({"levels": [0, 1, 1]}, r"levels is \(0\.0, 1\.0, 1\.0\) rad: give increasing numbers"),
        ({"levels": [0, 1, math.nan]}, r"levels\[2\] is nan: give finite numbers"),
        ({"levels": "012"}, "levels is '012': give at least one number"),
        ({"density": [[1]]}, r"density is \(\(1\.0,\),\) N·m: give 2 rows, one for each"),
        ({"density": [[1], [1]]}, r"density\[1\] has 1 numbers: give 2"),
        ({"density": [[1], [1, "x"]]}, r"density\[1\] is \[1, 'x'\]: give at least one number"),
        ({"elastic": [1]}, "elastic is .* N·m/rad: give as many numbers"),
    ]
    assert_refused(lambda change: Preisach(**(good | change)), rows)
