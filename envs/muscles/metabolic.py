"""Metabolic power of muscles: heat and work, after Umberger 2010 and Bhargava et al. 2004.

Both add heat of activation and maintenance, heat of shortening or lengthening, and mechanical work.
No muscle has less heat than 1 W/kg, and negative work gives nothing back. The models differ in how
heat depends on activation and speed. The papers themselves were not at hand: equations and
constants are those that OpenSim documents for its probes of both models
(opensim-core, Apache-2.0: the headers of Umberger2010MuscleMetabolicsProbe and
Bhargava2004MuscleMetabolicsProbe), with the options that its documentation names "as published":
the share of slow fibres does not change with activation, negative work does not count, and
lengthening heat has the coefficient 0.3.

Excitation and activation are taken as equal. Tendons are rigid, as in MuJoCo's muscles.
"""

from collections.abc import Callable

import numpy as np

from ...arrays import Array
from ..provenance import numbers_of, values_of
from .myoarm import Geometry, MyoArm

PROVENANCE = numbers_of("metabolic")


def _values(group: str) -> dict[str, float]:
    """Returns the numbers of a model, or all numbers, by their last names."""
    found = values_of(PROVENANCE).items()
    return {n.removeprefix(group): value for n, value in found if n.startswith(group)}


_ALL, _U, _B = map(_values, ("metabolic.", "metabolic.umberger.", "metabolic.bhargava."))
_LENGTHS = (0.0, 0.5, 1.0, 1.5)  # over optimal length
_SHARES = [_B[f"maintenance.at_{length:g}_of_optimal_length"] for length in _LENGTHS]
_SLOW = _ALL["slow_fibres"]
LEAST_HEAT = _ALL["least_heat"]
"""Least heat of a muscle [W/kg]: that of a muscle at rest."""


def muscle_masses(arm: MyoArm) -> Array:
    """Returns the mass of each muscle of the average man [kg], shape (muscles,).

    The mass is peak force over specific tension, times optimal length, times density.
    """
    return arm.peak / _ALL["specific_tension"] * arm.optimal * _ALL["density"]


def umberger(arm: MyoArm, geometry: Geometry, activation: Array) -> Array:
    """Returns the metabolic power of each muscle after Umberger (2010) [W].

    The heat per kilogram is (25 + 128 fast) a^0.6 of activation and maintenance, plus heat of
    shortening in proportion to a² and speed, or heat of lengthening in proportion to a and speed.
    All heats are less where the fibres are longer than optimal, and times 1.5 for aerobic work.
    Activations a and power have the shape (samples, muscles).
    """
    fast, long, share = 1 - _SLOW, geometry.length > 1, geometry.isometric / arm.peak
    active = (_U["active"] + _U["active.fast"] * fast) * activation ** _U["active.exponent"]
    active = active * np.where(long, 1 - _U["active.share_of_force"] * (1 - share), 1)
    shortening = np.maximum(-geometry.speed, 0) / arm.optimal / arm.fastest
    lengthening = np.maximum(geometry.speed, 0) / arm.optimal / arm.fastest
    slow_rate = _U["shortening.slow"] * _U["shortening.slower"]
    slow = np.minimum(slow_rate * shortening, _U["shortening.slow"])
    moving = activation**2 * (_SLOW * slow + fast * _U["shortening.fast"] * shortening)
    moving = moving + activation * _U["lengthening"] * slow_rate * lengthening
    heat = _U["aerobic"] * (active + moving * np.where(long, share, 1))
    return _with_work(arm, geometry, activation, muscle_masses(arm) * heat)


def bhargava(arm: MyoArm, geometry: Geometry, activation: Array) -> Array:
    """Returns the metabolic power of each muscle after Bhargava et al. (2004) [W].

    Slow fibres are recruited as sin(pi a / 2), fast fibres as 1 - cos(pi a / 2). The heat of
    shortening is (0.16 isometric force + 0.18 force) speed. In lengthening the heat is less by
    0.157 of the work that is done on the muscle.
    Activations a and power have the shape (samples, muscles).
    """
    slow = _SLOW * np.sin(np.pi / 2 * activation)
    fast = (1 - _SLOW) * (1 - np.cos(np.pi / 2 * activation))
    active, maintained = (
        _B[f"{kind}.slow"] * slow + _B[f"{kind}.fast"] * fast
        for kind in ("activation", "maintenance")
    )
    heat = active + np.interp(geometry.length, _LENGTHS, _SHARES) * maintained
    force = activation * geometry.full
    shortening = _B["shortening.isometric"] * activation * geometry.isometric
    shortening = shortening + _B["shortening.force"] * force
    moving = np.where(geometry.speed <= 0, shortening, _B["lengthening.force"] * force)
    power = muscle_masses(arm) * heat - moving * geometry.speed
    return _with_work(arm, geometry, activation, power)


def _with_work(arm: MyoArm, geometry: Geometry, activation: Array, heat: Array) -> Array:
    least = LEAST_HEAT * muscle_masses(arm)
    work = activation * geometry.full * np.maximum(-geometry.speed, 0)
    return np.maximum(heat, least) + work


MODELS: dict[str, Callable[[MyoArm, Geometry, Array], Array]] = {
    "Umberger 2010": umberger,
    "Bhargava 2004": bhargava,
}
"""Models of metabolic power, by author and year."""
