"""The strength of the wearer at each joint, and the passive torque of the joints.

Every joint has two muscle groups, which pull toward negative angles (extension, adduction) and
toward positive ones (flexion, abduction). Each gives

    torque = peak · exp(-((angle - best_angle) / width)² / 2) · hill(speed / fastest)

after Millard's torque muscles in RBDL. Their angles are "anatomical", which we take as our
convention: zero with the arm hanging, elbow and wrist straight, flexion positive. Their passive
torques are consistent with no other: the flexors of the shoulder tighten behind the body, its
extensors overhead, those of the elbow near 150 degrees, and its flexors when it is straight.

Their data are of one elite gymnast, whose elbow flexors are almost as strong straight as bent, and
whose shoulder flexors are strongest at 51 degrees, unlike those of other people.

The flexors of the shoulder are fitted to two studies: static torque at 0 and 45 degrees and torque
at 50 degrees/s of 26 men (McGill et al. 1994), and at 90 degrees the share of a man's strength that
supports the bare arm (96 men and 83 furniture removers). The studies do not contradict each other,
as they measured at different angles; but torque falls almost evenly from 0 to 90 degrees, and no
curve with its peak inside the range does so. The best angle is therefore put at the end of the
range, and peak and width are the least squares of the logarithms: -1.6, +2.7 and -1.1 % at 0, 45
and 90 degrees, less than a standard error of the mean of 26 men at the spread below, 3.7 %. Both
torques at speed are met with the gymnast's fastest speed, but not with the torque at half of it.
Beyond 50 degrees/s no data were read: Hill's hyperbola leaves a third of static torque at 180
degrees/s, a fifth at 300.
"""

# pyright: reportCallIssue=false, reportFunctionMemberAccess=false, reportGeneralTypeIssues=false

import math
from math import exp, log, sqrt
from statistics import NormalDist

import numpy as np
from numba import guvectorize, njit
from numpy.typing import ArrayLike

from ...arrays import Array
from ...assets import JOINTS
from ..provenance import Grade, Quantity
from .anthropometry import Person


@njit(cache=True)
def velocity_factor(shortening: float, hill: float, gain: float, knee: float) -> float:
    """Returns torque / isometric torque at a shortening speed, given over the fastest speed.

    Hill's hyperbola through (0, 1), (1/2, half_speed) and (1, 0), and for lengthening another one
    that leaves (0, 1) with the same slope and meets (-1, eccentric); constant beyond both ends.
    """
    if shortening >= 0.0:
        shorter = min(shortening, 1.0)
        return (1.0 - shorter) / (1.0 + shorter / hill)
    longer = min(-shortening, 1.0)
    return 1.0 + gain * (1.0 + knee) * longer / (longer + knee)


@njit(cache=True)
def group_torque(
    isometric: float,
    angle: float,
    speed: float,
    fastest: float,
    best_angle: float,
    width: float,
    hill: float,
    gain: float,
    knee: float,
) -> float:
    """Returns the greatest torque of a muscle group that shortens at `speed` [rad/s]."""
    offset = (angle - best_angle) / width
    strength = isometric * math.exp(-offset * offset / 2.0)
    return strength * velocity_factor(speed / fastest, hill, gain, knee)


@guvectorize(
    "void(f8[:,:], f8[:], f8[:], f8[:,:,:], f8[:], f8[:])",
    "(g,j),(j),(j),(c,g,j)->(j),(j)",
    cache=True,
)
def _limits_of(isometric, angle, rate, groups, low, high):
    """Computes the least and the greatest torque at every joint, in place.

    `groups` contains these values in turn: fastest speed, best angle, width, and the three shape
    parameters of `velocity_factor`.
    """
    for joint in range(angle.shape[0]):
        for way in range(2):
            fastest, best_angle, width, hill, gain, knee = groups[:, way, joint]
            torque = group_torque(
                isometric[way, joint],
                angle[joint],
                rate[joint] if way == 1 else -rate[joint],
                fastest,
                best_angle,
                width,
                hill,
                gain,
                knee,
            )
            if way == 1:
                high[joint] = torque
            else:
                low[joint] = -torque


