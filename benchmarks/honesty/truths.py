"""Joints that are drawn at random from broad families, and curves that are measured of them."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...hysteresis import BoucWen, JilesAtherton, PrandtlIshlinskii
from ...hysteresis.certificate import PoleError
from ...hysteresis.jiles_atherton.margins import margin_in_range
from ...hysteresis.protocol import HysteresisModel
from ...identification import Curve, first_order_motions
from ...identification.fits.search import MARGIN
from ...identification.residual.noise import slow_noise

PEAK, NOISE, TURNS, STEP = 10.0, 0.1, 5, 0.015  # N·m, N·m, curves, rad

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
    repeats: int = 1,
) -> list[Curve]:
    """Returns first-order curves with noise.

    Args:
        truth: Joint.
        noise: Correlation of slow noise from sample to sample, and share of white noise.
        rng: Generator of the noise.
        size: Standard deviation of the noise [N·m].
        repeats: Number of times that each curve is measured.
    """
    turns = np.linspace(truth.low, truth.high, TURNS + 1)[1:].tolist()
    motions = first_order_motions(turns, start_angle=truth.low, angle_step=STEP)
    memory, white = noise
    curves = []
    for i in range(repeats):
        for name, angle in motions.items():
            slow = math.sqrt(1 - white) * slow_noise(angle.size, memory, rng)
            drawn = slow + math.sqrt(white) * rng.standard_normal(angle.size)
            curves.append(Curve(angle, truth.torque(angle) + size * drawn, f"{name}-{i}"))
    return curves
