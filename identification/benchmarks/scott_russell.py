"""The Scott-Russell mechanism on a piezo actuator, of Kao and Fung (2009), sections 2 to 5.

Eq. (1) and (2) are read as

    h' = alpha V' - beta |V'| |h|^(n-1) h - gamma V' |h|^n,    m x'' + c x' + k x = k d_e (V - h)

with h in volts. In print the right side is k (d_e V - h), which adds meters to volts: literally,
the parameters of Table 2 swing x by 3.5 m instead of 7.4 um. For n = 1 this is the same as
`BoucWen.from_kao_fung`, where h is in the unit of d_e V; for other n, its beta and gamma are ours
times d_e^(1-n).

Only c/m and k/m move x: m cannot be identified from x, and Table 2's m, c, k mean f_n and zeta.
"""

import math
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import ArrayLike

from ...arrays import Array
from ...errors import InputError
from ...published import KAO_AMPLITUDE, KAO_DURATION, KAO_FREQUENCY, KAO_MEAN_VOLTAGE
from . import scott_russell_kernels as kernels

NAMES = ("m", "c", "k", "d_e", "alpha", "beta", "gamma", "n")
UNITS = ("kg", "N s/m", "N/m", "m/V", "", "1/V^n", "1/V^n", "")

STEP = 1e-3  # step [s]; one of 20 us changes x by less than 1e-5 of its peak
BLOCK = 256  # parameter sets whose state fits a core's first cache together


@dataclass(frozen=True)
class Cycle:
    """The steady cycle of x, and what the parameters mean.

    Attributes:
        low: Least x [m].
        high: Greatest x [m].
        natural_frequency: Frequency sqrt(k/m) / (2 pi) [Hz].
        damping_ratio: c / (2 sqrt(k m)).
        saturation: The h that no motion from below exceeds, (alpha / (beta + gamma))^(1/n) [V].
    """

    low: float
    high: float
    natural_frequency: float
    damping_ratio: float
    saturation: float

    @property
    def stroke(self) -> float:
        """Peak to peak [m]."""
        return self.high - self.low


def voltage(time: ArrayLike) -> Array:
    """Returns V = 24 + 24 sin(16 pi t) [V] of the paper's section 4.4."""
    return KAO_MEAN_VOLTAGE + KAO_AMPLITUDE * np.sin(
        2 * np.pi * KAO_FREQUENCY * np.asarray(time, dtype=np.float64)
    )


def voltage_rate(time: ArrayLike) -> Array:
    """Returns dV/dt [V/s] of `voltage`."""
    phase = 2 * np.pi * KAO_FREQUENCY * np.asarray(time, dtype=np.float64)
    return 2 * np.pi * KAO_FREQUENCY * KAO_AMPLITUDE * np.cos(phase)


def time_points(duration: float = KAO_DURATION, step: float = STEP) -> Array:
    """Returns the instants of `simulate`, 0 to `duration` [s].

    Raises:
        InputError: `step` or `duration` is not above 0, or there is less than one step.
    """
    if not (0 < step <= duration < math.inf):
        raise InputError(
            f"duration is {duration} s and step {step} s: use a step above 0 and at least one step"
        )
    return np.arange(round(duration / step) + 1, dtype=np.float64) * float(step)