# Called through NumPy, since a call of numba's own object takes longer than the computation.
limits = _limits_of.ufunc


DIRECTIONS = ("negative", "positive")

_Source = tuple[str, Grade]
_COLUMNS = (
    ("peak", "N·m"),
    ("fastest", "rad/s"),
    ("best_angle", "rad"),
    ("width", "rad"),
    ("eccentric", "1"),
    ("half_speed", "1"),
    ("passive_from", "rad"),
    ("passive_peak", "rad"),
)
_GYMNAST: _Source = ("RBDL, Millard2016TorqueMuscle, data set Gymnast, one man", "transcribed")
_SCALED: _Source = ("a man of 80 kg; about 0.7 times the gymnast of RBDL", "assumed")
_MCGILL = "McGill et al. 1994, Clin. Biomech., abstract, 26 men"
_STATIC: _Source = (
    f"{_MCGILL}: 89.9 N·m at 0 and 68.6 N·m at 45 degrees; and 'Isometric strength in flexors, "
    "abductors, and external rotators of the shoulder', abstract, 179 men: the bare arm takes 22 "
    "to 25 % of strength at 90 degrees, 50.3 N·m in the middle for the 11.82 N·m of our arm; "
    "least squares of the logarithms",
    "derived",
)
_RANGE_END: _Source = ("end of the range, -62 degrees; a better fit has it farther", "derived")
_AT_SPEED: _Source = (
    f"{_MCGILL}: 46.9 N·m shortening and 75.3 N·m lengthening at 45 degrees and 50 degrees/s",
    "derived",
)
_MOMENT_ARMS: _Source = (
    "half of the peak at full extension: there the moment arms of brachialis, biceps and "
    "brachioradialis are 0.56, 0.42 and 0.37 of those at 90 degrees (polynomials at biomed.bas.bg, "
    "MuscleArms); lengths of the muscles neglected",
    "derived",
)
_BENT: _Source = ("a right angle, as textbooks have it; moment arms peak at 103 to 137", "assumed")
_LIKE_FLEXORS: _Source = ("like the shoulder's flexors", "assumed")
_LIKE_EXTENSORS: _Source = ("like the shoulder's extensors", "assumed")


def _group(
    name: str, values: tuple[float, ...], shape: _Source, **other: _Source
) -> list[Quantity]:
    """The quantities of a muscle group, in the order of `_COLUMNS`."""
    return [
        Quantity(f"strength.{name}.{column}", value, unit, *other.get(column, shape))
        for (column, unit), value in zip(_COLUMNS, values, strict=True)
    ]


