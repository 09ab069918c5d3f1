"""Mistakes of a recording that curves show before any fit, each with its place and numbers."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from ...hysteresis.loops import angle_noise, reversals
from ..data.curves import SURELY, Curve, Curves, loop_work, noise_floor
from .sentences import Remark

LITTLE_MOTION = 0.05  # smallest plausible range of angles [rad]
# Peak torques of a joint in a suit [N·m], with a factor of five or more on each side.
USUAL_PEAK = (0.01, 500.0)
USUAL_RATE = (1e-3, 30.0)  # rates of a branch [rad/s]; slower takes an hour, faster is no joint's
COARSE = 0.1  # largest distance between two samples, as a share of the range
COUNTS = 100  # encoder counts over the range: fewer hide torques of 0.3 % of the peak
REPEATED = 0.2  # share of samples that repeat the angle of the one before
CLIPPED = 6  # least length of a run of equal torques at the extreme that is no chance
SHUFFLED = 5.0  # samples over the way in ranges; fewer are in no order
FEWEST = 20  # samples of a curve whose order can be judged
PAUSE = 5.0  # ratio of a step of time to the usual one, where a turn may be missing
AWAY = 0.02  # way over the range that the joint could go in that time, at least
SURE = 4.0  # deviations of the noise that a jump of the torque has at least
SUDDEN = 0.02  # jump of the torque over its range, at least
OFTEN = 2  # number of returns to the first angle, from which on there may be several measurements
LATE = 20.0  # ratio of a step of time to the usual one, where the clock jumps
NOISY = 2e-3  # noise of the angle over the range, above which there is a remark
SAME_PLACE = 0.02  # largest distance of two angles at one place, over the range
SCALED = 0.05  # residual of a scaled copy, over the noise
SMOOTH = 0.1  # noise of a torque over that of the angle, as shares of their ranges: exchanged

IF_WRONG = ("work", "label")
"""Codes of remarks that are of no interest where a model describes the curves."""

Place = Callable[[int], str]


def recording_faults(curves: Sequence[Curve]) -> list[Remark]:
    """Returns remarks on mistakes of the recording of curves, as they were read."""
    family = Curves(curves)
    found = [*_family(family)]
    for look in (_clipped, _shuffled, _label, _turn, _clock, _coarse, _stepped, _noisy):
        remarks = (look(one, partial(family.place, one.name)) for one in family)
        found += [one for one in remarks if one][:1]  # one remark a kind
    return found


def _family(curves: Curves) -> Iterator[Remark]:
    """Yields remarks on numbers of all curves together."""
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    if span < LITTLE_MOTION:
        yield Remark("unit angle", {"span": span})
    low, high = USUAL_PEAK
    if not low <= curves.peak <= high:
        yield Remark("unit torque", {"peak": curves.peak, "low": low, "high": high})
    rates = [
        float(np.abs(np.diff(one.angle)).sum() / np.ptp(one.time))
        for one in curves
        if one.time is not None
    ]
    low, high = USUAL_RATE
    if rates and not low <= min(rates) <= max(rates) <= high:
        values = {"slowest": min(rates), "fastest": max(rates), "low": low, "high": high}
        yield Remark("clock rate", values)
    work = loop_work(curves)
    falling = [f" of curve {one.name!r}" for one in curves if loop_work([one]).falls]
    if work.falls or falling:
        yield Remark("sign", {"of": "" if work.falls else falling[0]})
    if work.z < SURELY and work.rise > 0:
        yield Remark("work", {"work": -work.work, "deviations": -work.z})
    yield from _copies(curves)


def _copies(curves: Curves) -> Iterator[Remark]:
    """Yields a remark on the first two curves of which one is a copy, perhaps scaled."""
    noise = noise_floor(curves)
    for one, other in combinations(curves, 2):
        if not np.array_equal(one.angle, other.angle):
            continue
        square = float(one.torque @ one.torque)
        factor = float(one.torque @ other.torque) / square if square else 1.0
        rest = float(np.std(other.torque - factor * one.torque))
        if rest > SCALED * noise or (noise == 0 and factor != 1):
            continue
        kind = "copy" if np.array_equal(one.torque, other.torque) else "copy scaled"
        yield Remark(kind, {"curve": other.name, "other": one.name, "factor": factor})
        return


def _clipped(curve: Curve, place: Place) -> Remark | None:
    if noise_floor([curve]) <= 0:
        return None  # a torque without noise may be constant
    begins = np.concatenate([[0], np.flatnonzero(np.diff(curve.torque)) + 1])
    lengths = np.diff([*begins, curve.torque.size])
    longest = int(np.argmax(lengths))
    value, count = float(curve.torque[begins[longest]]), int(lengths[longest])
    if value not in (curve.torque.min(), curve.torque.max()) or count < CLIPPED:
        return None
    usual = lengths[curve.torque[begins] != value].max(initial=1)
    if count < 3 * usual:
        return None
    values = {"torque": value, "count": count, "place": place(int(begins[longest]))}
    return Remark("clipped", values)


def _shuffled(curve: Curve, place: Place) -> Remark | None:
    steps = np.abs(np.diff(curve.angle))
    way = float(steps.sum()) / float(np.ptp(curve.angle))
    if curve.angle.size < FEWEST or way * SHUFFLED < curve.angle.size:
        return None
    at = place(int(np.argmax(steps)) + 1)
    return Remark("disorder rows", {"times": way, "count": curve.angle.size, "place": at})


def _label(curve: Curve, _: Place) -> Remark | None:
    """Returns a remark on a motion that comes back to its first angle again and again."""
    span, turns = float(np.ptp(curve.angle)), reversals(curve.angle)
    back = int(np.sum(np.abs(curve.angle[turns] - curve.angle[0]) <= SAME_PLACE * span))
    return Remark("label", {"curve": curve.name, "count": back}) if back >= OFTEN else None


def _turn(curve: Curve, place: Place) -> Remark | None:
    """Returns a remark on a pause at a turn without samples.

    A jump of the torque there shows that the joint went on. No jump shows nothing: loops may be as
    thin as the noise.
    """
    if curve.time is None or curve.angle.size < FEWEST:
        return None
    late, steps = np.diff(curve.time), np.abs(np.diff(curve.torque))
    rate = float(np.median(np.abs(np.diff(curve.angle)) / late))
    least = max(SURE * noise_floor([curve]), SUDDEN * np.ptp(curve.torque))
    for turn in reversals(curve.angle).tolist():
        near = np.arange(max(turn - 2, 0), min(turn + 2, steps.size))
        at = int(near[np.argmax(late[near])])
        if late[at] < PAUSE * np.median(late):
            continue
        values = {"place": place(at), "next": place(at + 1), "step": float(late[at])}
        if steps[at] >= least:
            return Remark("turn jump", values | {"torque": float(steps[at])})
        away = rate * float(late[at]) / 2
        if away >= AWAY * np.ptp(curve.angle):
            return Remark("turn rest", values | {"away": away})
    return None


def _clock(curve: Curve, place: Place) -> Remark | None:
    if curve.time is None or curve.time.size < FEWEST:
        return None
    steps, ways = np.diff(curve.time), np.abs(np.diff(curve.angle))
    late = (steps > LATE * np.median(steps)) & (ways <= 3 * np.median(ways))
    for turn in reversals(curve.angle).tolist():
        late[max(turn - 2, 0) : turn + 2] = False  # a rest between two branches
    if not late.any():
        return None
    at = int(np.argmax(late))
    values = {"place": place(at), "next": place(at + 1), "step": float(steps[at])}
    return Remark("clock jump", values | {"times": float(steps[at] / np.median(steps))})


def _coarse(curve: Curve, place: Place) -> Remark | None:
    steps = np.abs(np.diff(curve.angle))
    at = int(np.argmax(steps))
    if steps[at] <= COARSE * np.ptp(curve.angle):
        return None
    values = {"curve": curve.name, "step": float(steps[at]), "place": place(at + 1)}
    return Remark("coarse", values | {"most": COARSE})


def _stepped(curve: Curve, _: Place) -> Remark | None:
    steps, span = np.abs(np.diff(curve.angle)), float(np.ptp(curve.angle))
    count = float(steps[steps > 0].min())
    whole = np.allclose(steps / count, np.round(steps / count), atol=0.01)
    if span >= COUNTS * count or not whole or np.mean(steps == 0) <= REPEATED:
        return None
    return Remark("encoder steps", {"curve": curve.name, "step": count, "count": span / count})


def _noisy(curve: Curve, place: Place) -> Remark | None:
    if curve.angle.size < FEWEST or _stepped(curve, place) or _shuffled(curve, place):
        return None
    noise = angle_noise(curve.angle)
    share = noise / float(np.ptp(curve.angle))
    if share <= NOISY:
        return None
    torque = angle_noise(curve.torque) / max(float(np.ptp(curve.torque)), np.finfo(float).tiny)
    values = {"curve": curve.name, "share": share}
    if torque < SMOOTH * share:
        return Remark("exchanged", values | {"percent": 100 * torque})
    return Remark("encoder noise", values | {"degrees": float(np.degrees(noise))})
