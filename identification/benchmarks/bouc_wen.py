"""The Bouc-Wen benchmark of nonlinear system identification (Noel and Schoukens 2016).

    m y'' + c y' + k y + z = u
    z' = alpha y' - beta (gamma |y'| |z|^(nu-1) z + delta y' |z|^nu)

The official integrator is a protected file and its phases are not seeded, so that its signals can
be regenerated as a system but not number by number: here with Newmark's method at 15 kHz, a
low-pass filter down to 750 Hz and our own seed. `load_official` reads the official files.
"""

import math
import os
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.io import loadmat
from scipy.io.matlab import MatReadError
from scipy.optimize import least_squares
from scipy.signal import decimate

from ...arrays import Array
from ...errors import InputError
from .newmark_kernels import newmark

RATE = 750.0  # sampling rate [Hz]
UPSAMPLING = (2, 2, 5)  # the integration runs at their product times RATE
PERIOD = 8192  # samples of one period of the multisine
BAND = (5.0, 150.0)  # Hz
FORCE_STD = 50.0  # N
NOISE_STD = 8e-6  # noise of the estimation data [m]
SWEEP = (20.0, 50.0, 10.0 / 60.0)  # Hz, Hz, Hz/s
SWEEP_AMPLITUDE = 40.0  # N


@dataclass(frozen=True, kw_only=True)
class Oscillator:
    """The parameters that are identifiable from data: beta appears only in products.

    Attributes:
        mass: m [kg].
        damping: c [N s/m].
        stiffness: k [N/m].
        alpha: Slope of z at z = 0 [N/m].
        bend: beta gamma [1/m at nu = 1].
        skew: beta delta [1/m at nu = 1].
        nu: Sharpness.
    """

    mass: float = 2.0
    damping: float = 10.0
    stiffness: float = 5e4
    alpha: float = 5e4
    bend: float = 1e3 * 0.8
    skew: float = 1e3 * -1.1
    nu: float = 1.0

    def displacement(self, force: ArrayLike) -> Array:
        """Simulates from rest and filters down to 750 Hz.

        Args:
            force: u at 15 kHz [N], (samples,).

        Returns:
            y at 750 Hz [m], (samples / 20,). The filter looks about 0.04 s ahead: its end affects
            the last samples of a record.

        Raises:
            InputError: The mass is not above 0, or `force` is not one series.
        """
        u = np.ascontiguousarray(force, dtype=np.float64)
        if u.ndim != 1 or u.size < 2:
            raise InputError(f"the force has shape {u.shape}: use one series of 2 samples or more")
        if not self.mass > 0:
            raise InputError(f"mass is {self.mass} kg: it must be above 0")
        y = np.empty(u.size)
        dt = 1 / (RATE * math.prod(UPSAMPLING))
        newmark(
            self.mass,
            self.damping,
            self.stiffness,
            self.alpha,
            self.bend,
            self.skew,
            self.nu,
            dt,
            u,
            y,
        )
        for factor in UPSAMPLING:
            y = decimate(y, factor, ftype="fir")
        return y


@dataclass(frozen=True)
class Record:
    """Force [N] and displacement [m] at 750 Hz, (samples,) each."""

    force: Array
    displacement: Array


