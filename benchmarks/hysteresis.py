"""The speed of the models' kernels, alone and against the usual integrators of Jiles-Atherton."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from ..hysteresis import TABLE_2, JilesAtherton, PrandtlIshlinskii, Preisach
from ..hysteresis.jiles_atherton import kernels
from ..hysteresis.jiles_atherton.langevin import langevin
from .timing import Row, compare, measure

RANGE = {"shoulder": (20.0, 70.0), "elbow": (30.0, 90.0)}  # [deg], the published curves
CYCLES, BRANCH = 50, 450
POPULATION = 64
BOX = np.array([[1, 100], [3, 5000], [-10, 10], [-10, 10], [1, 1000]])  # Table 1 of Li et al. 2022


@njit(error_model="numpy")
def textbook_langevin(x):
    """Returns L and L' as usually programmed: closed forms, and a series very near 0."""
    if abs(x) < 1e-3:
        return x / 3 - x * x * x / 45, 1 / 3 - x * x / 15
    if abs(x) > 300:
        return math.copysign(1.0, x) - 1 / x, 1 / (x * x)
    sinh = math.sinh(x)
    return 1 / math.tanh(x) - 1 / x, 1 / (x * x) - 1 / (sinh * sinh)


@njit(error_model="numpy")
def our_langevin(x):
    """Returns L and L' as this package computes them."""
    L, dL, _ = langevin(x)
    return L, dL


def _rk4(langevin: Callable) -> Callable[..., None]:
    """Returns the usual integrator of eq. (4): one classical Runge-Kutta step in H per sample."""

    @njit(error_model="numpy")
    def slope(H, M, delta, Ms, a, alpha, c, k):
        L, dL = langevin((H + alpha * M) / a)
        f = Ms * L - M + c * delta * k * Ms * dL / a
        return f / (delta * k - alpha * f)

    @njit(error_model="numpy")
    def response(H, Ms, a, alpha, c, k, M):
        M[0] = 0.0
        for i in range(1, H.size):
            h, m, x = H[i] - H[i - 1], M[i - 1], H[i - 1]
            if h != 0:
                delta = 1.0 if h > 0 else -1.0
                k1 = slope(x, m, delta, Ms, a, alpha, c, k)
                k2 = slope(x + h / 2, m + h / 2 * k1, delta, Ms, a, alpha, c, k)
                k3 = slope(x + h / 2, m + h / 2 * k2, delta, Ms, a, alpha, c, k)
                k4 = slope(x + h, m + h * k3, delta, Ms, a, alpha, c, k)
                m += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            M[i] = m

    return response


textbook_rk4 = _rk4(textbook_langevin)


def rows(repeats: int) -> list[Row]:
    """Times `response` of all models, and a population of Jiles-Atherton parameters."""
    textbook, ours = textbook_rk4, _rk4(our_langevin)
    found = []
    for name, model in TABLE_2.items():
        angle = _cycles(name, CYCLES)
        arguments = (angle, *model.parameter_vector[:5], np.empty_like(angle))
        for what, rk4, target in (("RK4 in H", textbook, 4.0), ("same, our Langevin", ours, None)):
            found.append(
                compare(
                    f"J-A {name} (error {_error(name, model):.0e} N·m)",
                    lambda model=model, angle=angle: model.response(angle),
                    what,
                    lambda rk4=rk4, arguments=arguments: rk4(*arguments),
                    repeats=repeats,
                    unit="ns/sample",
                    count=angle.size,
                    target=target,
                )
            )
    return [*found, *_against_scipy(repeats), _population(repeats), *_others(repeats)]


def _cycles(name: str, count: int) -> np.ndarray:
    low, high = np.radians(RANGE[name.partition("-")[0]])
    up = np.linspace(low, high, BRANCH)
    return np.tile(np.concatenate([up, up[::-1]]), count)


