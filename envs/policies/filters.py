"""Low-pass filters that policies share; all are exact for a value that stays during a period."""

import math

import numpy as np

from ...arrays import Array
from ..simulation.sensing import smoothing


class LowPass:
    """A first-order low-pass.

    Args:
        cutoff: Frequency at which the output is 3 dB lower [Hz], for all or for each component.
        dt: Period [s].
    """

    def __init__(self, cutoff: float | Array, dt: float) -> None:
        self._share = smoothing(cutoff, dt)

    def begin(self, value: Array) -> None:
        """Begins at rest at a value, any shape."""
        self._value = value.copy()

    def step(self, value: Array) -> Array:
        """Returns the filtered value after a period, the same shape."""
        self._value = self._value + self._share * (value - self._value)
        return self._value


class SecondOrderLowPass:
    """A critically damped low-pass of second order, which tells the rate of its output as well.

    Args:
        cutoff: Natural frequency [Hz], at which the output is 6 dB lower.
        dt: Period [s].
    """

    def __init__(self, cutoff: float, dt: float) -> None:
        self._pole, self._dt = math.tau * cutoff, dt

    def begin(self, value: Array) -> None:
        """Begins at rest at a value, any shape."""
        self._value, self._rate = value.copy(), np.zeros_like(value)

    def step(self, value: Array) -> tuple[Array, Array]:
        """Returns the filtered value after a period and its rate per second."""
        w, dt = self._pole, self._dt
        away = self._value - value
        drive = self._rate + w * away  # the solution is (away + drive t) exp(-w t)
        decay = math.exp(-w * dt)
        self._rate = (drive - w * (away + drive * dt)) * decay
        self._value = value + (away + drive * dt) * decay
        return self._value, self._rate