def simulate(
    parameters: ArrayLike,
    *,
    duration: float = KAO_DURATION,
    step: float = STEP,
    initial_h: float = 0.0,
    workers: int = 1,
) -> Array:
    """Integrates eq. (1) and (2) by classical RK4 for many parameter sets, from rest at V(0).

    The paper does not say what h was at first, and it matters: h takes some 2 s to its limit cycle.
    From 0, the default, x differs by up to 0.32 um after 0.15 s from a start at 3.74 V, where a
    slow ramp of V from 0 to 24 V leaves h.

    Args:
        parameters: One row per set: m, c, k, d_e, alpha, beta, gamma and perhaps n (1 if left
            out), shape (sets, 7) or (sets, 8), in the units of `UNITS`.
        duration: End of the simulation [s].
        step: Time step of the integration and of the result [s].
        initial_h: h at t = 0 [V].
        workers: Number of threads; -1 uses all cores. The result does not depend on it.

    Returns:
        x at `time_points` [m], shape (sets, points).

    Raises:
        InputError: `parameters` has another shape, m is not above 0, or the times are wrong.
    """
    p = _columns(parameters)
    half = time_points(duration, step)
    half = 0.5 * step * np.arange(2 * half.size - 1)
    V, rate = voltage(half), voltage_rate(half)

    def block(start: int) -> Array:
        columns = np.ascontiguousarray(p[:, start : start + BLOCK])
        out = np.empty((half.size // 2 + 1, columns.shape[1]))
        linear = bool((columns[kernels.N] == 1).all())
        kernels.simulate(columns, V, rate, step, float(initial_h), linear, out)
        return out.T

    starts = range(0, p.shape[1], BLOCK)
    if workers == 1 or len(starts) == 1:
        blocks = [block(start) for start in starts]
    else:
        blocks = Parallel(n_jobs=workers, prefer="threads")(delayed(block)(i) for i in starts)
    return np.concatenate(blocks)  # pyright: ignore[reportArgumentType, reportCallIssue]


def _columns(parameters: ArrayLike) -> Array:
    rows = np.asarray(parameters, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] not in (7, 8) or len(rows) == 0:
        raise InputError(
            f"parameters have shape {rows.shape}: use (sets, 7), in the order "
            f"{', '.join(NAMES[:7])}, or (sets, 8) with n"
        )
    if not (rows[:, 0] > 0).all():
        raise InputError(f"m is {rows[:, 0].min():g} kg: it must be above 0")
    p = np.ones((8, len(rows)))
    p[: rows.shape[1]] = rows.T
    return p


def steady_cycle(parameters: ArrayLike, *, settle: float = 8.0) -> Cycle:
    """Returns the last period of x of one parameter set, shape (7,) or (8,).

    Args:
        parameters: One row, as `simulate` takes it.
        settle: Time to simulate [s].

    Raises:
        InputError: `simulate` refuses the parameters.
    """
    values = np.atleast_2d(np.asarray(parameters, dtype=np.float64))
    step = STEP / 5
    period = round(1 / (KAO_FREQUENCY * step))
    x = simulate(values, duration=settle, step=step)[0, -period:]
    m, c, k, _, alpha, beta, gamma, n = map(float, _columns(values)[:, 0])
    return Cycle(
        low=float(x.min()),
        high=float(x.max()),
        natural_frequency=math.sqrt(k / m) / (2 * math.pi),
        damping_ratio=c / (2 * math.sqrt(k * m)),
        saturation=(alpha / (beta + gamma)) ** (1 / n),
    )


def output_displacement(displacement: ArrayLike, *, length: float, angle: float) -> Array:
    """Returns how far point D moves along X when the actuator moves point B along Y [m].

    Figure 2 of the paper: the links AC and BD are joined at A, C is fixed at the origin and AB, AC
    and AD are all as long, so that B = (0, 2 L sin(theta)) and D = (2 L cos(theta), 0) for every
    angle theta of the link AC to X. For small moves the gain is -tan(theta).

    Args:
        displacement: Displacement of B, positive away from C [m].
        length: Length L of AB, AC and AD [m].
        angle: Initial theta, between 0 and pi/2 [rad].

    Raises:
        InputError: `length` or `angle` is out of range, or B moves beyond the reach of the links.
    """
    if not (0 < length < math.inf and 0 < angle < math.pi / 2):
        raise InputError(
            f"length is {length} m and angle {angle} rad: use above 0 m, and between 0 and pi/2 rad"
        )
    height = math.sin(angle) + np.asarray(displacement, dtype=np.float64) / (2 * length)
    if not (np.abs(height) <= 1).all():
        raise InputError(
            f"point B is moved by up to {np.abs(displacement).max():g} m: the links reach from "
            f"{-2 * length * (1 + math.sin(angle)):g} to {2 * length * (1 - math.sin(angle)):g} m"
        )
    return 2 * length * (np.sqrt(1 - height**2) - math.cos(angle))
