"""A synthetic measuring rig: known models, moved and measured like a joint."""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import at_least, number, numbers
from ..errors import InputError
from ..hysteresis import HysteresisModel
from ..hysteresis.protocol import finite_series
from .curves import Curve, Curves

LEAST_TRAVEL = 0.1  # least share of the range between two reversals of a random motion


def measure(
    model: HysteresisModel,
    motions: Mapping[str, ArrayLike],
    *,
    rng: int | np.random.Generator,
    initial_torque: float = 0.0,
    noise_fraction: float = 0.0,
    torque_resolution: float | None = None,
    angle_resolution: float | None = None,
    predict: Collection[str] = (),
) -> Curves:
    """Measures the torque of a model along motions, with the errors of sensors.

    The model moves through the exact angles. Then white noise is added to its torque, and last both
    sensors round to their resolution.

    Args:
        model: Any hysteresis model.
        motions: Angles [rad], shape (n,), by the name of their curve.
        rng: Seed or generator of the noise.
        initial_torque: Torque with which every motion begins [N·m].
        noise_fraction: Standard deviation of the noise over the largest |torque| of all motions.
        torque_resolution: Step of the torque sensor [N·m]; None measures all digits.
        angle_resolution: Step of the angle sensor [rad]; None measures all digits.
        predict: Names of the curves that get the role "predict".

    Returns:
        One curve per motion, in their order.

    Raises:
        InputError: There is no motion or no such name, a number is out of its range, or what is
            measured is no usable curve.
        PoleError: A motion meets the pole of an uncertified model.
    """
    if not motions:
        raise InputError("there is no motion: give at least one, by name")
    for name in predict:
        if name not in motions:
            raise InputError(f"predict names {name!r}: the motions are {', '.join(motions)}")
    if number("noise_fraction", noise_fraction) < 0:
        raise InputError(f"noise_fraction is {noise_fraction:g}: give 0 or more, as 0.01 for 1 %")
    rng = np.random.default_rng(rng)
    angles = {
        name: finite_series(f"motion {name!r}", angle, "rad") for name, angle in motions.items()
    }
    torques = {name: model.response(angle, initial_torque) for name, angle in angles.items()}
    noise = noise_fraction * max(np.abs(torque).max() for torque in torques.values())
    return Curves(
        Curve(
            angle=_rounded("angle_resolution", angles[name], angle_resolution, "rad"),
            torque=_rounded(
                "torque_resolution",
                torque + noise * rng.standard_normal(torque.size),
                torque_resolution,
                "N·m",
            ),
            name=name,
            role="predict" if name in predict else "fit",
        )
        for name, torque in torques.items()
    )


def first_order_motions(
    turns: Sequence[float], *, start_angle: float, angle_step: float
) -> dict[str, Array]:
    """Returns motions from one start to each turn and back, as first-order curves are measured.

    Args:
        turns: Angles of the reversals [rad].
        start_angle: Where every motion begins and ends [rad].
        angle_step: Step between samples, rounded so that it divides the way [rad].

    Returns:
        Angles [rad], shape (n,) each, by their turn with two decimals.
    """
    number("start_angle", start_angle, "rad")
    turns = numbers("turns", turns, "rad")
    motions = {
        f"{turn:.2f}": _through([start_angle, turn, start_angle], angle_step) for turn in turns
    }
    if len(motions) < len(turns):
        raise InputError(f"turns are {turns}: give turns that differ by 0.01 rad or more")
    return motions


def multi_order_motion(
    low: float, high: float, *, turns: int, angle_step: float, rng: int | np.random.Generator
) -> Array:
    """Returns a motion that reverses at random angles, so that curves of higher order are nested.

    It begins upwards at `low`. Every branch ends at an angle that is uniform over what its
    direction leaves of the range, at least 10 % of the range away.

    Args:
        low: Smallest angle [rad].
        high: Largest angle [rad].
        turns: Number of reversals, >= 2: the second one begins a curve of second order.
        angle_step: Step between samples, rounded so that it divides each branch [rad].
        rng: Seed or generator of the turns.

    Returns:
        Angles [rad], shape (n,).
    """
    if not number("low", low, "rad") < number("high", high, "rad"):
        raise InputError(f"the motion is from {low:g} to {high:g} rad: give low below high")
    at_least("turns", turns, 2)
    rng = np.random.default_rng(rng)
    least = LEAST_TRAVEL * (high - low)
    points = [low]
    for i in range(turns + 1):
        ahead = (points[-1] + least, high) if i % 2 == 0 else (low, points[-1] - least)
        points.append(rng.uniform(*ahead))
    return _through(points, angle_step)


def _through(points: Sequence[float], angle_step: float) -> Array:
    """Returns the angles of straight branches through `points`, each point once."""
    if number("angle_step", angle_step, "rad") <= 0:
        raise InputError(f"angle_step is {angle_step:g} rad: give a number above 0")
    angle = [np.array(points[:1], dtype=np.float64)]
    for start, end in pairwise(points):
        steps = max(round(abs(end - start) / angle_step), 1)
        angle.append(np.linspace(start, end, steps + 1)[1:])
    return np.concatenate(angle)


def _rounded(name: str, values: Array, resolution: float | None, unit: str) -> Array:
    if resolution is None:
        return values
    if not number(name, resolution, unit) > 0:
        raise InputError(f"{name} is {resolution:g} {unit}: give a number above 0, or None")
    return resolution * np.round(values / resolution)
