"""A hysteresis model from outside the package: a spring beside a spring with one slider.

It is written as a user would write it, with its kernels in the same module.
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from activesuit.errors import InputError
from activesuit.hysteresis import Certificate, ConfigKey, HysteresisModel
from numba import njit
from scipy.optimize import least_squares


@njit(cache=True)
def begin(p, s, angle, torque):
    s[0], s[1], s[2] = angle, torque, 0.0
    s[3] = angle - (torque - p[0] * angle) / p[1]  # where the slider's spring is relaxed
    return p[2] - abs(torque - p[0] * angle)


@njit(cache=True)
def travel(p, s, angle):
    stretch = min(max(angle - s[3], -p[2] / p[1]), p[2] / p[1])
    return p[0] * angle + p[1] * stretch, p[2] * abs(angle - stretch - s[3]), angle - stretch


@njit(cache=True)
def move(p, s, angle):
    torque, loss, _ = travel(p, s, angle)
    return torque, loss


@njit(cache=True)
def commit(p, s, angle):
    if angle == s[0]:
        return s[1]
    torque, loss, relaxed = travel(p, s, angle)
    if not math.isnan(torque):
        s[0], s[1], s[3] = angle, torque, relaxed
        s[2] += loss
    return torque


@njit(cache=True)
def stiffness(p, s, angle, torque, delta):
    return p[0] + (p[1] if delta * (torque - p[0] * angle) < p[2] else 0.0)


@njit(cache=True)
def stored(p, s, angle, torque, loss):
    return 0.5 * p[0] * angle**2 + 0.5 * (torque - p[0] * angle) ** 2 / p[1]


@njit(cache=True)
def dissipated(p, s, angle, torque, loss):
    return s[2] + loss


@njit(cache=True)
def memory_size(total):
    return 4


@njit(cache=True)
def is_sound(p):
    return p[1] > 0 and p[2] > 0


@dataclass(frozen=True, kw_only=True)
class MaxwellSlip(HysteresisModel):
    name: ClassVar[str] = "maxwell-slip"
    kernels = sys.modules[__name__]
    config_keys: ClassVar[tuple[ConfigKey, ...]] = tuple(
        map(ConfigKey, ("elastic", "spring", "limit"))
    )
    units: ClassVar[dict] = {"elastic": "N·m/rad", "spring": "N·m/rad", "limit": "N·m"}

    elastic: float
    spring: float
    limit: float

    def __post_init__(self):
        super().__post_init__()
        for name in ("spring", "limit"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} is {getattr(self, name)}: a slider needs more than 0")

    def certificate(self, angle_range=(-math.inf, math.inf)):
        return Certificate(
            margin=1.0, dissipative=True, torque_bound=math.inf, angle_range=tuple(angle_range)
        )


def fit_maxwell_slip(curves: Sequence) -> MaxwellSlip:
    """A fit as a user would write it: least squares from a guess."""
    peak = max(float(np.abs(curve.torque).max()) for curve in curves)

    def model(point):
        elastic, spring, limit = np.exp(point).tolist()
        return MaxwellSlip(elastic=elastic, spring=spring, limit=limit)

    def errors(point):
        slip = model(point)
        elastic = slip.elastic * curves[0].angle[0]
        start = np.mean([curve.torque[0] for curve in curves])
        start = float(np.clip(start, elastic - slip.limit, elastic + slip.limit))
        return np.concatenate([slip.response(one.angle, start) - one.torque for one in curves])

    found = least_squares(errors, np.log([peak, 5 * peak, 0.3 * peak]))
    return model(found.x)
