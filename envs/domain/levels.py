"""Levels of difference from the conditions that a controller was designed for, as data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from ...errors import InputError, unknown_name
from ..model.config import NO_SUIT
from .randomization import OF_SUIT, Randomization

NOMINAL = "nominal"  # where nothing differs
INSIDE, OUTSIDE = (0.7, 2.5), (0.4, 0.7, 2.5, 4.0)  # factors of a suit's torque
EMU_LIKE = 2.83  # torque of the suit emu-like over that of mock-suit
TRAINING: list[dict[str, Any]] = [
    {},
    {"sex": "female", "stature": 1.65, "mass": 65.0},
    {"stature": 1.86, "mass": 92.0},
]
OTHERS: list[dict[str, Any]] = [
    {"sex": "female", "stature": 1.58, "mass": 54.0},
    {"stature": 1.93, "mass": 102.0},
    {"sex": "female", "stature": 1.74, "mass": 72.0},
]
"""Persons of trainings, and persons whom no training meets."""


def _drawn(
    factors: Sequence[float], wearers: list[dict[str, Any]], suit: str = "", size: float = 1.0
) -> dict[str, Any]:
    """Returns the options of a level of drawn suits, of the size of a suit over mock-suit."""
    ranges = [round(factor / size, 3) for factor in factors]
    return {
        "randomize": {
            **({"suits": [suit]} if suit else {}),
            **{"spring": ranges, "loop": ranges, "pressure": 0.2, "load": 0.5, "wearers": wearers},
            **{"misalignment": 0.02, "sensor_noise": [0.5, 2.0], "encoder_offset": 0.02},
        }
    }


LEVELS: dict[str, dict[str, Any]] = {
    NOMINAL: {},
    "randomized": _drawn(INSIDE, TRAINING),
    "unseen": _drawn(INSIDE, OTHERS, "emu-like", EMU_LIKE),
    "beyond": _drawn(OUTSIDE, OTHERS, "emu-like", EMU_LIKE),
    "shift": {"suit": "emu-like", "pressure": 40.0, "gravity": "mars"},
    "faults": {
        "faults": {
            **{"torque_bias": 2.0, "torque_drift": 0.05, "force_bias": 10.0, "force_drift": 0.25},
            **{"late": 0.1, "lost": 0.05},
        }
    },
}
"""Options of each level; given options replace them.

At "randomized" every episode has a suit of its own: elastic and frictional share of the torque are
0.7 to 2.5 times those of the suit, each for itself, and pressure, loads, persons, the fit of
exoskeleton and sensors differ. Policies may train there. "unseen" measures robustness: the same
ranges, but other persons, and suits of another shape, that of emu-like at the size of mock-suit.
Controllers believe in the option `suit` at both, which by default is mock-suit. At "beyond" the
factors are 0.4 to 0.7 or 2.5 to 4. No motors may be strong enough there: results count where the
best known plan succeeds. The two shapes differ in the model of the shoulder, in the ranges over
which the elastic torque is taken, and in the share of the gas; models of elbows are in proportion.

"shift" is one fixed world, another suit at another pressure in another gravity than the defaults.
A policy that trains there learns a few numbers, so that a test there measures fitting. A device
knows its place, but a policy knows only the place of the options: so no level draws the gravity.

At "faults" pads and cuffs read wrong, and readings are late or lost. Force sensing resistors have a
hysteresis of 10 % and drift by up to 5 % in each decade of time (Interlink FSR 400, data sheet):
here 10 % of 20 N·m and of 100 N, and as much again in 40 s. The shares of late and lost readings,
and the ranges and persons of the other levels, are assumed.
"""

COMPARED = (NOMINAL, "randomized", "shift")
"""Levels of the benchmark and of the tables of tasks; "faults" is a question of its own."""


def with_level(options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options of an environment in which "level" is replaced by its options.

    Terms of `randomize` replace those of the level one by one. A level's options for suits or
    cuffs are left out where there are none, and the pressure of its suit for another suit.
    """
    given = {name: value for name, value in options.items() if name != "level"}
    level = options.get("level", NOMINAL)
    if not isinstance(level, str) or level not in LEVELS:
        raise unknown_name("level", level, LEVELS)
    usual = dict(LEVELS[level])
    terms, own = dict(usual.pop("randomize", {})), given.get("randomize") or {}
    if "suit" in given and "suit" in usual:
        usual.pop("pressure", None)  # pressure of the level's own suit
    if given.get("suit") == NO_SUIT:
        terms = {name: term for name, term in terms.items() if name not in OF_SUIT}
    if given.get("coupling") != "cuffs":
        terms.pop("misalignment", None)
    found = {**usual, **given}
    if terms:
        if isinstance(own, Randomization):
            own = asdict(own)
        if not isinstance(own, Mapping):
            raise InputError(
                f"randomize is {own!r}: give Randomization(...) or a dict of its fields"
            )
        found["randomize"] = {**terms, **own}
    return found
