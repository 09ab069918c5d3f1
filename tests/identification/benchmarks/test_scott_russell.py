"""The piezo mechanism: published sets, exact steps, kinematics, and its identification."""

import math

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen
from activesuit.identification.benchmarks import scott_russell as mechanism
from activesuit.identification.benchmarks import scott_russell_fit as fitting
from activesuit.identification.benchmarks.scott_russell import simulate, steady_cycle
from activesuit.identification.optimizers.registry import KAO_FUNG_SWARMS
from activesuit.published import KAO_TABLE_2

TRUTH = np.array(fitting.TRUTH)

# Set, f_n [Hz], zeta, range and stroke of x from 0.15 to 0.5 s with h(0) = 0 [um].
PUBLISHED = [
    (("n = 1", "mpso"), 32.1, 1.393, 1.49, 8.94, 7.44),
    (("n = 1", "pso"), 33.7, 1.415, 1.41, 9.05, 7.64),
    (("n free", "mpso"), 32.1, 1.376, 1.36, 9.04, 7.68),
    (("n free", "pso"), 33.8, 1.369, 1.35, 9.08, 7.73),
]


@pytest.mark.parametrize(("key", "f_n", "zeta", "low", "high", "stroke"), PUBLISHED)
def test_published_sets(key, f_n, zeta, low, high, stroke):
    x = simulate([KAO_TABLE_2[key]])[0, fitting.FIRST_SAMPLE :] * 1e6
    assert x.min() == pytest.approx(low, abs=0.006)
    assert x.max() == pytest.approx(high, abs=0.006)
    assert np.ptp(x) == pytest.approx(stroke, abs=0.006)
    cycle = steady_cycle(KAO_TABLE_2[key])
    assert cycle.natural_frequency == pytest.approx(f_n, abs=0.06)
    assert cycle.damping_ratio == pytest.approx(zeta, abs=6e-4)


def test_steady_cycle_and_saturation():
    cycle = steady_cycle(TRUTH)
    assert cycle.low == pytest.approx(1.489e-6, abs=1e-9)
    assert cycle.high == pytest.approx(8.913e-6, abs=1e-9)
    assert cycle.stroke == cycle.high - cycle.low
    assert cycle.saturation == pytest.approx(7.47, abs=0.005)


def test_initial_h_matters():
    from_zero, ramped = (simulate([TRUTH], initial_h=h)[0, 150:] for h in (0.0, 3.739))
    assert np.abs(from_zero - ramped).max() == pytest.approx(0.315e-6, abs=0.003e-6)


def test_literal_equation_is_dimensionally_wrong():
    literal = BoucWen.from_kao_fung(
        k=1.0, d_e=TRUTH[3], alpha=TRUTH[4], beta=TRUTH[5], gamma=TRUTH[6], literal=True
    )
    x = literal.response(mechanism.voltage(np.linspace(0, 0.5, 501)))
    assert np.ptp(x) > 1  # meters


def test_converged_at_one_millisecond():
    coarse = simulate([TRUTH])[0]
    fine = simulate([TRUTH], step=2e-5)[0, ::50]
    assert coarse[-1] == pytest.approx(fine[-1], rel=1e-5)
    assert np.abs(coarse - fine).max() < 1e-5 * fine.max()


@pytest.mark.parametrize("n", [1.0, 1.4])
def test_same_hysteresis_as_the_library(n):
    m, c, k, d_e, alpha, beta, gamma = TRUTH
    scale = d_e ** (1 - n)  # h of the library is in meters
    model = BoucWen.from_kao_fung(
        k=k, d_e=d_e, alpha=alpha, beta=beta * scale, gamma=gamma * scale, n=n
    )
    step = 1e-4
    x = simulate([[*TRUTH, n]], step=step)[0]
    V = mechanism.voltage(mechanism.time_points(step=step))
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
    parameters = [*TRUTH, n]
    expected = transcription(parameters, 1e-3, 200)
    np.testing.assert_allclose(simulate([parameters], duration=0.2)[0], expected, rtol=1e-10)