# Peak and speed [N·m, rad/s]; best angle and width [rad]; the factors of torque at fastest
# lengthening and at half of fastest shortening; where passive torque begins and equals the peak.
_GROUPS = (
    _group(
        "shoulder_abduction.negative",
        (70, 16.2, 2.147, 1.831, 1.10, 0.250, 2.829, 3.558),
        _LIKE_EXTENSORS,
        peak=("Holzbaur et al. 2007: 67.9 N·m, the mean of 10 adults; rounded", "assumed"),
    ),
    _group(
        "shoulder_abduction.positive",
        (55, 19.1, -0.180, 1.831, 1.079, 0.087, -0.524, -1.047),
        _LIKE_FLEXORS,
        peak=("between half of adduction (Ivey et al. 1985) and all of it", "assumed"),
        best_angle=("a little behind the hanging arm", "assumed"),
        width=("0.63 of the peak at 90 degrees", "assumed"),
    ),
    _group(
        "shoulder_flexion.negative",
        (85, 16.2, 2.147, 1.831, 1.10, 0.250, 2.829, 3.558),
        _GYMNAST,
        peak=_SCALED,
    ),
    _group(
        "shoulder_flexion.positive",
        (99.2, 19.1, -1.082, 2.259, 1.079, 0.087, -0.524, -1.047),
        _GYMNAST,
        peak=_STATIC,
        best_angle=_RANGE_END,
        width=_STATIC,
        eccentric=_AT_SPEED,
        half_speed=_AT_SPEED,
    ),
    _group(
        "elbow_flexion.negative",
        (52, 18.5, 1.643, 1.308, 1.32, 0.190, 2.094, 2.618),
        _GYMNAST,
        peak=_SCALED,
    ),
    _group(
        "elbow_flexion.positive",
        (70, 18.1, 1.571, 1.334, 1.37, 0.190, 0.0, -0.175),
        _GYMNAST,
        peak=_SCALED,
        best_angle=_BENT,
        width=_MOMENT_ARMS,
    ),
    _group(
        "wrist_flexion.negative",
        (10, 36.5, 1.553, 1.389, 1.17, 0.115, 1.047, 1.571),
        _GYMNAST,
        peak=("Holzbaur et al. 2007: 10.2 N·m, the mean of 10 adults; rounded", "assumed"),
    ),
    _group(
        "wrist_flexion.positive",
        (18, 36.4, 0.663, 1.710, 1.14, 0.115, -0.794, -1.497),
        _GYMNAST,
        peak=("extension times 12.2 / 7.1 of Delp et al. 1996, 10 men; rounded up", "assumed"),
    ),
)

_REFERENCE_MASS = Quantity("strength.male.mass", 80.0, "kg", "the man of the peaks", "assumed")
_FEMALE = Quantity(
    "strength.female.ratio",
    0.55,
    "1",
    "average woman to average man; shoulders of 20 and 20 gave 0.5, Clin. Biomech. 1989",
    "assumed",
)
_SPREAD = Quantity(
    "strength.coefficient_of_variation",
    0.187,
    "1",
    "Lategan and Krüger 2003: elbow extension per body mass of 199 men, 67 with SD 12.5",
    "derived",
)

_WIEGNER = "Wiegner and Watts 1986, J. Neurol. Neurosurg. Psychiatry 49, 19 people"
_VISCOSITY = "0.5 for forearm rotation and 0.25 for the wrist in MyoSuite; ours by size"
# Of elastic torques in the middle of the range, only the elbow's is known; that of the wrist is
# near zero in its central 150 degrees (Delp et al. 1996, 10 men).
_PASSIVE = (
    Quantity("passive.shoulder_abduction.viscosity", 0.5, "N·m·s/rad", _VISCOSITY, "assumed"),
    Quantity("passive.shoulder_flexion.viscosity", 0.5, "N·m·s/rad", _VISCOSITY, "assumed"),
    Quantity("passive.elbow_flexion.viscosity", 0.3, "N·m·s/rad", _VISCOSITY, "assumed"),
    Quantity("passive.wrist_flexion.viscosity", 0.1, "N·m·s/rad", _VISCOSITY, "assumed"),
    Quantity(
        "passive.elbow_flexion.stiffness",
        1.1,
        "N·m/rad",
        f"{_WIEGNER}: middle of 0.40 to 1.8",
        "derived",
    ),
    Quantity(
        "passive.elbow_flexion.rest",
        1.274,
        "rad",
        f"{_WIEGNER}: 107 degrees, read as the angle between the bones",
        "derived",
    ),
)

PROVENANCE: tuple[Quantity, ...] = (
    *(quantity for group in _GROUPS for quantity in group),
    _REFERENCE_MASS,
    _FEMALE,
    _SPREAD,
    *_PASSIVE,
)


