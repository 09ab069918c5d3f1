"""Do the intervals, verdicts and searches of `identify` hold on truths that nobody tuned them to?

Every case draws its truth, its curves and its noise from broad families by a seed; another first
seed gives other truths and should give the same rates.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...files import write_text
from ...identification import Curve, Fit, fit_curves
from ...identification.fits.objective import InitialTorque
from ...identification.fits.search import NOISE_MARGIN
from ...identification.judging.judgement import UNLIKELY
from ...identification.judging.sentences import DESCRIBES, NOT, NOT_BEYOND, UNKNOWN
from ...json_files import read_json
from ...scripts.backends import run_all
from ...scripts.folders import to_json
from ...scripts.output import progress
from ...tables import Rows
from .bands import FAMILIES, band_case
from .faults import FAULTS, is_named, named
from .truths import KINDS, NOISE, PEAK, STEP, jiles_atherton, measured, multi_order_motion

NOISES = {
    "white": (0.0, 0.0),
    "AR(1) 0.5": (0.5, 0.0),
    "AR(1) 0.9": (0.9, 0.0),
    "AR(1) 0.97": (0.97, 0.0),
    "slow and white": (0.95, 0.5),
    "2 % of the torque": (0.0, 0.0),
}
UNEVEN = {"2 % of the torque": (0.1 * NOISE, 0.02)}  # constant part, and share of the torque
SIZES = {"1 %": 0.01, "0.2 %": 0.002}
RECORD = "a record of ever larger cycles"
SHAPES = ("first-order curves", RECORD)
VERDICTS = {DESCRIBES: "yes", NOT_BEYOND: "yes", UNKNOWN: "unknown", NOT: "no"}
LONG = 60  # letters of a sentence in a table
FITTED = ("Jiles-Atherton", "Bouc-Wen")
FAR = 1.3  # error over the noise, from which on no model describes the curves


def interval_case(noise: str, seed: int) -> dict[str, Any]:
    """Returns which share of the parameters, and of a random motion, intervals cover.

    The model is of the truth's kind, so a reported misfit is a false alarm.
    """
    rng = np.random.default_rng([seed, 1])
    truth = jiles_atherton(rng)
    size, share = UNEVEN.get(noise, (NOISE, 0.0))
    curves = measured(truth, NOISES[noise], rng, size=size, share=share)
    fit = fit_curves(curves, seed=seed, workers=1)
    sure = fit.uncertainty()
    probe = multi_order_motion(truth.low, truth.high, turns=8, angle_step=STEP, rng=rng)
    right = truth.torque(probe)
    low, high = sure.band(Curve(probe, right, "probe"))
    moved = np.abs(probe - probe[0]) > 5 * STEP
    inside = (low <= right) & (right <= high)
    # Parameters of the truth as the fit tells them follow from the exact fit of exact curves.
    exact = fit_curves(measured(truth, (0.0, 0.0), rng, size=1e-6), seed=seed, workers=1)
    values = exact.uncertainty().values
    covered = (sure.intervals[:, 0] <= values) & (values <= sure.intervals[:, 1])
    return {
        "parameters": float(np.mean(covered)),
        "torque": float(np.mean(inside[moved])),
        "width": float(np.mean((high - low)[moved]) / 2 / NOISE),
        "false": _is_reported(fit),
    }


def verdict_case(shape: str, noise: str, size: str, seed: int) -> dict[str, Any]:
    """Returns how far a fit of a drawn truth is off, its verdict and the causes that it names.

    The truths have no fault of measurement, so that every cause is a wrong one.
    """
    kind = [*KINDS][seed % len(KINDS)]
    return _judged(kind, FITTED[seed // len(KINDS) % 2].lower(), shape, noise, size, seed)


def right_case(shape: str, noise: str, size: str, seed: int) -> dict[str, Any]:
    """Returns what `verdict_case` does of a model of the truth's kind."""
    kind = FITTED[seed % 2]
    return _judged(kind, kind.lower(), shape, noise, size, seed)


