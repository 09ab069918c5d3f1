"""The size of the wearer: stature, mass and sex, and the segments and ranges of the arm."""

from dataclasses import dataclass
from math import radians
from numbers import Real
from statistics import NormalDist
from typing import Literal, cast

from ...assets import JOINTS
from ...errors import InputError, unknown_name
from ..provenance import Grade, Quantity

SEXES = ("male", "female")

_ANSUR = "Gordon et al. 2014, ANSUR II, NATICK/TR-15/007"
_RECALLED = f"{_ANSUR}, quoted from memory; the pooled mean of both sexes, 79.7 kg, agrees"
# Mean and standard deviation of stature [m] and body mass [kg], by sex.
_POPULATION = {
    "male": {"stature": (1.756, 0.0686), "mass": (85.5, 14.2)},
    "female": {"stature": (1.629, 0.0642), "mass": (67.8, 11.0)},
}
_POPULATION_SOURCE: dict[str, tuple[str, str, Grade]] = {
    "stature": ("m", _ANSUR, "transcribed"),
    "mass": ("kg", _RECALLED, "assumed"),
}

_USUAL = {
    "male": {"stature": 1.78, "mass": 80.0},
    "female": {what: mean for what, (mean, _) in _POPULATION["female"].items()},
}

_DE_LEVA = "de Leva 1996, J. Biomech. 29(9), 1223-1230"
_COLUMNS: tuple[tuple[str, str, str, Grade], ...] = (
    ("length", "mm", f"{_DE_LEVA}, quoted from memory; between joint centers", "assumed"),
    ("mass", "1", f"{_DE_LEVA}; fraction of body mass", "transcribed"),
    ("center", "1", f"{_DE_LEVA}; fraction of length", "transcribed"),
    ("gyration_sagittal", "1", f"{_DE_LEVA}; fraction of length", "transcribed"),
    ("gyration_transverse", "1", f"{_DE_LEVA}; fraction of length", "transcribed"),
    ("gyration_longitudinal", "1", f"{_DE_LEVA}; fraction of length", "transcribed"),
)
# The hand ends at the head of the third metacarpal.
_SEGMENTS = {
    "male": {
        "upper_arm": (281.7, 0.0271, 0.5772, 0.285, 0.269, 0.158),
        "forearm": (268.9, 0.0162, 0.4574, 0.276, 0.265, 0.121),
        "hand": (86.2, 0.0061, 0.7900, 0.628, 0.513, 0.401),
    },
    "female": {
        "upper_arm": (275.1, 0.0255, 0.5754, 0.278, 0.260, 0.148),
        "forearm": (264.3, 0.0138, 0.4559, 0.261, 0.257, 0.094),
        "hand": (78.0, 0.0056, 0.7474, 0.531, 0.454, 0.335),
    },
}
_SEGMENT_STATURE = {"male": 1741.0, "female": 1735.0}  # [mm], mean of the measured people

_BOONE = "Boone and Azen 1979, men"
_RANGES: dict[str, tuple[tuple[float, str, Grade], tuple[float, str, Grade]]] = {  # degrees
    "shoulder_abduction": (
        (-11.5, "limited by the torso", "assumed"),
        (184.0, _BOONE, "transcribed"),
    ),
    "shoulder_flexion": ((-62.0, _BOONE, "transcribed"), (167.0, _BOONE, "transcribed")),
    "elbow_flexion": ((0.0, "AAOS", "transcribed"), (143.0, _BOONE, "transcribed")),
    "wrist_flexion": ((-75.0, _BOONE, "transcribed"), (76.0, _BOONE, "transcribed")),
}

PROVENANCE: tuple[Quantity, ...] = (
    *(
        Quantity(f"population.{sex}.{what}.{statistic}", value, *_POPULATION_SOURCE[what])
        for sex, sizes in _POPULATION.items()
        for what, pair in sizes.items()
        for statistic, value in zip(("mean", "standard_deviation"), pair, strict=True)
    ),
    *(
        Quantity(
            f"segments.{sex}.stature", value, "mm", f"{_DE_LEVA}, quoted from memory", "assumed"
        )
        for sex, value in _SEGMENT_STATURE.items()
    ),
    *(
        Quantity(f"segments.{sex}.{segment}.{column}", value, unit, source, grade)
        for sex, table in _SEGMENTS.items()
        for segment, row in table.items()
        for (column, unit, source, grade), value in zip(_COLUMNS, row, strict=True)
    ),
    *(
        Quantity(f"range_of_motion.{joint}.{end}", value, "deg", source, grade)
        for joint, ends in _RANGES.items()
        for end, (value, source, grade) in zip(("low", "high"), ends, strict=True)
    ),
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

    stature: float = cast(float, None)  # what the sex decides
    mass: float = cast(float, None)
    sex: Literal["male", "female"] = "male"
    strength: float = 50.0

    def __post_init__(self) -> None:
        if self.sex not in SEXES:
            raise unknown_name("sex", self.sex, SEXES)
        for what, usual in _USUAL[self.sex].items():
            if getattr(self, what) is None:
                object.__setattr__(self, what, usual)
        _check("stature", self.stature, "meters", 1.4, 2.1, _stature_hint(self.stature))
        _check("mass", self.mass, "kilograms", 40, 140)
        _check("strength", self.strength, "a percentile", 1, 99)

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
        _check("percentile", percentile, "a percentile", 1, 99)
        sizes = {
            what: NormalDist(*pair).inv_cdf(percentile / 100)
            for what, pair in _POPULATION[sex].items()
        }
        return cls(sex=sex, **sizes)


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A rigid part of the arm.

    Attributes:
        length: Distance from the proximal joint center to the distal one; for the hand, to the
            head of the third metacarpal [m].
        mass: Mass of the segment [kg].
        center: Distance of its mass center from the proximal joint center [m].
        inertia: Moments of inertia about the mass center [kg·m²], about the sagittal (forward),
            transverse (sideways: the axis of flexion) and longitudinal axis of the hanging arm.
    """

    length: float
    mass: float
    center: float
    inertia: tuple[float, float, float]


def segments(person: Person) -> dict[str, Segment]:
    """Returns the segments of one arm: "upper_arm", "forearm" and "hand".

    Lengths scale with stature and masses with body mass, by the tables of de Leva 1996.
    """
    scale = person.stature / _SEGMENT_STATURE[person.sex]
    result = {}
    for name, (mm, mass_fraction, center, *gyration) in _SEGMENTS[person.sex].items():
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
    if joint not in _RANGES:
        raise unknown_name("joint", joint, JOINTS)
    (low, _, _), (high, _, _) = _RANGES[joint]
    return radians(low), radians(high)


def _check(name: str, value: float, unit: str, low: float, high: float, hint: str = "") -> None:
    if not (isinstance(value, Real) and low <= value <= high):
        raise InputError(f"{name} is {value!r}: use {unit} from {low:g} to {high:g}{hint}")


def _stature_hint(stature: float) -> str:
    if not isinstance(stature, Real):
        return ""
    if 140 <= stature <= 210:
        return f"; {stature:g} cm is {stature / 100:g} m"
    if 4.6 <= stature <= 6.9:
        return f"; {stature:g} ft is {stature * 0.3048:.2f} m"
    return ""
