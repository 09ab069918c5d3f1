"""Mistakes of a recording that curves show before any fit, each with what was seen and where."""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

import numpy as np

from ...hysteresis.loops import angle_noise, reversals
from ..data.curves import SURELY, Curve, Curves, loop_work, noise_floor
from .remarks import Remark

LITTLE_MOTION = 0.05  # smallest plausible range of angles [rad]
# Peak torques of a joint in a suit [N·m], with a factor of five or more on each side.
USUAL_PEAK = (0.01, 500.0)
USUAL_RATE = (1e-3, 30.0)  # rates of a branch [rad/s]; slower takes an hour, faster is no joint's
COARSE = 0.1  # largest distance between two samples, as a share of the range
COUNTS = 100  # encoder counts over the range: fewer hide torques of 0.3 % of the peak
REPEATED = 0.2  # share of samples that repeat the angle of the one before
CLIPPED = 6  # length of a run of equal torques at the extreme, from which on it is no chance
SHUFFLED = 5.0  # samples over the way in ranges; fewer are in no order
FEWEST = 20  # samples of a curve whose order can be judged
PAUSE = 5.0  # ratio of a step of time to the usual one, where a turn may be missing
AWAY = 0.02  # way over the range that the joint could go in that time, at least
SURE = 4.0  # deviations of the noise that a jump of the torque has at least
SUDDEN = 0.02  # jump of the torque over its range, at least
OFTEN = 2  # returns to the first angle that may be the begin of another measurement
LATE = 20.0  # ratio of a step of time to the usual one, where the clock jumps
NOISY = 2e-3  # noise of the angle over the range, from which on it counts
SAME_PLACE = 0.02  # largest distance of two angles at one place, over the range
SCALED = 0.05  # residual of a scaled copy, over the noise
SMOOTH = 0.1  # noise of a torque over that of the angle, as shares of their ranges: exchanged

IF_WRONG = ("work", "label")
"""Codes of remarks that are of no interest where a model describes the curves."""

Place = Callable[[int], str]
Look = Callable[[Curve, Place], Remark | None]


def recording_faults(curves: Sequence[Curve]) -> list[Remark]:
    """Returns remarks on mistakes of the recording; none where nothing is suspicious.

    Args:
        curves: The curves as they were read; `Curves` of a file know its lines.
    """
    family = Curves(curves)
    found = [*_family(family)]
    for look in (_clipped, _shuffled, _label, _turn, _clock, _coarse, _stepped, _noisy):
        found += _first(family, look)
    return found


def _first(curves: Curves, look: Look) -> list[Remark]:
    """Returns the remark on the first curve that deserves one."""
    for curve in curves:
        remark = look(curve, lambda sample, name=curve.name: curves.place(name, sample))
        if remark:
            return [remark]
    return []


