"""Faults of measurements and of files, and what `identify` says about each."""

import math
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError
from ...identification import Curve, fit_curves, load_curves, save_curves
from ...identification.judging.faults import played
from .truths import NOISE, STEP, Truth, first_order, jiles_atherton

OFFSET, RATE, LAG = 0.8, 1.0, 0.1  # N·m, N·m·s/rad, s
SEEN = 1.0  # N·m, torque below zero that shows a gap
SLOWEST = 0.15  # rad/s, rate of the first curve; the others are faster
_CAUSES = "tare rate lag play gap drift softening offset gain"
_MISTAKES = (
    "clipped turn label disorder unit clock encoder copy work sign exchanged coarse outliers"
)
CODES = {*_CAUSES.split(), *_MISTAKES.split()}
"""Codes of remarks that name a fault; the others doubt the model."""

Series = dict[str, tuple[Array, Array, Array]]  # time, angle and torque by curve


class Fault(NamedTuple):
    """A fault that is put into curves.

    Attributes:
        expected: Codes of the remarks, or words of the refusal, of which each names it.
        put: Puts it into time, angle and torque of all curves, with a generator.
        truth: What moves the joint, if it is not the plain suit.
        file: Changes the lines of the file, header first; None leaves them.
    """

    expected: tuple[str, ...]
    put: Callable[[Series, np.random.Generator], Series] = lambda series, _: series
    truth: Callable[[Truth, Array, Array], Array] = lambda truth, angle, _: truth.torque(angle)
    file: Callable[[list[str]], list[str]] | None = None


def _torque(change: Callable[[int, Array, Array, Array], Array]) -> Callable[..., Series]:
    """Returns a fault that changes torques, from index, time, angle and torque of each curve."""

    def put(series: Series, _: np.random.Generator) -> Series:
        return {
            name: (time, angle, change(i, time, angle, torque))
            for i, (name, (time, angle, torque)) in enumerate(series.items())
        }

    return put


def _where(change: Callable[[Array, Array, Array], Sequence[Array]], which: int = 2) -> Callable:
    """Returns a fault that changes one curve, from its time, angle and torque."""

    def put(series: Series, _: np.random.Generator) -> Series:
        found = dict(series)
        name = [*found][which]
        time, angle, torque = change(*found[name])
        found[name] = time, angle, torque
        return found

    return put


def _again(factor: float, fresh: bool) -> Callable[..., Series]:
    def put(series: Series, rng: np.random.Generator) -> Series:
        time, angle, torque = [*series.values()][3]
        new = NOISE * math.sqrt(2) * rng.standard_normal(torque.size) if fresh else 0.0
        return {**series, "again": (time, angle, factor * torque + new)}

    return put


def _one_label(series: Series, _: np.random.Generator) -> Series:
    angles, torques, times, end = [], [], [], 0.0
    for time, angle, torque in series.values():
        angles.append(angle)
        torques.append(torque)
        times.append(end + STEP + time)
        end = float(times[-1][-1])
    return {"A": (np.concatenate(times), np.concatenate(angles), np.concatenate(torques))}


def _shuffled(series: Series, rng: np.random.Generator) -> Series:
    found = {}
    for name, (time, angle, torque) in series.items():
        order = rng.permutation(angle.size)
        found[name] = time, angle[order], torque[order]
    return found


def _jitter(series: Series, rng: np.random.Generator) -> Series:
    size = math.radians(0.5)
    return {
        name: (time, angle + size * rng.standard_normal(angle.size), torque)
        for name, (time, angle, torque) in series.items()
    }


def _without(keep: Callable[[Array], NDArray[np.bool_]]) -> Callable[..., Series]:
    def put(series: Series, _: np.random.Generator) -> Series:
        return {
            name: tuple(one[keep(angle)] for one in (time, angle, torque))  # type: ignore[misc]
            for name, (time, angle, torque) in series.items()
        }

    return put


