"""The size of the wearer: stature, mass and sex, and the segments and ranges of the arm."""

from dataclasses import dataclass
from math import radians
from numbers import Real
from statistics import NormalDist
from typing import Literal, cast

from ...assets import JOINTS
from ...checks import within
from ...errors import unknown_name
from ..provenance import numbers_of, values_of

SEXES = ("male", "female")

PROVENANCE = numbers_of("population", "segments", "range_of_motion")
_VALUE = values_of(PROVENANCE)
_USUAL = {
    "male": {"stature": 1.78, "mass": 80.0},
    "female": {what: _VALUE[f"population.female.{what}.mean"] for what in ("stature", "mass")},
}

_COLUMNS = (
    *("length", "mass", "center"),  # mm, fraction of body mass, fraction of length
    *("gyration_sagittal", "gyration_transverse", "gyration_longitudinal"),
)


@dataclass(frozen=True, kw_only=True)
class Person:
    """A wearer. All fields are plain values, which convert to JSON.

    Attributes:
        stature: Standing height [m], 1.4 to 2.1; by default 1.78 of a man, and of a woman the mean
            of ANSUR II.
        mass: Body mass without suit [kg], 40 to 140; by default 80 of a man, and of a woman the
            mean of ANSUR II.
        sex: Sex of the wearer, "male" or "female".
        strength: Percentile of strength among people of this sex and mass, 1 to 99.
    """

    stature: float = cast(float, None)  # the sex decides
    mass: float = cast(float, None)
    sex: Literal["male", "female"] = "male"
    strength: float = 50.0

    def __post_init__(self) -> None:
        if self.sex not in SEXES:
            raise unknown_name("sex", self.sex, SEXES)
        for what, usual in _USUAL[self.sex].items():
            if getattr(self, what) is None:
                object.__setattr__(self, what, usual)
        within("stature", self.stature, 1.4, 2.1, f" m{_stature_hint(self.stature)}")
        within("mass", self.mass, 40, 140, " kg")
        within("strength", self.strength, 1, 99, " (percentile)")

    @classmethod
    def percentile(cls, sex: Literal["male", "female"], percentile: float) -> "Person":
        """Returns the person whose stature and mass are at a percentile of ANSUR II.

        The usual design cases go from the 5th percentile female to the 95th percentile male. Both
        sizes are assumed to be normally distributed; strength is the median of that sex and mass.

        Args:
            sex: Sex of the person, "male" or "female".
            percentile: Percentile of stature and mass, 1 to 99.
        """
        if sex not in SEXES:
            raise unknown_name("sex", sex, SEXES)
        within("percentile", percentile, 1, 99)
        sizes = {}
        for what in ("stature", "mass"):
            mean, deviation = (
                _VALUE[f"population.{sex}.{what}.{statistic}"]
                for statistic in ("mean", "standard_deviation")
            )
            sizes[what] = NormalDist(mean, deviation).inv_cdf(percentile / 100)
        return cls(sex=sex, **sizes)


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A rigid part of the arm."""

    # Distance from the proximal joint center to the distal joint center [m]; for the hand, to the
    # head of the third metacarpal.
    length: float
    mass: float  # mass of the segment [kg]
    center: float  # distance of its mass center from the proximal joint center [m]
    # Moments of inertia about the mass center [kg·m²], about the sagittal (forward), transverse
    # (sideways: the axis of flexion) and longitudinal axis of the hanging arm.
    inertia: tuple[float, float, float]


def segments(person: Person) -> dict[str, Segment]:
    """Returns the segments of one arm: "upper_arm", "forearm" and "hand".

    Lengths scale with stature and masses with body mass, by the tables of de Leva 1996.
    """
    of = f"segments.{person.sex}"
    scale = person.stature / _VALUE[f"{of}.stature"]
    result = {}
    for name in ("upper_arm", "forearm", "hand"):
        row = (_VALUE[f"{of}.{name}.{column}"] for column in _COLUMNS)
        mm, mass_fraction, center, *gyration = row
        length = mm * scale
        mass = mass_fraction * person.mass
        sagittal, transverse, longitudinal = (mass * (ratio * length) ** 2 for ratio in gyration)
        result[name] = Segment(
            length=length,
            mass=mass,
            center=center * length,
            inertia=(sagittal, transverse, longitudinal),
        )
    return result


def range_of_motion(joint: str) -> tuple[float, float]:
    """Returns the lowest and highest joint angle of a healthy adult without a suit [rad]."""
    if joint not in JOINTS:
        raise unknown_name("joint", joint, JOINTS)
    low, high = (_VALUE[f"range_of_motion.{joint}.{end}"] for end in ("low", "high"))
    return radians(low), radians(high)


def _stature_hint(stature: float) -> str:
    if not isinstance(stature, Real):
        return ""
    if 140 <= stature <= 210:
        return f"; {stature:g} cm is {stature / 100:g} m"
    if 4.6 <= stature <= 6.9:
        return f"; {stature:g} ft is {stature * 0.3048:.2f} m"
    return ""
