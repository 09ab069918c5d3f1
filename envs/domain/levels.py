"""Levels of difference from the conditions that a controller was designed for, as data."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ...errors import InputError, unknown_name
from ..model.config import NO_SUIT
from .randomization import Randomization

NOMINAL = "nominal"  # where nothing differs
LEVELS: dict[str, dict[str, Any]] = {
    NOMINAL: {},
    "randomized": {
        "randomize": {
            "pressure": 0.2,
            "load": 0.5,
            "wearers": [
                {},
                {"sex": "female", "stature": 1.65, "mass": 65.0},
                {"stature": 1.86, "mass": 92.0},
            ],
            "misalignment": 0.02,
            "sensor_noise": [0.5, 2.0],
            "encoder_offset": 0.02,
        }
    },
    "shift": {"suit": "emu-like", "pressure": 40.0, "gravity": "mars"},
    "faults": {
        "faults": {
            **{"torque_bias": 2.0, "torque_drift": 0.05, "force_bias": 10.0, "force_drift": 0.25},
            **{"late": 0.1, "lost": 0.05},
        }
    },
}
"""Options of each level; given options replace them.

At "randomized" the suit's pressure and the task's loads differ, three people wear it, and
exoskeleton and sensors sit differently. "shift" is another suit at another pressure in another
gravity than the defaults, so that no belief matches it by accident. At "faults" pads and cuffs
read wrong, and readings are late or lost. Force sensing resistors have a hysteresis of 10 % and
drift by up to 5 % in each decade of time (Interlink FSR 400, data sheet): here 10 % of 20 N·m and
of 100 N, and as much again in 40 s. The shares of late and lost readings are assumed.
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
        terms.pop("pressure", None)
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