def _spikes(series: Series, rng: np.random.Generator) -> Series:
    found = {}
    for name, (time, angle, torque) in series.items():
        at = rng.choice(np.arange(5, angle.size - 5), 3, replace=False)
        spoilt = torque.copy()
        spoilt[at] += rng.choice([-1, 1], 3) * 20 * NOISE
        found[name] = time, angle, spoilt
    return found


def _burst(time: Array, angle: Array, torque: Array) -> Sequence[Array]:
    begin = angle.size // 4
    spoilt = torque.copy()
    spoilt[begin : begin + 8] += 8 * NOISE
    return time, angle, spoilt


def _late(time: Array, angle: Array, torque: Array) -> Sequence[Array]:
    return np.where(np.arange(time.size) > time.size // 4, time + 5.0, time), angle, torque


def _stepped(series: Series, _: np.random.Generator) -> Series:
    step = math.radians(1.5)
    return {
        name: (time, step * np.round(angle / step), torque)
        for name, (time, angle, torque) in series.items()
    }


def _cells(change: Callable[[list[str]], list[str]]) -> Callable[[list[str]], list[str]]:
    return lambda lines: [lines[0], *(",".join(change(line.split(","))) for line in lines[1:])]


def _back(lines: list[str]) -> list[str]:
    cells = lines[-5].split(",")  # the last curve has more samples
    cells[2] = "0.0001"
    return [*lines[:-5], ",".join(cells), *lines[-4:]]


def _rising(angle: Array) -> NDArray[np.bool_]:
    return np.arange(angle.size) <= int(np.argmax(angle))


def _viscous(truth: Truth, angle: Array, time: Array, size: float) -> Array:
    return truth.torque(angle) + size * np.gradient(angle, time)


def _lagging(truth: Truth, angle: Array, time: Array) -> Array:
    return np.interp(time - LAG, time, truth.torque(angle))


FAULTS: dict[str, Fault] = {
    "none": Fault(()),
    "tare 0.2 N·m": Fault(("tare",), _torque(lambda i, t, a, torque: torque + 0.2)),
    "tare 0.8 N·m": Fault(("tare",), _torque(lambda i, t, a, torque: torque + OFFSET)),
    "play 0.3 degrees": Fault(
        ("play",), truth=lambda truth, a, t: truth.torque(played(a, math.radians(0.3)))
    ),
    "play 1 degree": Fault(
        ("play",), truth=lambda truth, a, t: truth.torque(played(a, math.radians(1)))
    ),
    "gap 4 degrees": Fault(("gap",)),
    "rate 0.2 N·m·s/rad": Fault(("rate",), truth=lambda truth, a, t: _viscous(truth, a, t, 0.2)),
    "rate 1 N·m·s/rad": Fault(("rate",), truth=lambda truth, a, t: _viscous(truth, a, t, RATE)),
    "sensor lag 0.1 s": Fault(("lag",), truth=_lagging),
    "drift 2 % a curve": Fault(("drift",), _torque(lambda i, t, a, x: x * (1 + 0.02 * i))),
    "wear-in 15 %": Fault(
        ("softening", "drift"), _torque(lambda i, t, a, x: x * (1 + 0.15 * math.exp(-i / 1.5)))
    ),
    "offset of one curve": Fault(("offset",), _where(lambda t, a, x: (t, a, x + OFFSET))),
    "gain of one curve": Fault(("gain",), _where(lambda t, a, x: (t, a, 1.1 * x))),
    "one curve negated": Fault(("gain", "sign"), _where(lambda t, a, x: (t, a, -x))),
    "a curve twice, one 5 % larger": Fault(("gain", "copy"), _again(1.05, fresh=True)),
    "a copy 5 % larger": Fault(("copy",), _again(1.05, fresh=False)),
    "a copy": Fault(("copy",), _again(1.0, fresh=False)),
    "clipped at 70 %": Fault(
        ("clipped",), _torque(lambda i, t, a, x: np.clip(x, -math.inf, 0.7 * 10))
    ),
    "negated torque": Fault(("sign",), _torque(lambda i, t, a, x: -x)),
    "negated angle": Fault(("sign",), lambda s, _: {n: (t, -a, x) for n, (t, a, x) in s.items()}),
    "exchanged columns": Fault(("exchanged", "work"), file=_cells(lambda c: [*c[:3], c[4], c[3]])),
    "exchanged columns, degrees": Fault(
        ("exchanged", "work"),
        file=lambda lines: [
            lines[0].replace("angle_rad", "angle_deg"),
            *_cells(lambda c: [*c[:3], c[4], c[3]])(lines)[1:],
        ],
    ),
    "degrees as radians": Fault(
        ("degrees",), file=_cells(lambda c: [*c[:3], str(57.2958 * float(c[3])), c[4]])
    ),
    "times in ms": Fault(
        ("clock",), lambda s, _: {n: (1000 * t, a, x) for n, (t, a, x) in s.items()}
    ),
    "clock jumps by 5 s": Fault(("clock",), _where(_late)),
    "clock runs back": Fault(("runs back",), file=_back),
    "20 samples missing": Fault(
        ("coarse",), _where(lambda t, a, x: [np.delete(one, range(15, 35)) for one in (t, a, x)], 4)
    ),
    "turns missing": Fault(("turn",), _without(lambda a: a <= a.min() + 0.85 * np.ptp(a))),
    "ways back missing": Fault(("turns back",), _without(_rising)),
    "rows shuffled": Fault(("disorder",), _shuffled),
    "N·cm": Fault(("unit",), _torque(lambda i, t, a, x: 100 * x)),
    "mN·m": Fault(("unit",), _torque(lambda i, t, a, x: 1000 * x)),
    "angle noise 0.5 degrees": Fault(("encoder",), _jitter),
    "encoder of 1.5 degrees": Fault(("encoder",), _stepped),
    "five curves under one label": Fault(("label",), _one_label),
    "single outliers": Fault(("outliers",), _spikes),
    "a burst of eight": Fault(("outliers",), _where(_burst, 4)),
    "tare and play": Fault(
        ("tare", "play"),
        _torque(lambda i, t, a, x: x + OFFSET),
        lambda truth, a, t: truth.torque(played(a, math.radians(1))),
    ),
    "rate and drift": Fault(
        ("rate", "drift"),
        _torque(lambda i, t, a, x: x * (1 + 0.02 * i)),
        lambda truth, a, t: _viscous(truth, a, t, RATE),
    ),
}
"""Faults by name."""


def named(fault: str, seed: int) -> str:
    """Returns what is said about curves with a fault: codes, or the sentence of a refusal."""
    rng = np.random.default_rng([seed, 3])
    kind = FAULTS[fault]
    gap = math.radians(4) if fault.startswith("gap") else 0.0
    truth = jiles_atherton(rng, gap=gap)
    while gap and truth.torque([*first_order(truth).values()][-1]).min() > -SEEN:
        truth = jiles_atherton(rng, gap=gap)  # contact changes where the torque is zero
    series = {}
    for i, (name, angle) in enumerate(first_order(truth).items()):
        time = STEP / (SLOWEST * (1 + i)) * np.arange(angle.size, dtype=np.float64)
        torque = kind.truth(truth, angle, time) + NOISE * rng.standard_normal(angle.size)
        series[name] = time, angle, torque
    series = kind.put(series, rng)
    try:
        curves = [Curve(a, x, name, time=t) for name, (t, a, x) in series.items()]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "elbow.csv")
            save_curves(path, curves)
            if kind.file:
                lines = path.read_text().splitlines()
                path.write_text("\n".join(kind.file(lines)) + "\n")
            curves = load_curves(path)
        fit = fit_curves(curves, seed=seed, workers=1)
    except InputError as error:
        return str(error)
    return " ".join(dict.fromkeys(one.code for one in fit.remarks if one.code in CODES))


def is_named(fault: str, found: str) -> bool:
    """Returns whether what was said names the fault, and nothing else where there is none."""
    expected = FAULTS[fault].expected
    return any(one in found for one in expected) if expected else not found
