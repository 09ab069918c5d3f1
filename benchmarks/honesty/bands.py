"""How often bands of the method "auto" hold the torque of motions that were not measured."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...identification import Curve, first_order_motions, select
from ...identification import nested_motion as next_record
from ...identification.data.motions import MAX_RATE, MIN_RATE
from .truths import (
    NOISE,
    PEAK,
    STEP,
    TURNS,
    behind_gap,
    bouc_wen,
    bouc_wen_model,
    cubic,
    dead_zone,
    jiles_atherton,
    multi_order_motion,
    scaled,
)

RATE = math.sqrt(MIN_RATE * MAX_RATE)  # [rad/s], rate of first-order curves
LEAST_VISCOUS, MOST_VISCOUS = 0.02, 0.2  # share of the peak at the fastest rate
LEAST_GAP, MOST_GAP = 0.02, 0.06  # rad; more than a step between samples
TURNS_UNSEEN = 8

TimedTorque = Callable[[Array, Array], Array]


class Timed(NamedTuple):
    """A joint whose torque follows from angles [rad] and times [s], and the range of the rig."""

    torque: TimedTorque
    low: float
    high: float


def _static(draw: Callable) -> Callable[[np.random.Generator], Timed]:
    def timed(rng: np.random.Generator) -> Timed:
        truth = draw(rng)
        return Timed(lambda angle, _: truth.torque(angle), truth.low, truth.high)

    return timed


def viscous(rng: np.random.Generator) -> Timed:
    """Draws a Bouc-Wen model beside a linear damper."""
    truth, share = bouc_wen(rng), rng.uniform(LEAST_VISCOUS, MOST_VISCOUS)
    damping = share * PEAK / MAX_RATE

    def torque(angle: Array, time: Array) -> Array:
        rate = np.diff(angle) / np.diff(time)
        return truth.torque(angle) + damping * np.concatenate([rate[:1], rate])

    return Timed(torque, truth.low, truth.high)


def gap(rng: np.random.Generator) -> Timed:
    """Draws a Bouc-Wen model behind a gap: the contact opens where the torque is zero."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    model, width = bouc_wen_model(rng, low), rng.uniform(LEAST_GAP, MOST_GAP)
    truth = scaled(lambda angle: behind_gap(model, angle, width), low, high)
    return Timed(lambda angle, _: truth.torque(angle), low, high)


FAMILIES: dict[str, Callable[[np.random.Generator], Timed]] = {
    "Jiles-Atherton": _static(jiles_atherton),
    "Bouc-Wen": _static(bouc_wen),
    "dead zones": _static(dead_zone),
    "cubic": _static(cubic),
    "viscous": viscous,
    "gap": gap,
}


def band_case(family: str, seed: int) -> dict[str, Any]:
    """Returns which share of a random motion at random rates a nominal 90 % band holds.

    The curves are first-order curves and a nested record, without which there is no such band.
    """
    rng = np.random.default_rng([seed, 5, [*FAMILIES].index(family)])
    truth = FAMILIES[family](rng)
    curves = [*_first_order(truth, rng), _nested(truth, rng)]
    angle = multi_order_motion(truth.low, truth.high, turns=TURNS_UNSEEN, angle_step=STEP, rng=rng)
    rates = np.exp(rng.uniform(math.log(MIN_RATE), math.log(MAX_RATE), TURNS_UNSEEN + 1))
    time = _times(angle, rates)
    right = truth.torque(angle, time)
    fit = select(curves, seed=seed, workers=1)
    probe = Curve(angle, right, "probe", time=time)
    low, high = fit.band(probe)
    moved = np.abs(angle - angle[0]) > 5 * STEP
    error = (low + high) / 2 - right
    return {
        "inside": float(np.mean(((low <= right) & (right <= high))[moved])),
        "width": float(np.mean((high - low)[moved]) / 2 / NOISE),
        "error": float(np.sqrt(np.mean(error[moved] ** 2))) / NOISE,
    }


def _first_order(truth: Timed, rng: np.random.Generator) -> Iterator[Curve]:
    turns = np.linspace(truth.low, truth.high, TURNS + 1)[1:].tolist()
    motions = first_order_motions(turns, start_angle=truth.low, angle_step=STEP)
    for name, angle in motions.items():
        yield _measured(truth, name, angle, _times(angle, [RATE, RATE]), rng)


def _nested(truth: Timed, rng: np.random.Generator) -> Curve:
    record = next_record(truth.low, truth.high)
    angle = [np.array(record.points[:1])]
    for start, end in pairwise(record.points):
        angle.append(np.linspace(start, end, max(round(abs(end - start) / STEP), 1) + 1)[1:])
    motion = np.concatenate(angle)
    return _measured(truth, "nested", motion, _times(motion, record.rates), rng)


def _times(angle: Array, rates: Sequence[float] | Array) -> Array:
    """Returns the time of each sample [s], where each branch has its rate [rad/s]."""
    ways = np.diff(angle)
    branch = np.cumsum(np.concatenate([[0], np.sign(ways[1:]) != np.sign(ways[:-1])]))
    return np.concatenate([[0.0], np.cumsum(np.abs(ways) / np.asarray(rates)[branch])])


def _measured(
    truth: Timed, name: str, angle: Array, time: Array, rng: np.random.Generator
) -> Curve:
    torque = truth.torque(angle, time) + NOISE * rng.standard_normal(angle.size)
    return Curve(angle, torque, name, time=time)
