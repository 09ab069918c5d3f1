"""What differs from episode to episode beside the motion: a suit, its pressure, how it is worn."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ..arrays import Array
from ..assets import JOINTS, SuitJoint
from ..checks import within
from ..errors import InputError, shown, unknown_name
from .model import GRAVITY, Payload
from .model.config import HEAVIEST_PAYLOAD

SuitChoice = Literal["nominal", "samples"]
LARGEST_PRESSURE_SHARE = 0.5
LARGEST_OFFSET = 0.2  # rad

Streams = Callable[[str], np.random.Generator]
"""The random generator of each purpose in one episode."""


@dataclass(frozen=True, kw_only=True)
class Randomization:
    """Terms that are drawn anew in every episode of every row; plain values, as JSON has them.

    Each term has random numbers of its own: one that is added leaves the draws of the others alone.

    Attributes:
        suit: Choice of the suit's models: "nominal" (those of the suit) or "samples" (each joint's
            own or one of its `samples`, which the identification found possible too).
        pressure: Share by which the operating pressure differs, up to 0.5; the suit's torque, or
            the gas's part of it where `volume_share` tells it, is multiplied by a number between
            1 - pressure and 1 + pressure.
        payload: Least and greatest load at the hand [kg], 0 to 60; None is the load of the
            configuration.
        gravity: Names of places, of which one is drawn; none is the place of the configuration.
        encoder_offset: Largest error of the encoders' zeros [rad], up to 0.2, as from donning; each
            encoder's is between minus and plus that.

    Raises:
        InputError: A value is outside its range or unknown.
    """

    suit: SuitChoice = "nominal"
    pressure: float = 0.0
    payload: tuple[float, float] | None = None
    gravity: tuple[str, ...] = ()
    encoder_offset: float = 0.0

    def __post_init__(self) -> None:
        if self.suit not in get_args(SuitChoice):
            raise unknown_name("choice of randomize.suit", self.suit, get_args(SuitChoice))
        within("randomize.pressure", self.pressure, 0, LARGEST_PRESSURE_SHARE, "")
        if self.payload is not None:
            object.__setattr__(self, "payload", _range("randomize.payload", self.payload))
        if isinstance(self.gravity, str) or not isinstance(self.gravity, list | tuple):
            raise InputError(
                f"randomize.gravity is {shown(self.gravity)}: give a list of places, such as "
                "['earth', 'moon']"
            )
        for place in self.gravity:
            if not isinstance(place, str) or place not in GRAVITY:
                raise unknown_name("place in randomize.gravity", place, GRAVITY)
        object.__setattr__(self, "gravity", tuple(self.gravity))
        within("randomize.encoder_offset", self.encoder_offset, 0, LARGEST_OFFSET, " rad")

    @property
    def changes_suit(self) -> bool:
        """Whether rows may wear other suits than the compiled one."""
        return self.suit != "nominal" or self.pressure > 0

    def check(self, joints: Mapping[str, SuitJoint]) -> None:
        """Checks that a suit has what is drawn from it.

        Raises:
            InputError: It has no joints, or no samples where they are asked for.
        """
        if self.changes_suit and not joints:
            raise InputError(
                "randomize has a suit or its pressure, and suit is 'none': name a suit"
            )
        if self.suit == "samples" and not any(entry.samples for entry in joints.values()):
            raise InputError(
                "randomize.suit is 'samples', and the suit has none: make a suit file with "
                "`activesuit identify --samples`, or use 'nominal'"
            )

    def worn(self, joints: Mapping[str, SuitJoint], streams: Streams) -> dict[str, SuitJoint]:
        """Returns the suit of an episode, by joint.

        Args:
            joints: Joints of the suit.
            streams: Random generators of the episode.
        """
        found = dict(joints)
        if self.suit == "samples":
            rng = streams("suit")
            for joint in JOINTS:  # also where there is no choice, so that joints are independent
                draw = rng.random()
                if joint in found:
                    entry = found[joint]
                    models = (entry.model, *entry.samples)
                    model = models[int(draw * len(models))]
                    found[joint] = entry.model_copy(update={"model": model})
        if self.pressure > 0:
            factor = 1 + self.pressure * streams("pressure").uniform(-1, 1)
            found = {joint: _scaled(entry, factor) for joint, entry in found.items()}
        return found

    def load(self, streams: Streams) -> Payload | None:
        """Returns the load of an episode; None is that of the configuration."""
        if self.payload is None:
            return None
        return Payload(mass=float(streams("payload").uniform(*self.payload)))

    def place(self, streams: Streams) -> str | None:
        """Returns the place of an episode; None is that of the configuration."""
        if not self.gravity:
            return None
        return self.gravity[int(streams("gravity").integers(len(self.gravity)))]

    def offsets(self, streams: Streams) -> Array:
        """Returns the error of every encoder's zero in an episode [rad], shape (4,)."""
        if self.encoder_offset == 0:
            return np.zeros(len(JOINTS))
        return self.encoder_offset * streams("encoder offset").uniform(-1, 1, len(JOINTS))


def _range(name: str, given: object) -> tuple[float, float]:
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise InputError(f"{name} is {shown(given)}: give the least and the greatest mass [kg]")
    for value in given:
        within(name, value, 0, HEAVIEST_PAYLOAD, " kg")
    low, high = given
    if low > high:
        raise InputError(f"{name} is {list(given)}: give the smaller mass first")
    return float(low), float(high)


def _scaled(entry: SuitJoint, factor: float) -> SuitJoint:
    if entry.volume_share is not None:
        return entry.at_pressure_ratio(factor)
    model, start = entry.model.scaled(torque=factor), factor * entry.start_torque
    return entry.model_copy(update={"model": model, "start_torque": start})