def _column(name: str) -> Array:
    """Returns one quantity of all muscle groups, shape (2, 4): `DIRECTIONS` and `JOINTS`."""
    value = {quantity.name: quantity.value for quantity in PROVENANCE}
    return np.array(
        [[value[f"strength.{joint}.{way}.{name}"] for joint in JOINTS] for way in DIRECTIONS]
    )


def _passive(what: str) -> Array:
    value = {quantity.name: quantity.value for quantity in _PASSIVE}
    return np.array([value.get(f"passive.{joint}.{what}", 0.0) for joint in JOINTS])


_GROUP = {name: _column(name) for name, _ in _COLUMNS}
_HILL = _GROUP["half_speed"] / (1 - 2 * _GROUP["half_speed"])
_GAIN = _GROUP["eccentric"] - 1
_KNEE = _GAIN / (1 + 1 / _HILL - _GAIN)
SHAPE = np.stack([_GROUP[name] for name in ("fastest", "best_angle", "width")])
SHAPE = np.concatenate([SHAPE, [_HILL, _GAIN, _KNEE]])
_STIFFNESS, _REST, _DAMPING = _passive("stiffness"), _passive("rest"), _passive("viscosity")


def isometric_strength(person: Person) -> Array:
    """Returns the greatest torque of every muscle group at its best angle and rest [N·m].

    It is proportional to body mass (Jaric 2002, Sports Med. 32(10), for torque), log-normal among
    people of one sex and mass, and for an average woman 0.55 of that of an average man. With much
    body fat the real increase is smaller (Folland et al. 2008).

    `numpy.stack` the strengths of several people to compute with all of them at once.

    Returns:
        The torques, shape (2, 4), all positive: the groups that pull toward negative and toward
        positive angles, and the joints of `JOINTS`.
    """
    relative_mass = person.mass / _REFERENCE_MASS.value
    if person.sex == "female":
        averages = [Person.percentile(sex, 50).mass for sex in ("male", "female")]
        relative_mass *= _FEMALE.value * averages[0] / averages[1]
    spread = sqrt(log(1 + _SPREAD.value**2))
    rank = NormalDist().inv_cdf(person.strength / 100)
    return _GROUP["peak"] * relative_mass * exp(spread * rank)


def strength_limits(isometric: Array, angle: ArrayLike, rate: ArrayLike) -> tuple[Array, Array]:
    """Returns the least and the greatest torque that the wearer can give at every joint [N·m].

    Args:
        isometric: Torques from `isometric_strength`, shape (2, 4), or (..., 2, 4) for several
            wearers.
        angle: Joint angles in the order of `JOINTS` [rad], shape (..., 4).
        rate: Joint rates [rad/s], shape (..., 4).

    Returns:
        low: least torque, at most zero, shape (..., 4).
        high: greatest torque, at least zero, shape (..., 4).
    """
    return limits(isometric, angle, rate, SHAPE)


def passive_torque(isometric: Array, angle: ArrayLike, rate: ArrayLike) -> Array:
    """Returns the torque on every joint of the relaxed arm [N·m], without gravity.

    Near the ends of the range the muscle that is stretched pulls back with
    peak · ((angle - passive_from) / (passive_peak - passive_from))². This stiffens to 800 N·m/rad
    at the elbow, so evaluate it in every physics step.

    Args:
        isometric: Torques from `isometric_strength`, shape (2, 4), or (..., 2, 4) for several
            wearers.
        angle: Joint angles in the order of `JOINTS` [rad], shape (..., 4).
        rate: Joint rates [rad/s], shape (..., 4).

    Returns:
        The torque, shape (..., 4).
    """
    angle, rate = np.asarray(angle), np.asarray(rate)
    begin = _GROUP["passive_from"]
    stretch = (angle[..., None, :] - begin) / (_GROUP["passive_peak"] - begin)
    pull = isometric * np.maximum(stretch, 0) ** 2
    return pull[..., 1, :] - pull[..., 0, :] - _STIFFNESS * (angle - _REST) - _DAMPING * rate
