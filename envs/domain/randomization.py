"""Differences between episodes beside the motion: suit, pressure, fit on the arm, and others."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from ...assets import JOINTS, Suit, SuitJoint
from ...checks import pair
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

Streams = Callable[[str], np.random.Generator]
"""The random generator of each purpose in one episode."""


@dataclass(frozen=True, kw_only=True)
class Randomization:
    """Terms that are drawn anew in every episode of every row, as plain values that fit JSON.

    Each term has random numbers of its own: another term does not change the draws of the others.

    Attributes:
        suit: Choice of the suit's models: "nominal" (those of the suit) or "samples" (each joint's
            own or one of its `samples`, which the identification found plausible too).
        suits: Names or files of suits, of which one is drawn, also of different models; an empty
            list is the suit of the configuration.
        pressure: Share by which the operating pressure differs, up to 0.5; the suit's torque, or
            the gas's part of it where `volume_share` is known, is multiplied by a number between
            1 - pressure and 1 + pressure.
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
        drawn = self.suit != "nominal" or bool(self.suits)
        return drawn or self.pressure > 0 or self.cycles is not None

    def suits_for(self, config: ArmConfig) -> tuple[Suit, ...]:
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
                "randomize has a suit, its pressure or cycles, and suit is 'none': name a suit"
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
        return suits

    def suit_of(self, suits: Sequence[Suit], streams: Streams) -> dict[str, SuitJoint] | None:
        """Returns the suit of an episode, by joint; None for the suit of the configuration."""
        if not suits:
            return None
        number = int(streams("suits").integers(len(suits))) if self.suits else 0
        found: dict[str, SuitJoint] = dict(suits[number].joints)
        if self.suit == "samples":
            rng = streams("suit")
            for joint in JOINTS:  # draws without a choice too, so that joints are independent
                draw = rng.random()
                if joint in found:
                    entry = found[joint]
                    models = (entry.model, *entry.samples)
                    model = models[int(draw * len(models))]
                    found[joint] = entry.model_copy(update={"model": model})
        if self.cycles is not None:
            count = float(streams("cycles").uniform(*self.cycles))
            found = {joint: entry.after(count) for joint, entry in found.items()}
        if self.pressure > 0:
            factor = 1 + self.pressure * streams("pressure").uniform(-1, 1)
            found = {joint: _scaled(entry, factor) for joint, entry in found.items()}
        return found

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
    if entry.volume_share is not None:
        return entry.at_pressure_ratio(factor)
    model, start = entry.model.scaled(torque=factor), factor * entry.start_torque
    return entry.model_copy(update={"model": model, "start_torque": start})
