"""Do the intervals, verdicts and searches of `identify` hold on truths that nobody tuned them to?

Every case draws its truth, its curves and its noise from broad families by a seed; another first
seed gives other truths and should give the same rates.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...files import write_text
from ...hysteresis import BoucWen, JilesAtherton, PrandtlIshlinskii
from ...hysteresis.certificate import PoleError
from ...hysteresis.jiles_atherton.margins import margin_in_range
from ...identification import Curve, first_order_motions, identify, multi_order_motion
from ...identification.fits.search import MARGIN, NOISE_MARGIN
from ...identification.residual.causes import played
from ...identification.residual.noise import slow_noise
from ...identification.residual.verdict import UNLIKELY
from ...json_files import read_json
from ..backends import run_all
from ..output import Rows, progress, to_json

PEAK, NOISE, TURNS, STEP = 10.0, 0.1, 5, 0.015  # N·m, N·m, curves, rad
NOISES = {
    "white": (0.0, 0.0),
    "AR(1) 0.5": (0.5, 0.0),
    "AR(1) 0.9": (0.9, 0.0),
    "AR(1) 0.97": (0.97, 0.0),
    "slow and white": (0.95, 0.5),
}
FAULTS = ("none", "tare 0.2 N·m", "play 0.3 degrees", "drift 2 %", "rate 0.2 N·m·s/rad")
SURE, FAR = 1.15, 1.3  # times the noise, from which on a misfit shall be told

Torque = Callable[[Array], Array]


class Truth(NamedTuple):
    """A joint that is measured: its torque along angles, and the range of the rig [rad]."""

    torque: Torque
    low: float
    high: float


def jiles_atherton(rng: np.random.Generator, kind: str = "certified") -> Truth:
    """Draws a Jiles-Atherton model: certified, safe in its range only, or near saturation."""
    while True:
        low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
        c = 1 + math.exp(rng.uniform(-1, 2))
        a = math.exp(rng.uniform(4, 7))
        if kind == "saturating":
            a = math.degrees(high) * rng.uniform(0.15, 0.5)
        k = math.exp(rng.uniform(math.log(1.1 * math.degrees(low)), 7)) / (c - 1)
        steep = rng.uniform(1.0, 1.4) if kind == "uncertified" else rng.uniform(-0.8, 0.95)
        alpha = steep * 3 * a / (2 * c - 1)
        ends = math.degrees(low), math.degrees(high)
        if margin_in_range(*ends, 1.0, a, alpha, c, k)[0] < MARGIN:
            continue  # no fit could return it
        model = JilesAtherton(Ms=1.0, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
        try:
            return _scaled(model.response, low, high)
        except PoleError:
            continue


def bouc_wen(rng: np.random.Generator) -> Truth:
    """Draws a Bouc-Wen model with A = 1 that dissipates."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    n = rng.uniform(1, 3)
    beta = math.exp(rng.uniform(1, 3) * n)
    gamma, elastic = rng.uniform(-0.9, 0.9) * beta, rng.uniform(0.05, 0.8)
    model = BoucWen(elastic=elastic, hysteretic=1.0, beta=beta, gamma=gamma, n=n, rest_angle=low)
    return _scaled(model.response, low, high)


