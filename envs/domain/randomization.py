"""Differences between episodes beside the motion: suit, pressure, fit on the arm, and others."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from ...arrays import Array
from ...assets import JOINTS, Suit, SuitJoint
from ...checks import pair, within
from ...errors import InputError, shown, unknown_name
from ..model import ArmConfig, Payload, suit_of_config
from ..model.config import HEAVIEST_PAYLOAD, LARGEST_MISALIGNMENT, NO_SUIT, nested, place_of
from ..person import Person
from ..provenance import check_settings, setting
from ..simulation.episode_plan import Plan

SuitChoice = Literal["nominal", "samples"]
LARGEST_SHARE = 0.5
LARGEST_OFFSET = 0.2  # rad
MOST_CYCLES = 1e6
LOUDEST = 100.0  # greatest factor of the noise of sensors
FACTORS = (0.05, 20.0)  # least and greatest factor of a part of a suit's torque
SPREAD = 0.15  # standard deviation of the logarithm of a joint's factor about that of its suit
OF_SUIT = ("suit", "suits", "spring", "loop", "pressure", "cycles")
"""Terms that need a suit."""

Streams = Callable[[str], np.random.Generator]
"""The random generator of each purpose in one episode."""


class Base(NamedTuple):
    """A suit of which suits are drawn.

    Attributes:
        suit: The suit, at its operating pressure.
        lines: Elastic torque of the joints in which it is drawn apart: torque at angle 0 [N·m] and
            stiffness [N·m/rad], by joint.
    """

    suit: Suit
    lines: Mapping[str, tuple[float, float]]


class DrawnSuit(NamedTuple):
    """The suit of an episode.

    Attributes:
        joints: Its joints by name; None stands for the suit of the configuration.
        number: Number of the suit of `suits` of which it is drawn.
        spring: Factor of the elastic torque of each joint, shape (4,).
        loop: Factor of the loop about it, shape (4,).
    """

    joints: Mapping[str, SuitJoint] | None
    number: int
    spring: Array
    loop: Array


@dataclass(frozen=True, kw_only=True)
class Randomization:
    """Terms that are drawn anew in every episode of every row, as plain values that fit JSON.

    Each term has random numbers of its own: another term does not change the draws of the others.

    Attributes:
        suit: Choice of the suit's models: "nominal" (those of the suit) or "samples" (each joint's
            own or one of its `samples`, which the identification found plausible too).
        suits: Names or files of suits, of which one is drawn, also of different models; an empty
            list is the suit of the configuration.
        spring: Least and greatest factor of the suit's elastic torque, 0.05 to 20, or the ends of
            several ranges, of which one is drawn: (0.4, 0.7, 2.5, 4.0). The elastic torque of a
            joint is the straight line through its steady cycle. One factor of a suit is log-uniform
            in the range, since one cut and one pressure make all joints; each joint differs from it
            by 15 % (standard deviation), and stays in the range. Empty is 1.
        loop: The same of the loop about that line, with factors of its own.
        pressure: Share by which the operating pressure differs, up to 0.5; the suit's torque, or
            the gas's part of it where `volume_share` is known, is multiplied by a number between
            1 - pressure and 1 + pressure, beside `spring` and `loop`.
        cycles: Least and greatest number of cycles that the suit has gone through, up to a million,
            for joints whose file gives their softening; None is the first cycle, or many of a suit
            that is preconditioned. The torque does not soften within an episode.
        load: Share by which the masses and forces of a task's plan differ, up to 0.5; tools that
            belong to its model do not change.
        payload: Least and greatest load at the hand [kg], 0 to 60; None is the load of the
            configuration.
        gravity: Names of places, of which one is drawn; an empty list is the configured place.
        wearers: Persons, of whom one is drawn, or dicts of their fields; an empty list is the
            wearer of the configuration.
        misalignment: Largest distance, forward, outward and up, by which the exoskeleton sits
            differently than in the configuration [m], up to 0.05; it needs cuffs.
        sensor_noise: Least and greatest factor of the noise of sensors, 0 to 100; None is 1.
        encoder_offset: Largest error of the encoders' zeros [rad], up to 0.2, as from donning; the
            error of each encoder is drawn between minus and plus this value.
    """

    suit: SuitChoice = "nominal"
    suits: tuple[str, ...] = ()
    spring: tuple[float, ...] = ()
    loop: tuple[float, ...] = ()
    pressure: float = setting(0.0, "1", 0, LARGEST_SHARE)
    cycles: tuple[float, float] | None = None
    load: float = setting(0.0, "1", 0, LARGEST_SHARE)
    payload: tuple[float, float] | None = None
    gravity: tuple[str, ...] = ()
    wearers: tuple[Person, ...] = ()
    misalignment: float = setting(0.0, "m", 0, LARGEST_MISALIGNMENT)
    sensor_noise: tuple[float, float] | None = None
    encoder_offset: float = setting(0.0, "rad", 0, LARGEST_OFFSET)

    def __post_init__(self) -> None:
        if self.suit not in get_args(SuitChoice):
            raise unknown_name("choice of randomize.suit", self.suit, get_args(SuitChoice))
        check_settings(self, "randomize.")
        for name, most, unit in (
            ("payload", HEAVIEST_PAYLOAD, " kg"),
            ("sensor_noise", LOUDEST, ""),
            ("cycles", MOST_CYCLES, ""),
        ):
            given = getattr(self, name)
            if given is not None:
                object.__setattr__(self, name, pair(f"randomize.{name}", given, 0, most, unit))
        for name in ("spring", "loop"):
            object.__setattr__(self, name, _ranges(f"randomize.{name}", getattr(self, name)))
        for name, example in (
            ("gravity", "of places, such as ['earth', 'moon']"),
            ("suits", "of suits, such as ['mock-suit', 'emu-like']"),
            ("wearers", "of persons, such as [{'sex': 'female'}]"),
        ):
            given = getattr(self, name)
            if isinstance(given, str) or not isinstance(given, list | tuple):
                raise InputError(f"randomize.{name} is {shown(given)}: give a list {example}")
        for suit in self.suits:
            if not isinstance(suit, str) or suit == NO_SUIT:
                raise InputError(
                    f"randomize.suits has {shown(suit)}: give names or files of suits; arms "
                    "without one have other bodies, so make an environment with suit='none'"
                )
        object.__setattr__(self, "suits", tuple(self.suits))
        wearers = [
            nested(f"randomize.wearers[{i}]", given, Person())
            for i, given in enumerate(self.wearers)
        ]
        object.__setattr__(self, "wearers", tuple(wearers))
        places = tuple(place_of("place in randomize.gravity", one) for one in self.gravity)
        object.__setattr__(self, "gravity", places)

    @property
    def changes_suit(self) -> bool:
        """Whether rows may have other suits than the compiled one."""
        usual = Randomization()
        return any(getattr(self, name) != getattr(usual, name) for name in OF_SUIT)

    def suits_for(self, config: ArmConfig) -> tuple[Base, ...]:
        """Returns the suits of which one is drawn in each episode, at their pressures."""
        if self.misalignment > 0 and config.coupling != "cuffs":
            raise InputError(
                f"randomize.misalignment is {self.misalignment:g} m, but coupling is "
                f"{config.coupling!r}: only coupling='cuffs' lets exoskeleton and arm have "
                "different axes"
            )
        if not self.changes_suit:
            return ()
        if config.suit == NO_SUIT:
            raise InputError(
                "randomize has a suit, its factors, pressure or cycles, and suit is 'none': name a "
                "suit"
            )
        found = [
            suit_of_config(replace(config, suit=suit)) for suit in self.suits or (config.suit,)
        ]
        suits = tuple(suit for suit in found if suit is not None)
        entries = [entry for suit in suits for entry in suit.joints.values()]
        if self.suit == "samples" and not any(entry.samples for entry in entries):
            raise InputError(
                "randomize.suit is 'samples', and the suit has none: make a suit file with "
                "`activesuit identify --samples`, or use 'nominal'"
            )
        if self.cycles is not None and not any(entry.softening for entry in entries):
            raise InputError(
                f"randomize.cycles is {list(self.cycles)}, and no joint of the suit has a "
                "softening: add it to the suit file, or leave cycles out"
            )
        return tuple(map(self._base, suits))

    def _base(self, suit: Suit) -> Base:
        """Returns a suit whose models have the layout of all suits that are drawn of it."""
        lines, joints = {}, dict(suit.joints)
        for joint, entry in suit.joints.items():
            gas = self.pressure > 0 and entry.volume_share is not None
            if self.spring or self.loop or gas:
                lines[joint] = entry.steady_cycle().spring()
                joints[joint] = entry.apart(1.0, 1.0, lines[joint])
        return Base(suit.model_copy(update={"joints": joints}), lines)

    def suit_of(self, bases: Sequence[Base], streams: Streams) -> DrawnSuit:
        """Returns the suit of an episode."""
        spring, loop = (
            _factors(ranges, streams(name)) if ranges else np.ones(len(JOINTS))
            for name, ranges in (("spring", self.spring), ("loop", self.loop))
        )
        if not bases:
            return DrawnSuit(None, 0, spring, loop)
        number = int(streams("suits").integers(len(bases))) if self.suits else 0
        (suit, lines), found = bases[number], dict[str, SuitJoint]()
        pressure, samples = 1.0, streams("suit") if self.suit == "samples" else None
        if self.pressure > 0:
            pressure = 1 + self.pressure * streams("pressure").uniform(-1, 1)
        count = None if self.cycles is None else float(streams("cycles").uniform(*self.cycles))
        for i, joint in enumerate(JOINTS):
            draw = samples.random() if samples else 0.0  # draws for joints without a choice, too
            if joint not in suit.joints:
                continue
            entry = suit.joints[joint]
            models, gas = (entry.model, *entry.samples), entry.volume_share
            drawn = {"model": models[int(draw * len(models))], "samples": ()}
            entry = entry.model_copy(update=drawn)
            spring[i] *= pressure if gas is None else 1 + gas * (pressure - 1)
            loop[i] *= pressure if gas is None else 1.0
            if joint in lines:
                entry = entry.apart(spring[i], loop[i], lines[joint])
            elif pressure != 1:
                entry = _scaled(entry, pressure)
            found[joint] = entry if count is None else entry.after(count)
        return DrawnSuit(found, number, spring, loop)

    def loaded(self, plan: Plan, streams: Streams) -> Plan:
        """Returns a plan with the loads of an episode."""
        if self.load == 0:
            return plan
        factor = 1 + self.load * streams("load").uniform(-1, 1)
        changed = {
            name: factor * np.asarray(values)
            for name, values in (("mass", plan.mass), ("push", plan.push))
            if values is not None
        }
        return replace(plan, **changed)

    def drawn(self, streams: Streams) -> dict[str, Any]:
        """Returns the draws of an episode beside wearer, suit and plan, as fields of `Start`.

        Load and place are None if they are those of the configuration.
        """
        payload, place, shift = None, None, np.zeros(3)
        noise, offset = 1.0, np.zeros(len(JOINTS))
        if self.payload is not None:
            payload = Payload(mass=float(streams("payload").uniform(*self.payload)))
        if self.gravity:
            place = self.gravity[int(streams("gravity").integers(len(self.gravity)))]
        if self.misalignment:
            shift = self.misalignment * streams("misalignment").uniform(-1, 1, 3)
        if self.sensor_noise is not None:
            noise = float(streams("sensor noise factor").uniform(*self.sensor_noise))
        if self.encoder_offset:
            draws = streams("encoder offset").uniform(-1, 1, len(JOINTS))
            offset = self.encoder_offset * draws
        return {
            **{"payload": payload, "gravity": place, "misalignment": shift},
            **{"noise_scale": noise, "encoder_offset": offset},
        }

    def person(self, streams: Streams) -> int:
        """Returns the number of the wearer of an episode."""
        return int(streams("wearers").integers(len(self.wearers))) if self.wearers else 0


def _scaled(entry: SuitJoint, factor: float) -> SuitJoint:
    model, start = entry.model.scaled(torque=factor), factor * entry.start_torque
    return entry.model_copy(update={"model": model, "start_torque": start})


def _factors(ranges: Sequence[float], rng: np.random.Generator) -> Array:
    """Returns the factors of the joints of one suit, shape (4,), in one of the ranges."""
    number = 2 * int(rng.integers(len(ranges) // 2))
    low, high = np.log(ranges[number : number + 2])
    each = rng.uniform(low, high) + SPREAD * rng.standard_normal(len(JOINTS))
    return np.exp(np.clip(each, low, high))


def _ranges(name: str, given: Any) -> tuple[float, ...]:
    """Returns the ends of ranges of factors; an empty list is no range."""
    if not isinstance(given, list | tuple) or len(given) % 2:
        raise InputError(
            f"{name} is {shown(given)}: give the least and the greatest factor, such as "
            "[0.7, 2.5], or the ends of several ranges, such as [0.4, 0.7, 2.5, 4.0]"
        )
    for value in given:
        within(name, value, *FACTORS)
    if list(given) != sorted(given):
        raise InputError(f"{name} is {shown(given)}: give the ends in ascending order")
    return tuple(map(float, given))
