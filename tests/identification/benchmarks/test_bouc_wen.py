"""The regenerated Bouc-Wen benchmark: its level, its steady state, a refit, and official files."""

from dataclasses import astuple

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification.benchmarks import bouc_wen as benchmark
from activesuit.identification.benchmarks.bouc_wen import Oscillator, figure_of_merit
from activesuit.identification.benchmarks.newmark_kernels import newmark
from scipy.integrate import solve_ivp
from scipy.io import savemat

PUBLISHED_BEST = -98.32  # dB, PNLSS of degrees 3, 5, 7 with 217 parameters


@pytest.fixture(scope="module")
def steady():
    return benchmark.steady_multisine(periods=2)


def test_level_and_excitation(steady):
    assert figure_of_merit(steady.displacement) == pytest.approx(-63.59, abs=0.5)
    assert np.std(steady.displacement) == pytest.approx(6.613e-4, rel=0.05)
    assert steady.force.size == steady.displacement.size == 2 * benchmark.PERIOD
    assert np.std(steady.force) == pytest.approx(benchmark.FORCE_STD, rel=1e-3)
    power = np.abs(np.fft.rfft(steady.force[: benchmark.PERIOD])) ** 2
    frequency = np.fft.rfftfreq(benchmark.PERIOD, 1 / benchmark.RATE)
    inside = (frequency >= 5) & (frequency <= 150)
    assert power[inside].min() > 1e12 * power[~inside].max()
    np.testing.assert_allclose(power[inside], power[inside][0], rtol=1e-9)


def test_steady_state_is_periodic(steady):
    first, second = np.split(steady.displacement, 2)
    assert figure_of_merit(second - first) < -200


def test_seed_fixes_phases_and_noise():
    first, again = (benchmark.steady_multisine(noise=8e-6, rng=3) for _ in range(2))
    np.testing.assert_array_equal(first.displacement, again.displacement)
    clean = benchmark.steady_multisine(rng=3)
    noise = first.displacement - clean.displacement
    # 8192 samples tell a standard deviation within 0.07 dB.
    assert figure_of_merit(noise) == pytest.approx(figure_of_merit([8e-6]), abs=0.3)
    other = benchmark.steady_multisine(rng=4)
    assert not np.array_equal(other.displacement, clean.displacement)


def newmark_response(plant, time):
    y = np.empty(time.size)
    u = 80 * np.sin(2 * np.pi * 30 * time)
    newmark(*astuple(plant), time[1], u, y)
    return y


@pytest.mark.parametrize("nu", [1.0, 1.5])
def test_newmark_converges_to_the_equations_at_second_order(nu):
    plant = Oscillator(nu=nu)
    time = np.arange(6000) / 15_000

    def rates(t, state):
        y, v, z = state
        force = 80 * np.sin(2 * np.pi * 30 * t)
        loss = plant.bend * abs(v) * abs(z) ** (nu - 1) * z + plant.skew * v * abs(z) ** nu
        acceleration = (force - plant.damping * v - plant.stiffness * y - z) / plant.mass
        return [v, acceleration, plant.alpha * v - loss]

    exact = solve_ivp(
        rates, (0, time[-1]), [0, 0, 0], "DOP853", t_eval=time, rtol=1e-10, atol=1e-12
    ).y[0]
    coarse = newmark_response(plant, time) - exact
    fine = newmark_response(plant, np.arange(12_000) / 30_000)[::2] - exact
    # The method's period is too long by (w dt)^2 / 12, which adds up over the record.
    w = np.sqrt((plant.stiffness + plant.alpha) / plant.mass)
    phase_error = w * time[-1] * (w * time[1]) ** 2 / 12
    assert np.abs(coarse).max() < phase_error * np.abs(exact).max()
    assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(4, rel=0.1)


def test_filter_passes_the_band():
    # Below 150 Hz the low-pass filters change the oscillator's displacement by less than 1 %.
    time = np.arange(60_000) / 15_000
    y = Oscillator().displacement(80 * np.sin(2 * np.pi * 30 * time))
    raw = newmark_response(Oscillator(), time)[::20]
    assert np.abs(y - raw)[100:-100].max() < 0.01 * np.abs(raw).max()


def test_white_box_refit_beats_the_published_black_boxes():
    force = benchmark.multisine(periods=1, rng=5)
    noisy = benchmark.record(force, noise=benchmark.NOISE_STD, rng=6).displacement
    start = Oscillator(
        mass=1.7, damping=14.0, stiffness=6e4, alpha=4e4, bend=500.0, skew=-800.0, nu=1.2
    )
    found = benchmark.refit(force, noisy, start=start, skipped=200)
    for name, tolerance in {"mass": 1e-3, "stiffness": 1e-3, "bend": 0.02, "nu": 5e-3}.items():
        assert getattr(found, name) == pytest.approx(getattr(Oscillator(), name), rel=tolerance)
    unseen = benchmark.multisine(periods=3, rng=77)
    error = found.displacement(unseen) - Oscillator().displacement(unseen)
    assert figure_of_merit(error[benchmark.PERIOD : -benchmark.PERIOD]) < PUBLISHED_BEST
    sweep = benchmark.sine_sweep()
    error = found.displacement(sweep) - Oscillator().displacement(sweep)
    assert figure_of_merit(error) < PUBLISHED_BEST


def test_figure_of_merit():
    assert figure_of_merit([1e-3, -1e-3]) == pytest.approx(-60)
    assert figure_of_merit([0.0]) == -np.inf


def test_official_files(tmp_path):
    u, y = tmp_path / "uval_multisine.mat", tmp_path / "yval_multisine.mat"
    savemat(u, {"uval_multisine": np.arange(5.0)[None]})
    savemat(y, {"yval_multisine": np.arange(5.0)[None] * 1e-3})
    loaded = benchmark.load_official(u, y)
    np.testing.assert_array_equal(loaded.force, np.arange(5.0))
    np.testing.assert_array_equal(loaded.displacement, np.arange(5.0) * 1e-3)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "there is no file"),
        (b"time,force\n1,2\n", "is not a MATLAB file that can be read"),
        (b"", "is not a MATLAB file that can be read"),
        ({"a": np.ones(4), "b": np.ones(4)}, r"holds \(1, 4\), \(1, 4\): it must hold exactly one"),
        ({"a": np.ones((3, 4))}, r"holds \(3, 4\): it must hold exactly one series"),
        ({"a": np.ones(3)}, "has 3 samples and"),
    ],
)
def test_bad_official_files(tmp_path, content, message):
    u, y = tmp_path / "u.mat", tmp_path / "y.mat"
    savemat(y, {"y": np.ones(4)})
    if isinstance(content, dict):
        savemat(u, content)
    elif content is not None:
        u.write_bytes(content)
    with pytest.raises(InputError, match=message):
        benchmark.load_official(u, y)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: benchmark.multisine(periods=0), "periods is 0"),
        (lambda: benchmark.steady_multisine(periods=0), "periods is 0"),
        (lambda: Oscillator().displacement(np.ones((2, 3))), r"force has shape \(2, 3\)"),
        (lambda: Oscillator(mass=0.0).displacement(np.ones(100)), "mass is 0.0 kg"),
        (
            lambda: benchmark.refit(np.ones(10), np.ones(10), start=Oscillator()),
            "force has 10 samples and displacement 10",
        ),
        (
            lambda: benchmark.refit(np.ones(40), np.ones(2), start=Oscillator(damping=0.0)),
            "a guess other than 0",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