def dead_zone(rng: np.random.Generator) -> Truth:
    """Draws stops behind two dead zones, which may stiffen or soften (Kuhnen 2003)."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    radii = (high - low) * np.linspace(0.03, 0.8, 8)
    stops = PrandtlIshlinskii(
        stiffness=rng.uniform(0.05, 0.8),
        thresholds=radii.tolist(),
        weights=rng.dirichlet(np.ones(8)).tolist(),
        rest_angle=low,
    )
    top = float(stops.response(np.array([low, high]))[-1])
    depth, gain = rng.uniform(0.1, 0.6, 2), rng.uniform(-0.4, 0.8, 2)

    def torque(angle: Array) -> Array:
        straight = stops.response(angle)
        return straight + np.maximum(straight[:, None] - depth * top, 0) @ gain

    return _scaled(torque, low, high)


def cubic(rng: np.random.Generator) -> Truth:
    """Draws a Bouc-Wen model with a cubic spring beside it."""
    truth, bend = bouc_wen(rng), rng.uniform(0.2, 1.0)

    def torque(angle: Array) -> Array:
        return truth.torque(angle) + PEAK * bend * (angle - truth.low) ** 3

    return _scaled(torque, truth.low, truth.high)


KINDS: dict[str, Callable[[np.random.Generator], Truth]] = {
    "Jiles-Atherton": jiles_atherton,
    "Bouc-Wen": bouc_wen,
    "dead zones": dead_zone,
    "cubic": cubic,
}


def interval_case(noise: str, seed: int) -> dict[str, Any]:
    """Returns which share of the parameters, and of a random motion, intervals cover."""
    rng = np.random.default_rng([seed, 1])
    truth = jiles_atherton(rng)
    fit = identify(_measured(truth, NOISES[noise], rng), seed=seed, workers=1)
    sure = fit.uncertainty()
    probe = multi_order_motion(truth.low, truth.high, turns=8, angle_step=STEP, rng=rng)
    right = truth.torque(probe)
    low, high = sure.band(Curve(probe, right, "probe"))
    moved = np.abs(probe - probe[0]) > 5 * STEP
    inside = (low <= right) & (right <= high)
    # Parameters of the truth as the fit tells them follow from the exact fit of exact curves.
    exact = identify(_measured(truth, (0.0, 0.0), rng, size=1e-6), seed=seed, workers=1)
    values = exact.uncertainty().values
    covered = (sure.intervals[:, 0] <= values) & (values <= sure.intervals[:, 1])
    return {
        "parameters": float(np.mean(covered)),
        "torque": float(np.mean(inside[moved])),
        "width": float(np.mean((high - low)[moved]) / 2 / NOISE),
    }


def misfit_case(noise: str, repeats: int, seed: int) -> dict[str, Any]:
    """Returns how far a fit of a drawn truth is off, and whether that was told."""
    rng = np.random.default_rng([seed, 2])
    kind = [*KINDS][seed % len(KINDS)]
    model = ("jiles-atherton", "bouc-wen", "prandtl-ishlinskii")[seed // len(KINDS) % 3]
    truth = KINDS[kind](rng)
    curves = _measured(truth, NOISES[noise], rng, repeats=repeats)
    fit = identify(curves, model=model, seed=seed, workers=1)
    off = np.concatenate([fit.predict(one) - truth.torque(one.angle) for one in curves])
    told = fit.judgement is not None and fit.judgement.misfit.probability < UNLIKELY
    times = float(np.sqrt(1 + np.mean(off**2) / NOISE**2))
    return {"times": times, "told": bool(told), "right": model == kind.lower()}


def fault_case(fault: str, seed: int) -> dict[str, Any]:
    """Returns which fault of a measurement is named first."""
    rng = np.random.default_rng([seed, 3])
    truth, curves = jiles_atherton(rng), []
    for i, curve in enumerate(_measured(truth, (0.0, 0.0), rng, size=0.0)):
        time: Array = 0.5 * (1 + i) * STEP * np.arange(curve.angle.size, dtype=np.float64)
        angle, torque = curve.angle, curve.torque
        if fault.startswith("tare"):
            torque = torque + 0.2
        elif fault.startswith("play"):
            torque = truth.torque(played(angle, math.radians(0.3)))
        elif fault.startswith("drift"):
            torque = torque * (1 + 0.02 * i)
        elif fault.startswith("rate"):
            torque = torque + 0.2 * np.gradient(angle, time)
        torque = torque + NOISE * rng.standard_normal(torque.size)
        curves.append(Curve(angle, torque, curve.name, time=time))
    judged = identify(curves, seed=seed, workers=1).judgement
    return {"named": judged.causes[0].name if judged and judged.causes else "none"}


def start_case(kind: str, seed: int) -> dict[str, Any]:
    """Returns whether the search of a drawn truth ends at the noise, and after how many runs."""
    rng = np.random.default_rng([seed, 4])
    truth = jiles_atherton(rng, kind)
    curves = _measured(truth, (0.0, 0.0), rng)
    fit = identify(curves, seed=seed, workers=1)
    left, noise = (
        np.concatenate([torque(one) - one.torque for one in curves])
        for torque in (fit.predict, lambda one: truth.torque(one.angle))
    )
    reached = np.linalg.norm(left) <= NOISE_MARGIN * np.linalg.norm(noise)
    return {"reached": bool(reached), "evaluations": fit.evaluations}


CASES: dict[str, Callable[..., dict[str, Any]]] = {
    "intervals": interval_case,
    "misfit": misfit_case,
    "faults": fault_case,
    "starts": start_case,
}
CELLS: dict[str, list[tuple]] = {
    "intervals": [(noise,) for noise in NOISES],
    "misfit": [("white", 1), ("AR(1) 0.9", 1), ("AR(1) 0.9", 2), ("slow and white", 2)],
    "faults": [(fault,) for fault in FAULTS],
    "starts": [("certified",), ("uncertified",), ("saturating",)],
}


def honesty(repeats: int, first_seed: int, folder: Path | None, workers: int = -1) -> list[dict]:
    """Runs all cases; those that a folder holds already are not run again.

    Args:
        repeats: Number of cases of each cell.
        first_seed: Seed of the first case.
        folder: Folder that keeps each case as it is finished; None keeps none.
        workers: Number of processes; -1 uses all cores.
    """
    wanted = [
        (part, cell, seed)
        for part, cells in CELLS.items()
        for cell in cells
        for seed in range(first_seed, first_seed + repeats)
    ]
    found: dict[tuple, dict] = {}
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        for case in wanted:
            if (path := folder / _file(case)).exists():
                found[case] = read_json(path, "case")
    missing = [(case,) for case in wanted if case not in found]
    with progress("honesty", len(missing)) as bar:
        for case, result in run_all(_run, missing, "loky", workers):
            found[case] = result
            if folder is not None:
                write_text(folder / _file(case), to_json(result) + "\n")
            bar.advance()
    return [
        {"part": part, "cell": list(cell), "seed": seed, **found[part, cell, seed]}
        for part, cell, seed in wanted
    ]


def tables(results: Sequence[Mapping[str, Any]]) -> dict[str, Rows]:
    """Returns the tables of all parts, by title."""
    return {
        "nominal 95 % intervals": (
            ["noise", "repeats", "parameters", "torque of a\nrandom motion", "half width,\nnoises"],
            list(_interval_rows(results)),
        ),
        f"misfits that are told (below {UNLIKELY:g})": (
            ["noise", "each curve", "false, of\nright models", f"from {SURE:g}x", f"from {FAR:g}x"],
            list(_misfit_rows(results)),
        ),
        "faults of the measurement": (
            ["fault", "named", "another", "none"],
            list(_fault_rows(results)),
        ),
        "searches at the noise floor": (
            ["truth", "reached", "model runs,\nmedian", "most"],
            list(_start_rows(results)),
        ),
    }


def _interval_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for cell, rows in _by_cell(results, "intervals"):
        shares = ([row[name] for row in rows] for name in ("parameters", "torque"))
        values = [_percent(np.mean(share)) for share in shares]
        width = np.median([row["width"] for row in rows])
        yield [cell[0], str(len(rows)), *values, f"{width:.2f}"]


def _misfit_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (noise, repeats), rows in _by_cell(results, "misfit"):
        times = np.array([row["times"] for row in rows])
        told = np.array([row["told"] for row in rows])
        right = np.array([row["right"] for row in rows])
        cells = [_share(told[part]) for part in (right, times >= SURE, times >= FAR)]
        yield [noise, "once" if repeats == 1 else "twice", *cells]


def _fault_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (fault,), rows in _by_cell(results, "faults"):
        named = np.array([row["named"] for row in rows])
        right, none = named == fault.split()[0], named == "none"
        yield [fault, _share(right), _share(~right & ~none), _share(none)]


def _start_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (kind,), rows in _by_cell(results, "starts"):
        runs = [row["evaluations"] for row in rows]
        reached = np.array([row["reached"] for row in rows])
        yield [kind, _share(reached), f"{np.median(runs):.0f}", str(max(runs))]


def _by_cell(
    results: Sequence[Mapping[str, Any]], part: str
) -> Iterator[tuple[tuple, list[Mapping[str, Any]]]]:
    for cell in CELLS.get(part, []):
        rows = [row for row in results if row["part"] == part and tuple(row["cell"]) == cell]
        yield cell, [row for row in rows if "failed" not in row]


def _share(values: Array) -> str:
    return f"{_percent(np.mean(values))} of {values.size}" if values.size else "-"


def _percent(share: Any) -> str:
    return f"{100 * float(share):.1f} %"


def _run(case: tuple[str, tuple, int]) -> tuple[tuple, dict[str, Any]]:
    part, cell, seed = case
    try:
        return case, CASES[part](*cell, seed)
    except InputError as error:  # such curves cannot be fitted, which is an answer too
        return case, {"failed": str(error)}


def _file(case: tuple[str, tuple, int]) -> str:
    part, cell, seed = case
    name = "".join(c if c.isalnum() else "-" for c in " ".join(map(str, cell)))
    return f"{part}.{name}.{seed}.json"


def _scaled(torque: Torque, low: float, high: float) -> Truth:
    way = next(iter(first_order_motions([high], start_angle=low, angle_step=STEP).values()))
    size = PEAK / np.abs(torque(way)).max()
    return Truth(lambda angle: size * torque(angle), low, high)


def _measured(
    truth: Truth,
    noise: tuple[float, float],
    rng: np.random.Generator,
    *,
    size: float = NOISE,
    repeats: int = 1,
) -> list[Curve]:
    turns = np.linspace(truth.low, truth.high, TURNS + 1)[1:].tolist()
    motions = first_order_motions(turns, start_angle=truth.low, angle_step=STEP)
    memory, white = noise
    curves = []
    for i in range(repeats):
        for name, angle in motions.items():
            slow = math.sqrt(1 - white) * slow_noise(angle.size, memory, rng)
            drawn = slow + math.sqrt(white) * rng.standard_normal(angle.size)
            curves.append(Curve(angle, truth.torque(angle) + size * drawn, f"{name}-{i}"))
    return curves
