"""Smoothness of movements, after Balasubramanian et al. 2015, J. NeuroEng. Rehabil. 12:112."""

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ..provenance import Quantity

_SOURCE = "Balasubramanian et al. 2015, J. NeuroEng. Rehabil. 12:112"
_HIGHEST = Quantity("smoothness.highest_frequency", 10.0, "Hz", _SOURCE, "published")
_THRESHOLD = Quantity("smoothness.amplitude_threshold", 0.05, "1", _SOURCE, "published")
_PADDING = Quantity("smoothness.padding", 4.0, "1", f"{_SOURCE}; powers of two", "published")

PROVENANCE: tuple[Quantity, ...] = (_HIGHEST, _THRESHOLD, _PADDING)


def spectral_arc_length(speed: ArrayLike, dt: float) -> Array:
    """Returns the smoothness SPARC of a speed profile: negative, and nearer zero if smoother.

    SPARC is minus the length of the magnitude spectrum's curve, scaled to 1 in both directions, up
    to the last frequency below 10 Hz with 5 % of the largest magnitude. Cut the record to the
    movement, because rest before and after it changes the result.

    Args:
        speed: |rate| of a joint, or the norm of a velocity, shape (..., n), n >= 2.
        dt: Sampling period [s].

    Returns:
        The smoothness, shape (...); NaN where nothing moves.
    """
    speed = np.asarray(speed, dtype=float)
    size = 2 ** (int(np.ceil(np.log2(speed.shape[-1]))) + int(_PADDING.value))
    bins = int(_HIGHEST.value * size * dt * (1 + 1e-12)) + 1
    spectrum = np.abs(np.fft.rfft(speed, size))[..., :bins]
    with np.errstate(invalid="ignore"):
        spectrum /= spectrum.max(axis=-1, keepdims=True)
    bins = spectrum.shape[-1]
    last = bins - 1 - np.argmax(spectrum[..., ::-1] >= _THRESHOLD.value, axis=-1)[..., None]
    steps = np.hypot(1 / np.maximum(last, 1), np.diff(spectrum))
    return -np.sum(np.where(np.arange(bins - 1) < last, steps, 0), axis=-1)


def log_dimensionless_jerk(rate: ArrayLike, dt: float) -> Array:
    """Returns the smoothness LDLJ of a velocity: -log(T³ / peak² · ∫ jerk² dt), nearer zero better.

    A minimum-jerk movement has -log(204.8) = -5.32. Measured rates need a low-pass filter first:
    the second derivative raises their noise.

    Args:
        rate: Velocity or speed [rad/s], shape (..., n), n >= 3.
        dt: Sampling period [s].

    Returns:
        The smoothness, shape (...); NaN where nothing moves.
    """
    rate = np.asarray(rate, dtype=float)
    duration = (rate.shape[-1] - 1) * dt
    jerk = np.diff(rate, 2) / dt**2
    peak = np.abs(rate).max(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return -np.log(duration**4 * np.mean(jerk**2, axis=-1) / peak**2)
