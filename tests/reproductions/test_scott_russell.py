"""The piezo mechanism: published sets, exact steps, and its identification."""

import math

import numpy as np
import pytest
from activesuit.hysteresis import BoucWen
from activesuit.reproductions import scott_russell as mechanism
from activesuit.reproductions.dispatch import METHODS
from activesuit.reproductions.scott_russell import FIRST_SAMPLE, TABLE_2, simulate, steady_cycle

TRUTH = np.array(mechanism.TRUTH)

# Set, f_n [Hz], zeta, range and stroke of x from 0.15 to 0.5 s with h(0) = 0 [um].
PUBLISHED = [
    (("n = 1", "rank-distance-mpso"), 32.1, 1.393, 1.49, 8.94, 7.44),
    (("n = 1", "pso"), 33.7, 1.415, 1.41, 9.05, 7.64),
    (("n free", "rank-distance-mpso"), 32.1, 1.376, 1.36, 9.04, 7.68),
    (("n free", "pso"), 33.8, 1.369, 1.35, 9.08, 7.73),
]


@pytest.mark.parametrize(("key", "f_n", "zeta", "low", "high", "stroke"), PUBLISHED)
def test_published_sets(key, f_n, zeta, low, high, stroke):
    x = simulate([TABLE_2[key]])[0, FIRST_SAMPLE:] * 1e6
    assert [x.min(), x.max(), np.ptp(x)] == pytest.approx([low, high, stroke], abs=0.006)
    assert steady_cycle(TABLE_2[key])[0] == pytest.approx(f_n, abs=0.06)
    assert steady_cycle(TABLE_2[key])[1] == pytest.approx(zeta, abs=6e-4)


def test_steady_cycle_and_saturation():
    *_, h_sat, low, high = steady_cycle(TRUTH)
    assert [low, high] == pytest.approx([1.489e-6, 8.913e-6], abs=1e-9)
    assert h_sat == pytest.approx(7.47, abs=0.005)


def test_initial_h_matters():
    from_zero, ramped = (simulate([TRUTH], initial_h=h)[0, 150:] for h in (0.0, 3.739))
    assert np.abs(from_zero - ramped).max() == pytest.approx(0.315e-6, abs=0.003e-6)


def test_literal_equation_is_dimensionally_wrong():
    *_, d_e, alpha, beta, gamma = TRUTH
    literal = BoucWen(elastic=d_e, hysteretic=-1.0, A=alpha, beta=beta, gamma=gamma, n=1)
    x = literal.response(mechanism.voltage(np.linspace(0, 0.5, 501)))
    assert np.ptp(x) > 1  # meters


def test_converged_at_one_millisecond():
    coarse = simulate([TRUTH])[0]
    fine = simulate([TRUTH], step=2e-5)[0, ::50]
    assert np.abs(coarse - fine).max() < 1e-5 * fine.max()


@pytest.mark.parametrize("n", [1.0, 1.4])
def test_same_hysteresis_as_the_library(n):
    m, c, k, d_e, alpha, beta, gamma = TRUTH
    scale = d_e ** (1 - n)  # h of the library is in meters
    model = BoucWen(
        elastic=k * d_e,
        hysteretic=-k,
        A=alpha * d_e,
        beta=beta * scale,
        gamma=gamma * scale,
        n=n,
    )
    step = 1e-4
    x = simulate([[*TRUTH, n]], step=step)[0]
    V = mechanism.voltage(step * np.arange(x.size))
    force = model.response(V, initial_torque=k * d_e * V[0])
    velocity = np.gradient(x, step)
    left = m * np.gradient(velocity, step) + c * velocity + k * x  # left side of eq. (2)
    # Later than 0.05 s, where the start's transient no longer outruns finite differences.
    np.testing.assert_allclose(left[500:-2], force[500:-2], rtol=0, atol=2e-6 * force.max())


def transcription(parameters, step, steps):
    """Classical RK4 of eq. (1) and (2), one set and one number at a time."""
    m, c, k, d_e, alpha, beta, gamma, n = parameters

    def rates(t, state):
        x, v, h = state
        V = 24 + 24 * math.sin(16 * math.pi * t)
        dV = 24 * 16 * math.pi * math.cos(16 * math.pi * t)
        dh = alpha * dV - beta * abs(dV) * math.copysign(abs(h) ** n, h) - gamma * dV * abs(h) ** n
        return np.array([v, (k * d_e * (V - h) - c * v - k * x) / m, dh])

    state, x = np.array([d_e * 24, 0.0, 0.0]), []
    for i in range(steps + 1):
        x.append(state[0])
        t = i * step
        k1 = rates(t, state)
        k2 = rates(t + step / 2, state + step / 2 * k1)
        k3 = rates(t + step / 2, state + step / 2 * k2)
        k4 = rates(t + step, state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.array(x)


@pytest.mark.parametrize("n", [1.0, 0.7, 1.5])
def test_kernel_is_classical_rk4(n):
    expected = transcription([*TRUTH, n], 1e-3, 200)
    np.testing.assert_allclose(simulate([[*TRUTH, n]], duration=0.2)[0], expected, rtol=1e-10)


def test_a_set_does_not_depend_on_the_others():
    rng = np.random.default_rng(0)
    rows = np.column_stack([TRUTH * rng.uniform(0.8, 1.2, (600, 7)), rng.uniform(0.8, 1.5, 600)])
    together = simulate(rows, duration=0.1)
    alone = np.concatenate([simulate(rows[i : i + 1], duration=0.1) for i in (0, 255, 256, 599)])
    np.testing.assert_allclose(together[[0, 255, 256, 599]], alone, rtol=1e-12)


def test_mass_cannot_be_identified():
    scaled = TRUTH * [2, 2, 2, 1, 1, 1, 1]
    np.testing.assert_allclose(simulate([scaled]), simulate([TRUTH]), rtol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_identification_reaches_the_noise(method):
    measured = mechanism.measurement(seed=1)
    sizes = {"swarm_size": 1000, "max_iterations": 100}
    fit = mechanism.identify_mechanism(measured, method, "n = 1", 2, **sizes)
    assert np.sqrt(fit.fun / measured.size) < 1.02 * mechanism.NOISE
    assert fit.fun == pytest.approx(mechanism.squared_errors([fit.x], measured)[0])
    strokes = [np.ptp(steady_cycle(x)[3:]) for x in (fit.x, TRUTH)]
    assert strokes[0] == pytest.approx(strokes[1], rel=0.01)


def test_free_exponent_and_seeds():
    measured = mechanism.measurement(seed=1)
    sizes = {"swarm_size": 50, "max_iterations": 5}
    first, again = (
        mechanism.identify_mechanism(measured, "pso", "n free", 3, **sizes) for _ in range(2)
    )
    np.testing.assert_array_equal(first.x, again.x)
    assert 0.5 <= first.x[7] <= 2


def test_the_noise_is_that_of_the_sensor():
    noise = mechanism.measurement(seed=5) - mechanism.measurement(seed=5, noise=0.0)
    assert np.std(noise) == pytest.approx(50e-9, rel=0.1)
