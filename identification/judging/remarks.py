"""Remarks on a fitted model: limits that were reached, and corrections that were not found."""

from collections.abc import Iterator, Sequence

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
from .sentences import Remark

NEAR = 1e-3  # relative distance at which a parameter counts as being at its limit
DISORDER = 0.2  # largest plausible error, as a share of the peak
AWAY, BESIDE = 5.0, 0.02  # tolerance in deviations of the noise, and as a share of the peak


def remarks_on(
    corrections: Corrections, model: HysteresisModel, change: Softening | None
) -> Iterator[Remark]:
    """Yields remarks on requested corrections that were not found, or found in part.

    `change` is the change over the cycles that was found.
    """
    if corrections.softening == "fit" and change is None:
        yield Remark("softening none")
    if change is not None and not change.is_complete:
        yield Remark("softening incomplete", {"cycles": change.measured, "steady": change.steady})
    if corrections.play == "fit" and play_of(model) == "none":
        yield Remark("play none")
    if isinstance(model, Viscoelastic) and rate_of(model) == "viscous":
        if model.damping == 0:
            yield Remark("rate none")
        elif corrections.rate == "relaxing":
            yield Remark("rate viscous")


def diagnostics(
    model: HysteresisModel,
    nrmse: float,
    curves: Sequence[Curve],
    bounds: Sequence[tuple[float, float]] | None,
) -> Iterator[Remark]:
    """Yields remarks on a large error and on parameters at a limit.

    The bounds are the search box of Ms, a, alpha, c, k in degrees; None for certified fits.
    """
    if nrmse > DISORDER:
        yield Remark("disorder error", {"nrmse": nrmse})
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    inner = without_rate(model)
    if isinstance(inner, Backlash) and inner.gap >= (1 - NEAR) * LARGEST * span:
        yield Remark("limit gap", {"gap": inner.gap})
    inner = without_play(inner)
    inner = inner.model if isinstance(inner, Asymmetric) else inner
    if isinstance(inner, Clipped):
        low, high = inner.angle_range
        yield Remark("range", {"low": low, "high": high})
        if inner.certificate().margin <= MARGIN + NEAR:
            yield Remark("certificate")
        inner = inner.model
    if isinstance(inner, JilesAtherton) and inner.clamp == "none":  # other boxes in magnetics
        yield from _limits(inner.in_unit("deg"), bounds)


def _limits(model: JilesAtherton, bounds: Sequence[tuple[float, float]] | None) -> Iterator[Remark]:
    limits: dict[str, tuple[float, float]] = {"a": SHAPE, "c": (1 + EXCESS[0], 1 + EXCESS[1])}
    if bounds:
        limits = dict(zip(PARAMETERS, bounds, strict=True))
    for name, pair in limits.items():
        value = getattr(model, name)
        for limit in pair:
            if abs(value - limit) <= NEAR * max(1.0, abs(limit)):
                yield Remark("limit", {"name": name, "value": value, "limit": limit})


def begins_elsewhere(start: InitialTorque, curves: Curves, noise: float) -> Iterator[Remark]:
    """Yields a remark if the curves begin at another torque than the model."""
    first, most = curves.start_torque, max(AWAY * noise, BESIDE * curves.peak)
    if not isinstance(start, str) and abs(first - start) > most:
        yield Remark("start", {"curves": first, "model": start})