def _judged(kind: str, model: str, shape: str, noise: str, size: str, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng([seed, 2])
    truth, deviation = KINDS[kind](rng), PEAK * SIZES[size]
    record = shape == RECORD
    curves = measured(truth, NOISES[noise], rng, size=deviation, record=record)
    begin: InitialTorque | None = "identified" if record and model == "jiles-atherton" else None
    fit = fit_curves(curves, model=model, initial_torque=begin, seed=seed, workers=1)
    off = np.concatenate([fit.predict(one) - truth.torque(one.angle) for one in curves])
    return {
        "off": float(np.sqrt(np.mean(off**2))) / deviation,
        "verdict": VERDICTS[fit.verdict],
        "causes": [one.name for one in fit.judgement.causes] if fit.judgement else [],
    }


def _is_reported(fit: Fit) -> bool:
    """Returns whether a misfit was reported."""
    return fit.judgement is not None and fit.judgement.misfit.probability < UNLIKELY


def fault_case(fault: str, seed: int) -> dict[str, Any]:
    """Returns what is said about curves with a fault, and whether that names it."""
    found = named(fault, seed)
    return {"found": found, "named": is_named(fault, found)}


def start_case(kind: str, seed: int) -> dict[str, Any]:
    """Returns whether the search of a drawn truth ends at the noise, and after how many runs."""
    rng = np.random.default_rng([seed, 4])
    truth = jiles_atherton(rng, kind)
    curves = measured(truth, (0.0, 0.0), rng)
    fit = fit_curves(curves, seed=seed, workers=1)
    left, noise = (
        np.concatenate([torque(one) - one.torque for one in curves])
        for torque in (fit.predict, lambda one: truth.torque(one.angle))
    )
    reached = np.linalg.norm(left) <= NOISE_MARGIN * np.linalg.norm(noise)
    return {"reached": bool(reached), "evaluations": fit.evaluations}


CASES: dict[str, Callable[..., dict[str, Any]]] = {
    "intervals": interval_case,
    "verdicts": verdict_case,
    "right": right_case,
    "faults": fault_case,
    "starts": start_case,
    "bands": band_case,
}
JUDGED = list(product(SHAPES, ("white", "AR(1) 0.9"), SIZES))
CELLS: dict[str, list[tuple]] = {
    "intervals": [(noise,) for noise in NOISES],
    "verdicts": JUDGED,
    "right": JUDGED,
    "faults": [(fault,) for fault in FAULTS],
    "starts": [("certified",), ("uncertified",), ("saturating",)],
    "bands": [(family,) for family in FAMILIES],
}


SELDOM = {"bands": 3}  # parts whose cases take long: one case for so many of the others


def honesty(repeats: int, first_seed: int, folder: Path | None, workers: int = -1) -> list[dict]:
    """Runs all cases; those that a folder holds already are not run again.

    Args:
        repeats: Number of cases of each cell; of bands a third of it.
        first_seed: Seed of the first case.
        folder: Folder that keeps each case as it is finished; None keeps none.
        workers: Number of processes; -1 uses all cores.
    """
    wanted = [
        (part, cell, seed)
        for part, cells in CELLS.items()
        for cell in cells
        for seed in range(first_seed, first_seed + max(repeats // SELDOM.get(part, 1), 1))
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
            [
                "noise",
                "repeats",
                "parameters",
                "torque of a\nrandom motion",
                "half width,\nnoises",
                "false\nmisfits",
            ],
            list(_interval_rows(results)),
        ),
        "verdicts": (
            [
                "curves",
                "noise",
                "fits",
                f"describes, but\n{FAR:g} noises off",
                "a wrong\ncause",
            ],
            list(_verdict_rows(results)),
        ),
        "verdicts of models of the true kind": (
            [
                "curves",
                "noise",
                "fits",
                "does not\ndescribe",
                "cannot\nbe judged",
                "a wrong\ncause",
            ],
            list(_right_rows(results)),
        ),
        "faults of measurements and files": (
            ["fault", "named", "often said"],
            list(_fault_rows(results)),
        ),
        "searches at the noise floor": (
            ["truth", "reached", "model runs,\nmedian", "most"],
            list(_start_rows(results)),
        ),
        "nominal 90 % bands on random motions": (
            ["truth", "repeats", "inside", "half width,\nnoises", "error,\nnoises"],
            list(_band_rows(results)),
        ),
    }


def _interval_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for cell, rows in _by_cell(results, "intervals"):
        shares = ([row[name] for row in rows] for name in ("parameters", "torque"))
        values = [_percent(np.mean(share)) for share in shares]
        width = np.median([row["width"] for row in rows])
        false = _percent(np.mean([row["false"] for row in rows]))
        yield [cell[0], str(len(rows)), *values, f"{width:.2f}", false]


def _verdict_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (shape, noise, size), rows in _by_cell(results, "verdicts"):
        off = np.array([row["off"] for row in rows])
        verdict = np.array([row["verdict"] for row in rows])
        cells = [_share(verdict[off > FAR] == "yes"), _wrong_causes(rows)]
        yield [shape, f"{noise}, {size}", str(len(rows)), *cells]


def _right_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (shape, noise, size), rows in _by_cell(results, "right"):
        verdict = np.array([row["verdict"] for row in rows])
        cells = [_share(verdict == "no"), _share(verdict == "unknown"), _wrong_causes(rows)]
        yield [shape, f"{noise}, {size}", str(len(rows)), *cells]


def _wrong_causes(rows: Sequence[Mapping[str, Any]]) -> str:
    return _share(np.array([bool(row["causes"]) for row in rows]))


def _fault_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (fault,), rows in _by_cell(results, "faults"):
        said = Counter(row["found"] for row in rows).most_common(1)[0][0]
        right = np.array([row["named"] for row in rows])
        yield [fault, _share(right), said if len(said) < LONG else f"{said[:LONG]} ..."]


def _start_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (kind,), rows in _by_cell(results, "starts"):
        runs = [row["evaluations"] for row in rows]
        reached = np.array([row["reached"] for row in rows])
        yield [kind, _share(reached), f"{np.median(runs):.0f}", str(max(runs))]


def _band_rows(results: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for (family,), rows in _by_cell(results, "bands"):
        cells = ["-"] * 3
        if rows:
            inside = _percent(np.mean([row["inside"] for row in rows]))
            sizes = (np.median([row[name] for row in rows]) for name in ("width", "error"))
            cells = [inside, *(f"{size:.2f}" for size in sizes)]
        yield [family, str(len(rows)), *cells]


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
