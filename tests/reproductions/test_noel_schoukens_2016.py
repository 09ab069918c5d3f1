"""The regenerated Bouc-Wen benchmark: its level, its equations, and a refit."""

import numpy as np
import pytest
from activesuit.reproductions import noel_schoukens_2016 as benchmark
from activesuit.reproductions.newmark_kernels import newmark
from activesuit.reproductions.noel_schoukens_2016 import TRUTH, displacement, figure_of_merit
from scipy.integrate import solve_ivp


def test_level_excitation_and_steady_state():
    force = benchmark.multisine(periods=4, seed=0)
    y = displacement(TRUTH, force)[benchmark.PERIOD : -benchmark.PERIOD]
    assert figure_of_merit(y) == pytest.approx(-63.59, abs=0.5)
    first, second = np.split(y, 2)
    assert np.abs(second - first).max() < 1e-10
    power = np.abs(np.fft.rfft(force[::20][: benchmark.PERIOD])) ** 2
    frequency = np.fft.rfftfreq(benchmark.PERIOD, 1 / benchmark.RATE)
    inside = (frequency >= 5) & (frequency <= 150)
    assert power[inside].min() > 1e12 * power[~inside].max()
    assert np.std(force) == pytest.approx(benchmark.FORCE_STD, rel=1e-9)


def newmark_response(parameters, time):
    y = np.empty(time.size)
    newmark(*map(float, parameters), time[1], 80 * np.sin(2 * np.pi * 30 * time), y)
    return y


@pytest.mark.parametrize("nu", [1.0, 1.5])
def test_newmark_converges_to_the_equations_at_second_order(nu):
    m, c, k, alpha, bend, skew, _ = TRUTH
    time = np.arange(6000) / 15_000

    def rates(t, state):
        y, v, z = state
        loss = bend * abs(v) * abs(z) ** (nu - 1) * z + skew * v * abs(z) ** nu
        return [v, (80 * np.sin(2 * np.pi * 30 * t) - c * v - k * y - z) / m, alpha * v - loss]

    exact = solve_ivp(
        rates, (0, time[-1]), [0, 0, 0], "DOP853", t_eval=time, rtol=1e-10, atol=1e-12
    ).y[0]
    parameters = (*TRUTH[:6], nu)
    coarse = newmark_response(parameters, time) - exact
    fine = newmark_response(parameters, np.arange(12_000) / 30_000)[::2] - exact
    # The method's period is too long by (w dt)^2 / 12, which adds up over the record.
    w = np.sqrt((k + alpha) / m)
    phase_error = w * time[-1] * (w * time[1]) ** 2 / 12
    assert np.abs(coarse).max() < phase_error * np.abs(exact).max()
    assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(4, rel=0.1)


def test_filter_passes_the_band():
    # Below 150 Hz the low-pass filters change the oscillator's displacement by less than 1 %.
    time = np.arange(60_000) / 15_000
    y = displacement(TRUTH, 80 * np.sin(2 * np.pi * 30 * time))
    raw = newmark_response(TRUTH, time)[::20]
    assert np.abs(y - raw)[100:-100].max() < 0.01 * np.abs(raw).max()


@pytest.mark.slow
def test_white_box_refit_beats_the_published_black_boxes():
    force = benchmark.multisine(periods=1, seed=5)
    clean = displacement(TRUTH, force)
    noise = benchmark.NOISE_STD * np.random.default_rng(6).standard_normal(clean.size)
    found = benchmark.refit(force, clean + noise)
    np.testing.assert_allclose(found, TRUTH, rtol=0.02)
    for unseen in (benchmark.multisine(periods=3, seed=77), benchmark.sine_sweep()):
        error = displacement(found, unseen) - displacement(TRUTH, unseen)
        assert figure_of_merit(error[benchmark.PERIOD : -benchmark.PERIOD]) < benchmark.PUBLISHED