def test_population_does_not_depend_on_blocks_or_workers():
    rng = np.random.default_rng(0)
    rows = np.column_stack([TRUTH * rng.uniform(0.8, 1.2, (600, 7)), rng.uniform(0.8, 1.5, 600)])
    together = simulate(rows, workers=2, duration=0.1)
    np.testing.assert_array_equal(together, simulate(rows, duration=0.1))
    alone = np.concatenate([simulate(rows[i : i + 1], duration=0.1) for i in (0, 255, 256, 599)])
    np.testing.assert_allclose(together[[0, 255, 256, 599]], alone, rtol=1e-12)
    assert together.shape == (600, 101)


def test_kinematics_of_figure_2():
    length, angle = 0.03, 0.4
    A = length * np.array([math.cos(angle), math.sin(angle)])
    B, D = np.array([0, 2 * A[1]]), np.array([2 * A[0], 0])
    for joint in (B, D):
        assert np.linalg.norm(joint - A) == pytest.approx(length)
    small = mechanism.output_displacement(1e-7, length=length, angle=angle)
    assert small == pytest.approx(-1e-7 * math.tan(angle), rel=1e-4)
    moved = mechanism.output_displacement([2e-3, -2e-3], length=length, angle=angle)
    # The rod BD keeps its length.
    np.testing.assert_allclose(
        np.hypot(D[0] + moved, B[1] + np.array([2e-3, -2e-3])), 2 * length, rtol=1e-12
    )


def test_mass_cannot_be_identified():
    scaled = TRUTH * [2, 2, 2, 1, 1, 1, 1]
    np.testing.assert_allclose(simulate([scaled]), simulate([TRUTH]), rtol=1e-12)


@pytest.mark.parametrize("method", KAO_FUNG_SWARMS)
def test_identification_reaches_the_noise(method):
    measurement = fitting.regenerate(noise=50e-9, rng=1)
    fit = fitting.identify_mechanism(measurement, method=method, population=1000, rng=2)
    assert fit.rms < 1.02 * 50e-9
    assert fit.sse == pytest.approx(np.sum(fit.error**2))
    assert fit.parameters[7] == 1
    assert fit.evaluations == 1000 * 101
    assert (np.diff(fit.history) <= 0).all()
    cycle, truth = steady_cycle(fit.parameters), steady_cycle(TRUTH)
    assert cycle.stroke == pytest.approx(truth.stroke, rel=0.01)


def test_free_exponent_and_seeds():
    measurement = fitting.regenerate(rng=1)
    options = {"free_exponent": True, "population": 50, "iterations": 5, "rng": 3}
    first, again = (fitting.identify_mechanism(measurement, **options) for _ in range(2))
    np.testing.assert_array_equal(first.parameters, again.parameters)
    assert 0.5 <= first.parameters[7] <= 2
    assert first.parameters[7] != 1


def test_noise_is_seeded():
    first, again = (fitting.regenerate(noise=10e-9, rng=5) for _ in range(2))
    np.testing.assert_array_equal(first.displacement, again.displacement)
    clean = fitting.regenerate(noise=0.0)
    assert np.std(first.displacement - clean.displacement) == pytest.approx(10e-9, rel=0.1)
    assert fitting.squared_errors([TRUTH], clean)[0] == 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: simulate([TRUTH[:6]]), r"shape \(1, 6\): use \(sets, 7\)"),
        (lambda: simulate([-TRUTH]), "m is -0.1025 kg: it must be above 0"),
        (lambda: simulate([TRUTH], step=0.0), "step 0.0 s: use a step above 0"),
        (lambda: fitting.regenerate(noise=-1e-9), "noise is -1e-09 m"),
        (
            lambda: fitting.identify_mechanism(fitting.regenerate(rng=0), method="mpso"),
            "unknown method 'mpso': use one of pso, rank-distance-mpso",
        ),
        (
            lambda: fitting.squared_errors(
                [TRUTH], fitting.Measurement(np.zeros(3), np.zeros(3), 0.0)
            ),
            "the measurement has 3 samples: use 351",
        ),
        (
            lambda: mechanism.output_displacement(0.0, length=0.03, angle=2.0),
            "angle 2.0 rad: use above 0 m, and between 0 and pi/2",
        ),
        (
            lambda: mechanism.output_displacement(0.1, length=0.03, angle=0.4),
            "point B is moved by up to 0.1 m: the links reach from",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