def _family(curves: Curves) -> Iterator[Remark]:
    """Yields remarks on numbers of all curves together."""
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    if span < LITTLE_MOTION:
        yield Remark("unit", f"the angles span only {span:.3g} rad: check their unit")
    low, high = USUAL_PEAK
    if not low <= curves.peak <= high:
        yield Remark(
            "unit",
            f"the torque peaks at {curves.peak:,.3g} N·m, and that of a joint between {low:g} and "
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
    work = loop_work(curves)
    wrong = (
        [""] if work.falls else [f" of curve {x.name!r}" for x in curves if loop_work([x]).falls]
    )
    if wrong:
        yield Remark(
            "sign",
            f"the torque{wrong[0]} falls where the angle rises, as if the joint left by itself the "
            "place where it rests: check the signs of angle and torque, which must be positive "
            "against positive motion",
        )
    if work.z < SURELY and work.rise > 0:
        yield Remark(
            "work",
            f"the loops give back {-work.work:.3g} J more than they take ({-work.z:.1f} standard "
            "deviations), though the torque rises with the angle: check that the columns of angle "
            "and torque are not exchanged, and that both are measured at the same time; a "
            "magnetization over its field does so too",
            ("method", "magnetic"),
        )
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
        kind = "a copy" if np.array_equal(one.torque, other.torque) else f"{factor:.6g} times"
        of = f"of {one.name!r}" if kind == "a copy" else f"{one.name!r}"
        yield Remark(
            "copy",
            f"curve {other.name!r} is {kind} {of} to the last digits, and no second measurement: "
            "remove it",
        )
        return


def _clipped(curve: Curve, place: Place) -> Remark | None:
    if noise_floor([curve]) <= 0:
        return None  # a torque without noise may be constant
    begins = np.concatenate([[0], np.flatnonzero(np.diff(curve.torque)) + 1])
    lengths = np.diff([*begins, curve.torque.size])
    longest = int(np.argmax(lengths))
    value = float(curve.torque[begins[longest]])
    if value not in (curve.torque.min(), curve.torque.max()) or lengths[longest] < CLIPPED:
        return None
    others = np.delete(lengths, longest)
    at_extremes = np.isin(np.delete(curve.torque[begins], longest), (value,))
    usual = others[~at_extremes].max(initial=1)
    if lengths[longest] < 3 * usual:
        return None
    return Remark(
        "clipped",
        f"the torque stays at exactly {value:.6g} N·m for {lengths[longest]} samples from "
        f"{place(int(begins[longest]))} on: the sensor or its amplifier is at its limit; measure "
        "with a larger range, or smaller motions",
    )


def _shuffled(curve: Curve, place: Place) -> Remark | None:
    size, span = curve.angle.size, float(np.ptp(curve.angle))
    steps = np.abs(np.diff(curve.angle))
    way = float(steps.sum()) / span
    if size < FEWEST or way * SHUFFLED < size:
        return None
    at = int(np.argmax(steps)) + 1
    return Remark(
        "disorder",
        f"the angle goes {way:.0f} times through its range in {size} samples (the largest step is "
        f"at {place(at)}): the rows are not in the order of measurement; sort them by time",
    )


def _label(curve: Curve, _: Place) -> Remark | None:
    """Returns a remark on a motion that comes back to its first angle again and again."""
    span, turns = float(np.ptp(curve.angle)), reversals(curve.angle)
    back = np.abs(curve.angle[turns] - curve.angle[0]) <= SAME_PLACE * span
    if back.sum() < OFTEN:
        return None
    return Remark(
        "label",
        f"curve {curve.name!r} comes back to the angle where it began {back.sum()} times: if these "
        "are several measurements, give each its own label",
    )


def _turn(curve: Curve, place: Place) -> Remark | None:
    """Returns a remark where no sample is left of a time at a turn.

    A torque that jumps there shows that the joint went on. One that does not says nothing: loops
    may be as thin as the noise.
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
        where = f"between {place(at)} and {place(at + 1)}, where the motion turns, {late[at]:.3g} s"
        if steps[at] >= least:
            return Remark(
                "turn",
                f"{where} pass and the torque jumps by {steps[at]:.3g} N·m: record the turn too, "
                "or the whole time of a rest there",
            )
        away = rate * late[at] / 2
        if away >= AWAY * np.ptp(curve.angle):
            return Remark(
                "turn",
                f"{where} have no sample, and the joint could go on by {away:.2g} rad and come "
                "back: if it did not rest there, record the turn too",
            )
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
    return Remark(
        "clock",
        f"the clock jumps by {steps[at]:.3g} s between {place(at)} and {place(at + 1)}, "
        f"{steps[at] / np.median(steps):.0f} times the usual step, while the angle goes on as "
        "usual: repair the times, or leave the column time_s out",
    )


def _coarse(curve: Curve, place: Place) -> Remark | None:
    steps = np.abs(np.diff(curve.angle))
    at = int(np.argmax(steps))
    if steps[at] <= COARSE * np.ptp(curve.angle):
        return None
    return Remark(
        "coarse",
        f"samples of curve {curve.name!r} are up to {steps[at]:.2g} rad apart (at {place(at + 1)})"
        f", more than {COARSE:.0%} of its range, and the torque between them is unknown: sample "
        "finer",
    )


def _stepped(curve: Curve, _: Place) -> Remark | None:
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


def _noisy(curve: Curve, place: Place) -> Remark | None:
    if curve.angle.size < FEWEST or _stepped(curve, place) or _shuffled(curve, place):
        return None
    span, noise = float(np.ptp(curve.angle)), angle_noise(curve.angle)
    if noise <= NOISY * span:
        return None
    torque = angle_noise(curve.torque) / max(float(np.ptp(curve.torque)), np.finfo(float).tiny)
    if torque < SMOOTH * noise / span:
        return Remark(
            "exchanged",
            f"the angles of curve {curve.name!r} have a noise of {noise / span:.1%} of their "
            f"range, and the torques one of {100 * torque:.1g} %, though angles are measured "
            "better: check whether the columns of angle and torque are exchanged",
        )
    return Remark(
        "encoder",
        f"the angles of curve {curve.name!r} have a noise of {np.degrees(noise):.2g} degrees, "
        f"{noise / span:.1%} of its range, which the fit takes as motion: smooth the angle over "
        "time before the fit, or measure with a better encoder",
    )
