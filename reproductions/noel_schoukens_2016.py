"""The Bouc-Wen benchmark of Noel and Schoukens (2016), fitted with its own equations.

    python -m activesuit.reproductions.noel_schoukens_2016

    m y'' + c y' + k y + z = u
    z' = alpha y' - beta (gamma |y'| |z|^(nu-1) z + delta y' |z|^nu)

The official integrator is a protected file and its phases are not seeded, so that its signals can
be regenerated as a system but not number by number: here with Newmark's method at 15 kHz, a
low-pass filter down to 750 Hz and our own seed.
"""

import math
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import decimate

from ..arrays import Array
from .newmark_kernels import newmark
from .results import Results, panels, run

# The parameters that are identifiable from data; beta appears only in products.
NAMES = ("m [kg]", "c [N s/m]", "k [N/m]", "alpha [N/m]", "beta gamma", "beta delta", "nu")
TRUTH = (2.0, 10.0, 5e4, 5e4, 1e3 * 0.8, 1e3 * -1.1, 1.0)
START = (1.7, 14.0, 6e4, 4e4, 500.0, -800.0, 1.2)  # first guess of the fit
PUBLISHED = -98.32  # error of a polynomial state-space model with 217 parameters, multisine [dB]

RATE = 750.0  # sampling rate [Hz]
UPSAMPLING = (2, 2, 5)  # the integration runs at their product times RATE
FINE = RATE * math.prod(UPSAMPLING)
PERIOD = 8192  # samples of one period of the multisine
BAND = (5.0, 150.0)  # Hz
FORCE_STD = 50.0  # N
NOISE_STD = 8e-6  # noise of the estimation data [m]
OUT = Path("runs/noel_schoukens_2016")
SKIPPED = 200  # last samples, which the end of the filter affects


def displacement(parameters: Array | tuple[float, ...], force: Array) -> Array:
    """Returns y at 750 Hz [m] under u at 15 kHz [N], from rest, through the filter."""
    y = np.empty(force.size)
    m, c, k, alpha, bend, skew, nu = map(float, parameters)
    newmark(m, c, k, alpha, bend, skew, nu, 1 / FINE, force, y)
    for factor in UPSAMPLING:
        y = decimate(y, factor, ftype="fir")
    return y


def multisine(*, periods: int, seed: int) -> Array:
    """Returns the force at 15 kHz: a sum of sines of 5 to 150 Hz with random phases [N]."""
    samples = PERIOD * math.prod(UPSAMPLING)
    spectrum = np.zeros(samples // 2 + 1, dtype=np.complex128)
    first, last = math.ceil(BAND[0] * PERIOD / RATE), math.floor(BAND[1] * PERIOD / RATE)
    phases = np.random.default_rng(seed).random(last - first + 1) * 2 * np.pi
    spectrum[first : last + 1] = np.exp(1j * phases)
    period = np.fft.irfft(spectrum, samples)
    return np.tile(period * (FORCE_STD / period.std()), periods)


def sine_sweep() -> Array:
    """Returns the force of the second test at 15 kHz: 40 N, 20 to 50 Hz at 10 Hz/min [N]."""
    first, last, speed = 20.0, 50.0, 10.0 / 60.0
    time = np.arange(round((last - first) / speed * FINE)) / FINE
    return 40.0 * np.sin(2 * np.pi * (first + 0.5 * speed * time) * time)


def figure_of_merit(error: Array) -> float:
    """Returns the RMS of an error in meters, in dB re 1 m."""
    return 20 * math.log10(float(np.sqrt(np.mean(np.square(error)))))


def refit(force: Array, measured: Array) -> Array:
    """Fits all seven parameters, which keep their signs, by least squares of y, (7,)."""
    unit, start = measured[:-SKIPPED].std(), np.array(START)

    def residual(ratio: Array) -> Array:
        error = (displacement(start * np.exp(ratio), force) - measured)[:-SKIPPED] / unit
        return np.nan_to_num(error, nan=1e6, posinf=1e6, neginf=-1e6)

    found = least_squares(residual, np.zeros(7), diff_step=1e-6, xtol=1e-10, max_nfev=40)
    return start * np.exp(found.x)


def main(seed: int = 0, out: Path = OUT, page: Path | None = None) -> None:
    """Fit the Bouc-Wen benchmark with its own equations, and test the fit on unseen forces.

    Args:
        seed: Seed of phases and noise.
        out: Folder for the figure and tables.md.
        page: Page of the documentation that gets the tables between its marks.
    """
    results = Results(out)
    force = multisine(periods=1, seed=seed)
    clean = displacement(TRUTH, force)
    noise = NOISE_STD * np.random.default_rng([seed, 1]).standard_normal(clean.size)
    found = refit(force, clean + noise)
    tests = {"multisine": multisine(periods=3, seed=seed + 1), "sine sweep": sine_sweep()}
    figure, axes = panels([*tests], "|y| [m]", sharey=True)
    rows = []
    for ax, (name, unseen) in zip(axes, tests.items(), strict=True):
        inside = slice(PERIOD, -PERIOD) if name == "multisine" else slice(-SKIPPED)
        y = displacement(TRUTH, unseen)[inside]
        error = displacement(found, unseen)[inside] - y
        merits = [f"{figure_of_merit(one):.2f}" for one in (y, error)]
        rows.append([name, *merits, f"{PUBLISHED}" if name == "multisine" else "-"])
        for values, label in ((y, "displacement"), (error, "error of the fit")):
            ax.plot(np.arange(y.size) / RATE, np.abs(values) + 1e-12, lw=0.4, label=label)
        ax.set(yscale="log", ylim=(1e-9, 1e-1), xlabel="time [s]")
    axes[0].legend(frameon=False, loc="upper right")
    results.table(
        "Bouc-Wen benchmark: errors on unseen forces",
        "RMS in dB re 1 m. The printed error is that of a polynomial state-space model with 217 "
        "parameters on the official data. The fit has the true equations, and data and fit share "
        "an integrator here, so that nothing is said about the official data.",
        "force | displacement | error of the fit | printed error",
        rows,
        on_page=True,
    )
    note = f"From one period of the multisine with {NOISE_STD * 1e6:g} um of noise."
    rows = [[name, f"{a:g}", f"{b:.5g}"] for name, a, b in zip(NAMES, TRUTH, found, strict=True)]
    results.table("Bouc-Wen benchmark: parameters", note, "parameter | printed | fitted", rows)
    results.figures({"Unseen forces": figure})
    results.finish(page)


if __name__ == "__main__":
    run(main)
