"""Remarks on a fit: what to know before trusting it, and which option would act on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...hysteresis.around import Asymmetric, Backlash, Clipped, Viscoelastic, without_rate
from ...hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ...hysteresis.protocol import HysteresisModel
from ..corrections.corrections import Corrections
from ..corrections.softening import Softening
from ..data.curves import Curve, Curves
from ..fits.certified import EXCESS, SHAPE
from ..fits.objective import InitialTorque
from ..fits.registry import LARGEST, play_of, rate_of, without_play
from ..fits.search import MARGIN

# Of the curves: they do not cover the intended motion (`coverage`), are noisy or not in order
# (`disorder`), give energy back (`work`), a torque that falls where the angle rises (`sign`),
# exchanged columns, a turn that is missing, one label for several curves, a part of the samples.
OfCurves = Literal[
    "coverage", "disorder", "unit", "clock", "coarse", "encoder", "copy", "outliers", "work"
]
OfColumns = Literal["sign", "exchanged", "clipped", "turn", "label", "thinned"]
# Of the model: safe between some angles (`range`), others fit as well (`form`), the fit ended at a
# limit (`certificate`, `limit`), nothing is explained, ended early (`search`), noise or misfit
# (`wandering`), no memory is needed, where curves and model begin (`start`).
OfModel = Literal["range", "form", "certificate", "limit", "misfit", "nothing", "search"]
OfKind = Literal["wandering", "memoryless", "start"]
# Faults of the measurement, or terms that were not found; `open` is an offset that was asked for
# and is not determined, `offset` and `gain` are those of one curve.
OfMeasurement = Literal["tare", "open", "rate", "lag", "play", "gap", "drift", "offset", "gain"]
Code = OfCurves | OfColumns | OfModel | OfKind | OfMeasurement | Literal["softening"]
_PARTS = {
    **dict.fromkeys(("tare", "rate", "play", "softening"), "corrections=Corrections({})"),
    "objective": "method=Search(..., {})",
}
NEAR = 1e-3  # relative distance at which a parameter counts as being at its limit
DISORDER = 0.2  # largest plausible error, as a share of the peak
AWAY, BESIDE = 5.0, 0.02  # tolerance in deviations of the noise, and as a share of the peak


@dataclass(frozen=True)
class Remark:
    """A reason to doubt a fit.

    Attributes:
        code: What it is about.
        sentence: The remark in words, with what to do about the measurement.
        option: Option of `identify`, and its value, that would act on it; None if there is none.
            The command line writes it as `--tare fit`.
    """

    code: Code
    sentence: str
    option: tuple[str, str] | None = None

    def __str__(self) -> str:
        if self.option is None:
            return self.sentence
        if self.option == ("method", "auto"):
            return f"{self.sentence} (select(curves))"
        name, value = self.option
        return f"{self.sentence} ({_PARTS.get(name, '{}').format(f'{name}={value!r}')})"


def remarks_on(
    corrections: Corrections, model: HysteresisModel, change: Softening | None
) -> Iterator[Remark]:
    """Yields remarks on terms that were asked for and not found, or only in part.

    Args:
        corrections: What was asked for.
        model: The fitted model.
        change: The change over the cycles that was found.
    """
    if corrections.softening == "fit" and change is None:
        yield Remark("softening", "no change from cycle to cycle was found", ("softening", "none"))
    if change is not None and not change.is_complete:
        yield Remark(
            "softening",
            f"the torque still changes at the end of {change.measured:.2g} cycles, so that the "
            f"steady one, {change.steady:.3g} times the last, is extrapolated: measure more cycles",
        )
    if corrections.play == "fit" and play_of(model) == "none":
        yield Remark("play", "no gap was found", ("play", "none"))
    if isinstance(model, Viscoelastic) and rate_of(model) == "viscous":
        if model.damping == 0:
            yield Remark("rate", "the torque was not found to depend on the rate", ("rate", "none"))
        elif corrections.rate == "relaxing":
            yield Remark("rate", "no relaxation was found beside the dashpot", ("rate", "viscous"))


def diagnostics(
    model: HysteresisModel,
    nrmse: float,
    curves: Sequence[Curve],
    bounds: Sequence[tuple[float, float]] | None,
) -> tuple[Remark, ...]:
    """Returns remarks on a fit that deserves doubt; none where all is well.

    Args:
        model: The fitted model.
        nrmse: Its NRMSE on `curves`.
        curves: The fitted curves.
        bounds: The search box of Ms, a, alpha, c, k in degrees; None for certified fits.
    """
    found = []
    if nrmse > DISORDER:
        sentence = (
            f"NRMSE {nrmse:.1%}: the curves are very noisy, or not in the order of measurement"
        )
        found.append(Remark("disorder", sentence))
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    inner = without_rate(model)
    if isinstance(inner, Backlash) and inner.gap >= (1 - NEAR) * LARGEST * span:
        sentence = f"gap = {inner.gap:.5g} is at the limit of the search: it may be wider"
        found.append(Remark("limit", sentence))
    inner = without_play(inner)
    inner = inner.model if isinstance(inner, Asymmetric) else inner
    if isinstance(inner, Clipped):
        found += _safety(inner)
        inner = inner.model
    if isinstance(inner, JilesAtherton) and inner.clamp == "none":  # other boxes in magnetics
        found += _limits(inner.in_unit("deg"), bounds)
    return tuple(found)


def _safety(model: Clipped) -> Iterator[Remark]:
    low, high = model.angle_range
    yield Remark(
        "range",
        f"the model is safe between {low:.2f} and {high:.2f} rad only; its torque is kept constant "
        "outside, since curves that reach farther might show more",
    )
    if model.certificate().margin <= MARGIN + NEAR:
        yield Remark(
            "certificate",
            "the fit ended at the limit of the certificate: a model that is not safe may fit "
            "better",
        )


def _limits(model: JilesAtherton, bounds: Sequence[tuple[float, float]] | None) -> list[Remark]:
    values = {name: getattr(model, name) for name in PARAMETERS}
    limits = dict(zip(values, bounds, strict=True)) if bounds else {"a": SHAPE}
    if not bounds:
        limits["c"] = (1 + EXCESS[0], 1 + EXCESS[1])
    found = [
        Remark("limit", f"{name} = {values[name]:.5g} is at the limit of the search ({limit:g})")
        for name, pair in limits.items()
        for limit in pair
        if abs(values[name] - limit) <= NEAR * max(1.0, abs(limit))
    ]
    return found


def begins_elsewhere(start: InitialTorque, curves: Curves, noise: float) -> list[Remark]:
    """Returns a remark if the curves begin at another torque than the model."""
    first = curves.start_torque
    if isinstance(start, str) or abs(first - start) <= max(AWAY * noise, BESIDE * curves.peak):
        return []
    return [
        Remark(
            "start",
            f"the curves begin at {first:.3g} N·m, and the model at {start:.3g} N·m: subtract the "
            "sensor's offset as a tare, if it has one; or let the model begin where they do",
            ("initial_torque", "identified"),
        )
    ]
