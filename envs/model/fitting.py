"""Fits person and suit to the drawn arm: sizes, masses and strength; the torque of the suit."""

from collections.abc import Sequence

import mujoco
import numpy as np

from ...arrays import Array
from ...assets import JOINTS, Suit
from ...hysteresis.engine import attach, same_layout
from ..person import Person, isometric_strength, range_of_motion, segments

DRAWN = Person()  # the person that arm.xml is drawn for
ROOTS = ("legs", "torso")
FARTHEST = 1.0  # [rad], tracking error at which an episode of the environment ends
_LIMBS = {  # bodies that are as long as a segment
    "upper_arm": "upper_arm",
    "forearm": "forearm",
    "hand": "hand",
    "other_arm": "upper_arm",
    "other_forearm": "forearm",
}
_BEGINS_AFTER = {"forearm": "upper_arm", "hand": "forearm", "other_forearm": "upper_arm"}


def fit_person(spec: mujoco.MjSpec, person: Person) -> None:
    """Gives the drawn person the size, the segments and the strength of `person`, in place.

    The whole figure grows with stature, and the parts of the arm are stretched along the arm to the
    lengths of the person's segments. The suit follows, and its masses grow with the area of the
    fabric. The exoskeleton follows too, and its masses stay.

    The joints get the linear part of the torque of the relaxed arm (`passive_torque`). The rest,
    muscles that tighten at the ends of the range, is left to the joint limits: in a suit, these are
    the muscles of the elbow beyond 2.1 rad, up to 18 N·m, and of the wrist in the last 0.1 rad of
    extension.
    """
    drawn, own = segments(DRAWN), segments(person)
    size = person.stature / DRAWN.stature
    lengths = {body: own[name].length / drawn[name].length for body, name in _LIMBS.items()}
    for mesh in spec.meshes:
        mesh.scale = mesh.scale * size
    for name in ROOTS:
        root = spec.body(name)
        root.pos = root.pos * size
        stretch(root, np.full(3, size), lengths)
    for name, segment in own.items():
        body = spec.body(name)
        body.mass, body.inertia = segment.mass, np.array(segment.inertia)
        body.ipos = np.array([0, 0, -segment.center])
    for body, name in _BEGINS_AFTER.items():
        spec.body(body).pos = np.array([0, 0, -own[name].length])
    _set_strength(spec, person)


def stretch(body: mujoco.MjsBody, factors: Array, lengths: dict[str, float]) -> None:
    """Multiplies the coordinates in `body` and below; `lengths` are z factors of limbs."""
    size = factors[0]
    if body.name in lengths:
        factors = np.array([size, size, lengths[body.name]])
    for geom in body.geoms:
        geom.pos = geom.pos * factors
        geom.fromto = geom.fromto * np.tile(factors, 2)
        is_box = geom.type == mujoco.mjtGeom.mjGEOM_BOX
        geom.size = geom.size * (factors if is_box else size)
    for site in body.sites:
        site.pos = site.pos * factors
    for camera in body.cameras:
        camera.pos = camera.pos * size
    if body.explicitinertial:
        _stretch_inertia(body, factors)
    for child in body.bodies:
        child.pos = child.pos * factors
        stretch(child, factors, lengths)


def _stretch_inertia(body: mujoco.MjsBody, factors: Array) -> None:
    is_fabric = body.name.startswith("suit_")
    growth = factors[0] * factors[2] if is_fabric else 1.0  # area of the sleeve
    second_moment = body.inertia.sum() / 2 - body.inertia
    second_moment *= growth * factors**2
    body.inertia = second_moment.sum() - second_moment
    body.mass *= growth
    body.ipos = body.ipos * factors


def _set_strength(spec: mujoco.MjSpec, person: Person) -> None:
    strength = isometric_strength(person)
    for joint, limits in zip(JOINTS, (strength * [[-1], [1]]).T, strict=True):
        actuator = spec.actuator(f"human_{joint}")
        actuator.forcerange = limits
        # The feed-forward torque cancels the torque of impedance beyond strength, at any error
        # before the arm is lost.
        _, stiffness, damping = -actuator.biasprm[:3]
        most = stiffness * FARTHEST + damping * actuator.velrange[1]
        actuator.ffrange = limits + most * np.array([-1, 1])
        spec.joint(joint).actfrcrange = limits


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
