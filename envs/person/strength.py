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
from ..provenance import numbers_of, values_of
from .anthropometry import Person


@njit(cache=True)
def velocity_factor(shortening: float, hill: float, gain: float, knee: float) -> float:
    """Returns torque / isometric torque at a shortening speed over the fastest speed.

    The factor is Hill's hyperbola through (0, 1), (1/2, half_speed) and (1, 0). For lengthening,
    another hyperbola leaves (0, 1) with the same slope and meets (-1, eccentric). The factor is
    constant beyond both ends.
    """
    if shortening >= 0.0:
        shorter = min(shortening, 1.0)
        return (1.0 - shorter) / (1.0 + shorter / hill)
    longer = min(-shortening, 1.0)
    return 1.0 + gain * (1.0 + knee) * longer / (longer + knee)


@njit(cache=True)
def group_torque(
    isometric: float, angle: float, speed: float, shape: Array, way: int, joint: int
) -> float:
    """Returns the greatest torque of a muscle group that shortens at a speed [N·m].

    `isometric` is the isometric torque of the group [N·m]; `angle` and `speed` are in rad and
    rad/s. `shape` has the fastest speed, best angle, width, and the three parameters of
    `velocity_factor` of all groups, shape (6, 2, 4); `way` and `joint` are numbers in `DIRECTIONS`
    and `JOINTS`.
    """
    offset = (angle - shape[1, way, joint]) / shape[2, way, joint]
    strength = isometric * math.exp(-offset * offset / 2.0)
    hill, gain, knee = shape[3, way, joint], shape[4, way, joint], shape[5, way, joint]
    return strength * velocity_factor(speed / shape[0, way, joint], hill, gain, knee)


@guvectorize(
    "void(f8[:,:], f8[:], f8[:], f8[:,:,:], f8[:], f8[:])",
    "(g,j),(j),(j),(c,g,j)->(j),(j)",
    cache=True,
)
def _limits_of(isometric, angle, rate, groups, low, high):
    """Computes the least and the greatest torque at every joint, in place."""
    for j in range(angle.shape[0]):
        low[j] = -group_torque(isometric[0, j], angle[j], -rate[j], groups, 0, j)
        high[j] = group_torque(isometric[1, j], angle[j], rate[j], groups, 1, j)


# Called through NumPy, since a call of numba's own object takes longer than the computation.
limits = _limits_of.ufunc


DIRECTIONS = ("negative", "positive")

PROVENANCE = numbers_of("strength", "passive")
_VALUE = values_of(PROVENANCE)


def _column(name: str) -> Array:
    """Returns one quantity of all muscle groups, shape (2, 4): `DIRECTIONS` and `JOINTS`."""
    return np.array(
        [[_VALUE[f"strength.{one}.{way}.{name}"] for one in JOINTS] for way in DIRECTIONS]
    )


def _passive(name: str) -> Array:
    """Returns one quantity of all joints, shape (4,), 0 if no elastic torque is known."""
    return np.array([_VALUE.get(f"passive.{joint}.{name}", 0.0) for joint in JOINTS])


_PEAK = _column("peak")
_PASSIVE_FROM, _PASSIVE_PEAK = _column("passive_from"), _column("passive_peak")
_HALF_SPEED = _column("half_speed")
_HILL = _HALF_SPEED / (1 - 2 * _HALF_SPEED)
_GAIN = _column("eccentric") - 1
_KNEE = _GAIN / (1 + 1 / _HILL - _GAIN)
SHAPE = np.stack([_column(name) for name in ("fastest", "best_angle", "width")])
SHAPE = np.concatenate([SHAPE, [_HILL, _GAIN, _KNEE]])
_STIFFNESS, _REST, _DAMPING = _passive("stiffness"), _passive("rest"), _passive("viscosity")


def isometric_strength(person: Person) -> Array:
    """Returns the greatest torque of every muscle group at its best angle and rest [N·m].

    The torques are positive, shape (2, 4): the groups that pull toward negative and toward positive
    angles, and the joints of `JOINTS`. They are proportional to body mass (Jaric 2002, Sports Med.
    32(10), for torque), log-normal among people of one sex and mass, and for an average woman 0.55
    of those of an average man. With much body fat the real increase is smaller (Folland et al.
    2008).

    `numpy.stack` the strengths of several people to compute with all of them at once.
    """
    relative_mass = person.mass / _VALUE["strength.male.mass"]
    if person.sex == "female":
        averages = [Person.percentile(sex, 50).mass for sex in ("male", "female")]
        relative_mass *= _VALUE["strength.female.ratio"] * averages[0] / averages[1]
    spread = sqrt(log(1 + _VALUE["strength.coefficient_of_variation"] ** 2))
    rank = NormalDist().inv_cdf(person.strength / 100)
    return _PEAK * relative_mass * exp(spread * rank)


def strength_limits(isometric: Array, angle: ArrayLike, rate: ArrayLike) -> tuple[Array, Array]:
    """Returns the least and the greatest torque of the wearer at every joint [N·m], shape (..., 4).

    The least torque is at most zero. `isometric` are the torques of one or several wearers from
    `isometric_strength`, shape (..., 2, 4); angles [rad] and rates [rad/s] of the joints have the
    shape (..., 4).
    """
    return limits(isometric, angle, rate, SHAPE)


def passive_torque(isometric: Array, angle: ArrayLike, rate: ArrayLike) -> Array:
    """Returns the torque on every joint of the relaxed arm without gravity [N·m], shape (..., 4).

    Near the ends of the range the muscle that is stretched pulls back with peak · ((angle -
    passive_from) / (passive_peak - passive_from))². This stiffens to 800 N·m/rad at the elbow, so
    evaluate the torque in every physics step. The arguments are those of `strength_limits`.
    """
    angle, rate = np.asarray(angle), np.asarray(rate)
    stretch = (angle[..., None, :] - _PASSIVE_FROM) / (_PASSIVE_PEAK - _PASSIVE_FROM)
    pull = isometric * np.maximum(stretch, 0) ** 2
    return pull[..., 1, :] - pull[..., 0, :] - _STIFFNESS * (angle - _REST) - _DAMPING * rate