def multisine(*, periods: int = 5, rng: int | np.random.Generator | None = 0) -> Array:
    """Returns the force at 15 kHz: a sum of sines of 5 to 150 Hz with random phases [N].

    Args:
        periods: Number of periods, of 8192 samples at 750 Hz each.
        rng: Seed or generator of the phases.

    Raises:
        InputError: `periods` is below 1.
    """
    if periods < 1:
        raise InputError(f"periods is {periods}: use at least 1")
    samples = PERIOD * math.prod(UPSAMPLING)
    spectrum = np.zeros(samples // 2 + 1, dtype=np.complex128)
    first, last = math.ceil(BAND[0] * PERIOD / RATE), math.floor(BAND[1] * PERIOD / RATE)
    phases = np.random.default_rng(rng).random(last - first + 1) * 2 * np.pi
    spectrum[first : last + 1] = np.exp(1j * phases)
    period = np.fft.irfft(spectrum, samples)
    return np.tile(period * (FORCE_STD / period.std()), periods)


def sine_sweep() -> Array:
    """Returns the force of the second test at 15 kHz: 40 N, 20 to 50 Hz at 10 Hz/min [N]."""
    first, last, speed = SWEEP
    rate = RATE * math.prod(UPSAMPLING)
    time = np.arange(round((last - first) / speed * rate)) / rate
    return SWEEP_AMPLITUDE * np.sin(2 * np.pi * (first + 0.5 * speed * time) * time)


def record(
    force: Array, *, noise: float = 0.0, rng: int | np.random.Generator | None = None
) -> Record:
    """Returns the response of the true oscillator to a force at 15 kHz, sampled at 750 Hz.

    Args:
        force: Force u at 15 kHz [N], (samples,).
        noise: Standard deviation of noise added to y [m]; `NOISE_STD` in the estimation data.
        rng: Seed or generator of the noise.

    Raises:
        InputError: `force` is not one series.
    """
    y = Oscillator().displacement(force)
    y = y + noise * np.random.default_rng(rng).standard_normal(y.size)
    return Record(np.asarray(force)[:: math.prod(UPSAMPLING)], y)


def steady_multisine(
    *, periods: int = 1, noise: float = 0.0, rng: int | np.random.Generator | None = 0
) -> Record:
    """Returns periods of the multisine in steady state: the first and the last are dropped.

    Args:
        periods: Number of periods that are kept.
        noise: Standard deviation of noise added to y [m].
        rng: Seed or generator of phases and noise.

    Raises:
        InputError: `periods` is below 1.
    """
    if periods < 1:
        raise InputError(f"periods is {periods}: use at least 1")
    generator = np.random.default_rng(rng)
    whole = record(multisine(periods=periods + 2, rng=generator), noise=noise, rng=generator)
    kept = slice(PERIOD, -PERIOD)
    return Record(whole.force[kept], whole.displacement[kept])


def figure_of_merit(error: ArrayLike) -> float:
    """Returns the benchmark's figure of merit: the RMS of an error in meters, in dB re 1 m."""
    rms = float(np.sqrt(np.mean(np.square(np.asarray(error, dtype=np.float64)))))
    return 20 * math.log10(rms) if rms > 0 else -math.inf


def refit(force: Array, displacement: Array, *, start: Oscillator, skipped: int = 0) -> Oscillator:
    """Fits all seven parameters by least squares of the simulated displacement.

    Args:
        force: u at 15 kHz [N], (20 samples,).
        displacement: y at 750 Hz [m], (samples,).
        start: First guess; every parameter keeps its sign.
        skipped: Number of last samples left out, which the filter's end affects.

    Raises:
        InputError: The two series do not belong together, or a parameter of `start` is 0.
    """
    if displacement.size * math.prod(UPSAMPLING) != force.size:
        raise InputError(
            f"force has {force.size} samples and displacement {displacement.size}: use 20 at "
            "15 kHz for each at 750 Hz"
        )
    scale = np.array(astuple(start))
    if not (scale != 0).all():
        raise InputError(f"start is {start}: give a guess other than 0 for every parameter")
    kept = slice(0, displacement.size - skipped)
    unit = displacement[kept].std()

    def residual(ratio: Array) -> Array:
        y = _oscillator(scale * np.exp(ratio)).displacement(force)
        return np.nan_to_num((y - displacement)[kept] / unit, nan=1e6, posinf=1e6, neginf=-1e6)

    found = least_squares(residual, np.zeros(scale.size), diff_step=1e-6, xtol=1e-10, max_nfev=40)
    return _oscillator(scale * np.exp(found.x))


def _oscillator(values: Array) -> Oscillator:
    names = Oscillator.__dataclass_fields__
    return Oscillator(**{name: float(value) for name, value in zip(names, values, strict=True)})


def load_official(force: str | os.PathLike[str], displacement: str | os.PathLike[str]) -> Record:
    """Loads a pair of the official files, such as uval_multisine.mat and yval_multisine.mat.

    Raises:
        InputError: A file is missing, is no MATLAB file or does not contain exactly one series, or
            the two are not as long.
    """
    u, y = _series(force), _series(displacement)
    if u.size != y.size:
        raise InputError(
            f"{os.fspath(force)!r} has {u.size} samples and {os.fspath(displacement)!r} {y.size}: "
            "give the u and y of the same test"
        )
    return Record(u, y)


def _series(path: str | os.PathLike[str]) -> Array:
    name = os.fspath(path)
    if not Path(path).is_file():
        raise InputError(f"there is no file {name!r}: give a .mat file of the Bouc-Wen benchmark")
    try:
        content = loadmat(name)
    except (MatReadError, ValueError, TypeError, NotImplementedError, OSError) as error:
        raise InputError(
            f"{name!r} is not a MATLAB file that can be read: give a .mat file of the Bouc-Wen "
            "benchmark, of version 7 or older"
        ) from error
    found = [
        np.asarray(value)
        for key, value in content.items()
        if not key.startswith("__") and np.asarray(value).dtype.kind in "fiu"
    ]
    if len(found) != 1 or found[0].size < 2 or found[0].size != max(found[0].shape):
        shapes = ", ".join(str(value.shape) for value in found) or "no numbers"
        raise InputError(f"{name!r} holds {shapes}: it must hold exactly one series of numbers")
    return found[0].astype(np.float64).ravel()
