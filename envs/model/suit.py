"""Puts the suit's hysteretic torque on the arm, or takes the drawn suit off."""

import mujoco
import numpy as np

from ...assets import JOINTS, Suit
from ...hysteresis.engine import attach
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


def remove_suit(spec: mujoco.MjSpec) -> None:
    """Takes the drawn suit off, in place: joints then move as far as the person can."""
    for body in [body for body in spec.bodies if body.name.startswith("suit_")]:
        spec.delete(body)
    for joint in JOINTS:
        spec.joint(joint).range = np.array(range_of_motion(joint))
