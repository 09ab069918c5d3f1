"""Adds the suit's hysteretic torque to the arm, or removes the drawn suit."""

from collections.abc import Sequence

import mujoco
import numpy as np

from ...assets import JOINTS, Suit
from ...hysteresis.engine import attach, same_layout
from ..person import range_of_motion


def attach_suit(spec: mujoco.MjSpec, suit: Suit, *, allow_uncertified: bool = False) -> None:
    """Makes the arm's joints resist with the suit's torque, in place.

    Raises:
        UncertifiedModelError: The suit is not certified and `allow_uncertified` is not set.
    """
    for joint, entry in suit.joints.items():
        attach(
            spec,
            joint,
            entry.model,
            start_angle=entry.start_angle,
            start_torque=entry.start_torque,
            start_path=entry.start_path,
            allow_uncertified=allow_uncertified,
        )


def attach_others(
    spec: mujoco.MjSpec,
    suit: Suit | None,
    others: Sequence[Suit],
    *,
    allow_uncertified: bool = False,
) -> None:
    """Attaches inactive models, which other suits and their samples can activate later, in place.

    Raises:
        UncertifiedModelError: A suit is not certified and `allow_uncertified` is not set.
    """
    for joint in JOINTS:
        there = [suit.joints[joint].model] if suit is not None and joint in suit.joints else []
        for entry in (suit.joints[joint] for suit in others if joint in suit.joints):
            for model in (entry.model, *entry.samples):
                if not any(same_layout(model, known) for known in there):
                    attach(
                        spec,
                        joint,
                        model,
                        start_angle=entry.start_angle,
                        start_torque=entry.start_torque,
                        allow_uncertified=allow_uncertified,
                        taken_off=True,
                    )
                    there.append(model)


def remove_suit(spec: mujoco.MjSpec) -> None:
    """Removes the drawn suit, in place: joints then move as far as the person can."""
    for body in [body for body in spec.bodies if body.name.startswith("suit_")]:
        spec.delete(body)
    for joint in JOINTS:
        spec.joint(joint).range = np.array(range_of_motion(joint))
