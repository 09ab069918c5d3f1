"""Joints that are drawn at random from broad families, and curves that are measured of them."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...hysteresis import BoucWen, Dahl, Duhem, JilesAtherton, PrandtlIshlinskii
from ...hysteresis.certificate import PoleError
from ...hysteresis.jiles_atherton.margins import margin_in_range
from ...hysteresis.protocol import HysteresisModel
from ...identification import Curve, first_order_motions
from ...identification.data.motions import through
from ...identification.fits.search import MARGIN
from ...identification.judging.noise import slow_noise

PEAK, NOISE, TURNS, STEP = 10.0, 0.1, 5, 0.015  # N·m, N·m, curves, rad
CYCLES = 8  # of a record that grows
LEAST_TRAVEL = 0.1  # least share of the range between two reversals of a random motion

Torque = Callable[[Array], Array]


class Truth(NamedTuple):
    """A joint that is measured: its torque along angles, and the range of the rig [rad]."""

    torque: Torque
    low: float
    high: float


def jiles_atherton(rng: np.random.Generator, kind: str = "certified", gap: float = 0.0) -> Truth:
    """Draws a Jiles-Atherton model: certified, safe in its range only, or near saturation.

    Args:
        rng: Generator of its numbers.
        kind: "certified", "uncertified" or "saturating".
        gap: Gap between the joint and the model [rad].
    """
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
        torque = partial(behind_gap, model, width=gap) if gap else model.response
        try:
            return scaled(torque, low, high)
        except PoleError:
            continue


def bouc_wen(rng: np.random.Generator) -> Truth:
    """Draws a Bouc-Wen model with A = 1 that dissipates."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    return scaled(bouc_wen_model(rng, low).response, low, high)


def bouc_wen_model(rng: np.random.Generator, low: float) -> BoucWen:
    """Draws the model of `bouc_wen`, which begins at its lowest angle; its torque is not scaled."""
    n = rng.uniform(1, 3)
    beta = math.exp(rng.uniform(1, 3) * n)
    gamma, elastic = rng.uniform(-0.9, 0.9) * beta, rng.uniform(0.05, 0.8)
    return BoucWen(elastic=elastic, hysteretic=1.0, beta=beta, gamma=gamma, n=n, rest_angle=low)


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

    return scaled(torque, low, high)


def cubic(rng: np.random.Generator) -> Truth:
    """Draws a Bouc-Wen model with a cubic spring beside it."""
    truth, bend = bouc_wen(rng), rng.uniform(0.2, 1.0)

    def torque(angle: Array) -> Array:
        return truth.torque(angle) + PEAK * bend * (angle - truth.low) ** 3

    return scaled(torque, truth.low, truth.high)


