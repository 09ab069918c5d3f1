"""Remarks on the numbers of a fit, by rules of thumb."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..hysteresis.around import Asymmetric, Backlash, Clipped, without_rate
from ..hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ..hysteresis.protocol import HysteresisModel
from .curves import Curve
from .fits.certified import EXCESS, SHAPE
from .fits.play import LARGEST, without_play
from .fits.search import MARGIN
from .remarks import Remark

NEAR = 1e-3  # relative distance at which a parameter counts as being at its limit
DISORDER = 0.2  # largest plausible error, as a share of the peak
RETURNED = 0.05  # shortest way back that counts, as a share of the span


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


def turns_back(curve: Curve) -> bool:
    """Returns whether a curve comes back by a good part of its range."""
    # The largest excursion, not the sum of steps: an encoder's jitter is no return.
    angle = curve.angle
    back = (np.maximum.accumulate(angle) - angle).max()
    forth = (angle - np.minimum.accumulate(angle)).max()
    return bool(min(forth, back) > RETURNED * np.ptp(curve.angle))


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
