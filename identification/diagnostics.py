"""Remarks on the numbers of a fit and of its curves, by rules of thumb."""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

import numpy as np

from ..hysteresis.around.asymmetric import Asymmetric
from ..hysteresis.around.backlash import Backlash
from ..hysteresis.around.clipped import Clipped
from ..hysteresis.around.viscoelastic import without_rate
from ..hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ..hysteresis.protocol import HysteresisModel
from .curves import Curve, Curves
from .fits.certified import EXCESS, SHAPE
from .fits.play import LARGEST, without_play
from .fits.search import MARGIN
from .remarks import Remark

NEAR = 1e-3  # relative distance at which a parameter counts as being at its limit
DISORDER = 0.2  # largest plausible error, as a share of the peak
LITTLE_MOTION = 0.05  # smallest plausible range of angles [rad]
# Peak torques of a joint in a suit [N·m], with a factor of ten or more on each side.
USUAL_PEAK = (0.01, 1000.0)
USUAL_RATE = (1e-3, 30.0)  # rates of a branch [rad/s]; slower takes an hour, faster is no joint's
COARSE = 0.1  # largest distance between two samples, as a share of the range
COUNTS = 100  # encoder counts over the range: fewer hide torques of 0.3 % of the peak
REPEATED = 0.2  # share of samples that repeat the angle of the one before
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
    found = [*_unusual(nrmse, curves)]
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
    if isinstance(inner, JilesAtherton):
        found += _limits(inner.in_unit("deg"), bounds)
    return tuple(found)


def _unusual(nrmse: float, curves: Sequence[Curve]) -> Iterator[Remark]:
    """Yields remarks on numbers of the curves that hint at a mistake."""
    if nrmse > DISORDER:
        yield Remark(
            "disorder",
            f"NRMSE {nrmse:.1%}: the curves are very noisy, or not in the order of measurement",
        )
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    if span < LITTLE_MOTION:
        yield Remark("unit", f"the angles span only {span:.3g} rad: check their unit")
    peak = Curves(curves).peak
    low, high = USUAL_PEAK
    if not low <= peak <= high:
        yield Remark(
            "unit",
            f"the torque peaks at {peak:,.3g} N·m, and that of a joint between {low:g} and "
            f"{high:,g} N·m: check its unit",
        )
    rates = [
        float(np.abs(np.diff(one.angle)).sum() / np.ptp(one.time))
        for one in curves
        if one.time is not None
    ]
    low, high = USUAL_RATE
    if rates and not low <= min(rates) <= max(rates) <= high:
        yield Remark(
            "clock",
            f"the joint moves at {min(rates):.2g} to {max(rates):.2g} rad/s, and joints are "
            f"measured between {low:g} and {high:g}: check that time_s is in seconds",
        )
    yield from _first(curves, _coarse)
    yield from _first(curves, _stepped)
    copies = [
        (one.name, other.name)
        for one, other in combinations(curves, 2)
        if np.array_equal(one.angle, other.angle) and np.array_equal(one.torque, other.torque)
    ]
    if copies:
        yield Remark(
            "copy",
            f"curve {copies[0][1]!r} is a copy of {copies[0][0]!r} to the last digit, and no "
            f"second measurement (copies in all: {len(copies)}): remove it",
        )


def _first(curves: Sequence[Curve], look: Callable[[Curve], Remark | None]) -> list[Remark]:
    """Returns the remark on the first curve that deserves one."""
    return list(filter(None, map(look, curves)))[:1]


def _coarse(curve: Curve) -> Remark | None:
    step = float(np.abs(np.diff(curve.angle)).max())
    if step <= COARSE * np.ptp(curve.angle):
        return None
    return Remark(
        "coarse",
        f"samples of curve {curve.name!r} are up to {step:.2g} rad apart, more than "
        f"{COARSE:.0%} of its range, and the torque between them is unknown: sample finer",
    )


def _stepped(curve: Curve) -> Remark | None:
    steps, span = np.abs(np.diff(curve.angle)), float(np.ptp(curve.angle))
    count = float(steps[steps > 0].min())
    whole = np.allclose(steps / count, np.round(steps / count), atol=0.01)
    if span >= COUNTS * count or not whole or np.mean(steps == 0) <= REPEATED:
        return None
    return Remark(
        "encoder",
        f"the angles of curve {curve.name!r} come in steps of {count:.2g} rad, "
        f"{span / count:.0f} over its range, and the torque changes within a "
        "step: measure with a finer encoder, or keep one sample of each step",
    )


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