def dahl(rng: np.random.Generator) -> Truth:
    """Draws a Dahl friction beside an exponential spring."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    stiffness, friction, rise = rng.uniform(5, 40), rng.uniform(0.2, 1.0), rng.uniform(0.5, 3)
    model = Dahl(spring=(0.0,), stiffness=stiffness, friction=friction)

    def torque(angle: Array) -> Array:
        spring = np.expm1(rise * (angle - low)) / np.expm1(rise * (high - low))
        return model.response(angle) + 2 * spring

    return scaled(torque, low, high)


def duhem(rng: np.random.Generator) -> Truth:
    """Draws a Duhem model whose ways up and down are unlike, beside a spring.

    Upwards z approaches one limit at one rate over the angle, downwards another at another rate
    (Macki, Nistri and Zecca 1993, SIAM Review 35, 94).
    """
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    rate = np.exp(rng.uniform(1, 3, 2))
    limit = rng.uniform(0.3, 1.0, 2) * (1, -1)
    elastic = rng.uniform(0.5, 2)
    model = semilinear(rate, limit, (-elastic * low, elastic))
    return scaled(model.response, low, high)


def semilinear(rate: Array, limit: Array, spring: tuple[float, float]) -> Duhem:
    """Returns the model of a torque with one limit upwards and another limit downwards.

        T = p(theta) + y,    dy = rate[0] (limit[0] - y) dtheta   upwards
                             dy = rate[1] (y - limit[1]) dtheta   downwards

    The spring has the constant and the slope of p. Both slopes of y are equal at y0 = (rate[0]
    limit[0] + rate[1] limit[1]) / (rate[0] + rate[1]), between the limits. With z = y - y0, and y0
    as a part of the spring, the limits of z have opposite signs.
    """
    width = limit[0] - limit[1]
    up = rate[1] / (rate[0] + rate[1]) * width
    return Duhem(
        spring=(spring[0] + limit[0] - up, spring[1]),
        stiffness=rate[0] * up,
        friction_up=up,
        friction_down=width - up,
    )


def pinched(rng: np.random.Generator) -> Truth:
    """Draws stops whose loops are narrow around one angle, as in joints that slip."""
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    span = high - low
    stops = PrandtlIshlinskii(
        stiffness=0.0,
        thresholds=(span * np.linspace(0.05, 0.6, 6)).tolist(),
        weights=rng.dirichlet(np.ones(6)).tolist(),
        rest_angle=low,
    )
    middle, width = low + span * rng.uniform(0.3, 0.7), span * rng.uniform(0.1, 0.25)
    depth, elastic = rng.uniform(0.4, 0.8), rng.uniform(0.1, 0.5)

    def torque(angle: Array) -> Array:
        narrow = 1 - depth * np.exp(-(((angle - middle) / width) ** 2))
        return stops.response(angle) * narrow + elastic * (angle - low)

    return scaled(torque, low, high)


def fractional(rng: np.random.Generator) -> Truth:
    """Draws a spring beside a spring-pot at one rate: a derivative of order 0.1 to 0.5.

    By the differences of Gruenwald and Letnikov; the time of one step of the rig is the unit.
    """
    low, high = rng.uniform(0.2, 0.6), rng.uniform(1.4, 1.9)
    order, elastic, pot = rng.uniform(0.1, 0.5), rng.uniform(0.2, 1), rng.uniform(0.5, 2)

    def torque(angle: Array) -> Array:
        count = np.arange(1, angle.size)
        weights = np.concatenate([[1.0], np.cumprod(1 - (order + 1) / count)])
        step = float(np.median(np.abs(np.diff(angle)))) / STEP
        moved = np.convolve(angle - low, weights)[: angle.size] / step**order
        return elastic * (angle - low) + pot * moved

    return scaled(torque, low, high)


def behind_gap(model: HysteresisModel, angle: Array, width: float) -> Array:
    """Returns the torque of a model that a joint moves through a gap [N·m], shape (n,).

    The joint begins in contact, which pushes the model upwards. Each contact only pushes: where the
    torque that it transmits is zero it opens, the model rests, and the joint is free for `width`.
    """
    torque, state, contact = np.zeros(angle.size), model.start(float(angle[0])), 0
    rest = float(angle[0])  # angle of the model; the joint is free from there to `width` below
    for i, here in enumerate(angle[1:].tolist(), 1):
        if contact == 0:
            contact = 1 if here > rest else -1 if here < rest - width else 0
        if contact == 0:
            continue
        towards = here if contact > 0 else here + width
        moved, found = model.step(state, towards)
        if contact * found < 0 and contact * (towards - rest) < 0:  # it opens on the way
            before = float(torque[i - 1])
            towards = rest + (towards - rest) * before / (before - found)
            moved, _ = model.step(state, towards)
            contact, found = 0, 0.0
        state, rest = moved, towards
        torque[i] = contact * max(contact * found, 0.0)
    return torque


KINDS: dict[str, Callable[[np.random.Generator], Truth]] = {
    "Jiles-Atherton": jiles_atherton,
    "Bouc-Wen": bouc_wen,
    "dead zones": dead_zone,
    "cubic": cubic,
    "Dahl": dahl,
    "Duhem": duhem,
    "pinched": pinched,
    "fractional": fractional,
}


def scaled(torque: Torque, low: float, high: float) -> Truth:
    """Returns a joint whose largest torque is 10 N·m on the way over its range and back."""
    way = next(iter(first_order_motions([high], start_angle=low, angle_step=STEP).values()))
    size = PEAK / np.abs(torque(way)).max()
    return Truth(lambda angle: size * torque(angle), low, high)


def measured(
    truth: Truth,
    noise: tuple[float, float],
    rng: np.random.Generator,
    *,
    size: float = NOISE,
    share: float = 0.0,
    repeats: int = 1,
    record: bool = False,
) -> list[Curve]:
    """Returns measured curves with noise.

    Args:
        truth: Joint.
        noise: Correlation of slow noise from sample to sample, and share of white noise.
        rng: Generator of the noise.
        size: Standard deviation of the noise without torque [N·m].
        share: Part of that deviation in proportion to the torque, as a share of it.
        repeats: Number of times that each curve is measured.
        record: Whether it is one record of growing cycles instead of first-order curves.
    """
    motions = {"record": growing(truth)} if record else first_order(truth)
    memory, white = noise
    curves = []
    for i in range(repeats):
        for name, angle in motions.items():
            slow = math.sqrt(1 - white) * slow_noise(angle.size, memory, rng)
            drawn = slow + math.sqrt(white) * rng.standard_normal(angle.size)
            torque = truth.torque(angle)
            noisy = torque + np.hypot(size, share * torque) * drawn
            curves.append(Curve(angle, noisy, f"{name}-{i}"))
    return curves


def first_order(truth: Truth) -> dict[str, Array]:
    """Returns the motions of first-order curves over the range of a joint, by name."""
    turns = np.linspace(truth.low, truth.high, TURNS + 1)[1:].tolist()
    return first_order_motions(turns, start_angle=truth.low, angle_step=STEP)


def growing(truth: Truth) -> Array:
    """Returns a motion to the middle of the range, then of cycles each larger than the last."""
    middle, most = (truth.low + truth.high) / 2, (truth.high - truth.low) / 2
    sizes = most * np.linspace(0.15, 1, CYCLES)
    turns = [middle + way * size for size in sizes.tolist() for way in (1, -1)]
    return through([truth.low, *turns], STEP)


def multi_order_motion(
    low: float, high: float, *, turns: int, angle_step: float, rng: np.random.Generator
) -> Array:
    """Returns a motion that reverses at random angles, so that curves of higher order are nested.

    The motion begins upwards at `low`. The end of each branch is uniform over the angles ahead in
    the range, at least 10 % of the range away. The result has a step of about `angle_step` [rad],
    shape (n,).
    """
    least, points = LEAST_TRAVEL * (high - low), [low]
    for i in range(turns + 1):
        ahead = (points[-1] + least, high) if i % 2 == 0 else (low, points[-1] - least)
        points.append(rng.uniform(*ahead))
    return through(points, angle_step)
