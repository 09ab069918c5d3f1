"""The covariance of least squares under noise that is not white."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import matmul_toeplitz

from ...arrays import Array
from ..residual.noise import GRID, Noise

DEPENDENT = 1e-8  # relative size of a combination of coordinates that curves do not determine
UNLIKELY = 1e-3  # weight of a noise that is left out


def estimator_covariance(slopes: Array, noise: Noise, sizes: Sequence[int], scale: Array) -> Array:
    """Returns the covariance of least squares, which assume white noise, under any noise.

    With the pseudo-inverse P of the slopes and the covariance V of the noise it is P V P' (White
    1980, Econometrica 48, 817, for errors that are not alike), here averaged over the noises.

    Args:
        slopes: Derivatives of the torque with respect to the coordinates, shape (samples, p).
        noise: Noise of the torque.
        sizes: Number of samples of each curve.
        scale: Relative deviation of the noise of each sample, shape (samples,).
    """
    inverse = np.linalg.pinv(slopes, rcond=DEPENDENT).T * scale[:, None]
    parts = np.split(inverse, np.cumsum(sizes)[:-1])
    found, total = np.zeros((slopes.shape[1],) * 2), 0.0
    for weight, variance, (memory, white) in zip(noise.weight, noise.variance, GRID, strict=True):
        if weight < UNLIKELY:
            continue
        total += weight
        for part in parts:
            spread = white * part if memory else part
            if memory:
                slow = memory ** np.arange(len(part))
                spread = spread + (1 - white) * matmul_toeplitz(slow, part)
            found += weight * variance * part.T @ spread
    return found / total
