"""Identification of the Scott-Russell mechanism by swarms, on data made by the model itself.

Kao and Fung (2009) do not publish their measurement. Ours is the mechanism with the parameters of
their Table 2 (MPSO, n = 1), measured by their gap sensor, whose stated precision is 10 to 100 nm.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...errors import InputError, unknown_name
from ...published import KAO_FIRST_TIME, KAO_ITERATIONS, KAO_POPULATION, KAO_TABLE_2
from ..optimizers.pso import KAO_FUNG
from ..optimizers.registry import KAO_FUNG_SWARMS
from .scott_russell import STEP, simulate, time_points

FIRST_SAMPLE = round(KAO_FIRST_TIME / STEP)
TRUTH = KAO_TABLE_2["n = 1", "mpso"]

# The paper prints no search box; this one is ours: about half to twice the values of Table 2, and
# more for gamma, whose unit changes with n.
BOUNDS = (
    (0.05, 0.2),
    (30.0, 120.0),
    (2000.0, 9000.0),
    (1e-7, 4e-7),
    (0.1, 0.4),
    (0.0025, 0.02),
    (0.01, 0.1),
    (0.5, 2.0),
)


@dataclass(frozen=True)
class Measurement:
    """Displacement of the mechanism's output under V = 24 + 24 sin(16 pi t).

    Attributes:
        time: Instants [s], (samples,).
        displacement: Displacement x as measured [m], (samples,).
        noise: Standard deviation of the noise in `displacement` [m].
    """

    time: Array
    displacement: Array
    noise: float


@dataclass(frozen=True)
class MechanismFit:
    """Result of one run of a swarm.

    Attributes:
        parameters: m, c, k, d_e, alpha, beta, gamma, n, (8,), in the units of
            `scott_russell.UNITS`.
        sse: Eq. (10), the sum of squared errors [m^2].
        rms: Root of the mean squared error [m].
        error: Difference of measured and simulated x, eq. (11) [m], (samples,).
        history: Best sum of squared errors before the first and after each iteration [m^2].
        evaluations: Number of simulated parameter sets.
    """

    parameters: Array
    sse: float
    rms: float
    error: Array
    history: Array
    evaluations: int


def regenerate(
    *, noise: float = 50e-9, rng: int | np.random.Generator | None = None
) -> Measurement:
    """Makes the measurement that the paper does not publish: `TRUTH`, from h = 0, with noise.

    Args:
        noise: Standard deviation of the sensor's noise [m]; the paper states 10 to 100 nm.
        rng: Seed or generator of the noise.

    Raises:
        InputError: `noise` is negative.
    """
    if not 0 <= noise < np.inf:
        raise InputError(f"noise is {noise} m: use a finite number from 0, such as 50e-9")
    clean = simulate([TRUTH])[0, FIRST_SAMPLE:]
    drawn = np.random.default_rng(rng).standard_normal(clean.size)
    return Measurement(time_points()[FIRST_SAMPLE:], clean + noise * drawn, noise)


def squared_errors(parameters: ArrayLike, measurement: Measurement, *, workers: int = -1) -> Array:
    """Returns eq. (10) of parameter sets, (sets, 7) or (sets, 8) -> (sets,) [m^2].

    Raises:
        InputError: `parameters` has another shape, or the measurement another length.
    """
    x = simulate(parameters, workers=workers)[:, FIRST_SAMPLE:]
    if x.shape[1] != measurement.displacement.size:
        raise InputError(
            f"the measurement has {measurement.displacement.size} samples: use {x.shape[1]}, "
            "0.15 to 0.5 s in steps of 1 ms"
        )
    error = measurement.displacement - x
    return np.einsum("ij,ij->i", error, error)


def identify_mechanism(
    measurement: Measurement,
    *,
    method: str = "rank-distance-mpso",
    free_exponent: bool = False,
    population: int = KAO_POPULATION,
    iterations: int = KAO_ITERATIONS,
    workers: int = -1,
    rng: int | np.random.Generator | None = None,
    callback: Callable[[OptimizeResult], None] | None = None,
) -> MechanismFit:
    """Identifies 7 parameters (n = 1), or 8, by eq. (10) within `BOUNDS`.

    Both methods use the paper's constants: w = 0.65, c1 = 0.7, c2 = 2.05.

    Args:
        measurement: Samples at 0.15 to 0.5 s, 1 ms apart.
        method: "pso" or "rank-distance-mpso".
        free_exponent: Whether n is identified too, or 1.
        population: Number of particles.
        iterations: Number of moves after the first evaluation.
        workers: Number of threads; -1 uses all cores. The result does not depend on it.
        rng: Seed or generator of all random numbers.
        callback: Function that gets the intermediate result after every iteration.

    Raises:
        InputError: The method is unknown, or a number is out of its range.
    """
    if method not in KAO_FUNG_SWARMS:
        raise unknown_name("method", method, KAO_FUNG_SWARMS)
    found = KAO_FUNG_SWARMS[method](
        lambda rows: squared_errors(rows, measurement, workers=workers),
        BOUNDS if free_exponent else BOUNDS[:7],
        swarm_size=population,
        max_iterations=iterations,
        rng=rng,
        callback=callback,
        **KAO_FUNG,
    )
    error = measurement.displacement - simulate([found.x])[0, FIRST_SAMPLE:]
    return MechanismFit(
        parameters=np.append(found.x, 1.0)[:8],
        sse=float(found.fun),
        rms=float(np.sqrt(np.mean(error**2))),
        error=error,
        history=found.history,
        evaluations=int(found.nfev),
    )