def _solved(model: JilesAtherton, turns: np.ndarray, rtol: float, samples: int) -> np.ndarray:
    """Returns the torque by SciPy's DOP853, in one call from each turn to the next."""
    Ms, a, alpha, c, k = model.parameter_vector[:5]
    torque = [np.zeros(1)]
    for start, end in pairwise(turns):
        delta = math.copysign(1.0, end - start)

        def slope(H, M, delta=delta):
            L, dL = our_langevin((H + alpha * M[0]) / a)
            f = Ms * L - M[0] + c * delta * k * Ms * dL / a
            return [f / (delta * k - alpha * f)]

        solved = solve_ivp(
            slope,
            (start, end),
            torque[-1][-1:],
            "DOP853",
            t_eval=np.linspace(start, end, samples),
            rtol=rtol,
            atol=rtol,
        )
        torque.append(solved.y[0, 1:])
    return np.concatenate(torque)


def _cycle(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Returns the turns of one cycle and the samples between them."""
    low, high = np.radians(RANGE[name.partition("-")[0]])
    up = np.linspace(low, high, BRANCH)
    return np.array([low, high, low]), np.concatenate([up, up[-2::-1]])


def _error(name: str, model: JilesAtherton) -> float:
    """Returns the largest difference [N·m] from a solution with the tolerance 1e-12."""
    turns, angle = _cycle(name)
    return float(np.abs(model.response(angle) - _solved(model, turns, 1e-12, BRANCH)).max())


def _against_scipy(repeats: int) -> list[Row]:
    """Times SciPy at the kernels' accuracy: with the turns known, and sample by sample."""
    name = "elbow-sa-pso"
    model = TABLE_2[name]
    turns, angle = _cycle(name)
    exact, ours = _solved(model, turns, 1e-13, BRANCH), _error(name, model)
    rtol = next(
        r
        for r in 10.0 ** np.arange(-6, -14, -1.0)
        if np.abs(_solved(model, turns, r, BRANCH) - exact).max() <= max(ours, 1e-11)
    )
    cases = (
        (f"solve_ivp DOP853 {rtol:.0e}, turns known", lambda: _solved(model, turns, rtol, BRANCH)),
        (f"solve_ivp DOP853 {rtol:.0e}, any series", lambda: _solved(model, angle, rtol, 2)),
    )
    return [
        compare(
            f"J-A {name}",
            lambda: model.response(angle),
            against,
            work,
            repeats=min(repeats, 3),
            unit="ns/sample",
            count=angle.size,
            target=500.0,
        )
        for against, work in cases
    ]


def _population(repeats: int) -> Row:
    rng = np.random.default_rng(0)
    parameters = rng.uniform(BOX[:, 0], BOX[:, 1], (POPULATION, 5))
    branches = [np.linspace(30, turn, 150) for turn in (50, 70, 90)]
    angle = np.concatenate([part for up in branches for part in (up, up[::-1])])
    starts, initial = np.array([0, 300, 600, 900]), np.zeros((POPULATION, 3))
    torque = np.empty((POPULATION, angle.size))
    return measure(
        f"J-A population, {POPULATION} x {angle.size}, one core",
        lambda: kernels.population_response(angle, starts, initial, parameters, torque),
        repeats=repeats,
        unit="ns/sample",
        count=torque.size,
        limit=15.0,
    )


def _others(repeats: int) -> list[Row]:
    rng = np.random.default_rng(1)
    n = 20
    play = PrandtlIshlinskii(
        stiffness=1, thresholds=np.linspace(0.02, 0.6, n), weights=rng.uniform(0, 1, n)
    )
    density = [rng.uniform(0, 0.1, i + 1).tolist() for i in range(n)]
    relays = Preisach(levels=np.linspace(0, 2, n + 1), density=density, elastic=[1] * n)
    nested = 1 + np.array([(-1) ** i * (1 - i / (n + 1)) for i in range(n)])
    inside = 1 + 0.5 / (n + 1) * np.sin(np.linspace(0, 600, 45_000))
    angle = np.concatenate([nested, inside])
    return [
        measure(
            f"{model.name}, {n} {parts}",
            lambda model=model: model.response(angle),
            repeats=repeats,
            unit="ns/sample",
            count=angle.size,
            limit=100.0,
        )
        for model, parts in ((relays, "turning points"), (play, "elements"))
    ]
