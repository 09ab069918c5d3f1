"""Additions of a task to a model: tools, forces at the grip, and objects before the wearer.

Everything is built for the right arm; the left arm is the mirror image.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from ...arrays import Array
from .variants import taken_keyframes

PUSHES = ("push_forward", "push_outward", "push_up")  # motors whose control is a force [N]
CARRIED = "carried"  # prefix of the names of geoms that are visible only with a load
_DIRECTIONS = ([1, 0, 0], [0, -1, 0], [0, 0, 1])
_DRAWN = 2  # group of geoms that are only drawn


@dataclass(frozen=True)
class Edits:
    """Changes of a specification by `apply`; models are compiled once for each `key`."""

    key: str
    apply: Callable[[mujoco.MjSpec], None] = field(compare=False)


def edit(spec: mujoco.MjSpec, edits: Edits) -> None:
    """Applies edits, and removes keyframes, whose sizes the edits may change."""
    taken_keyframes(spec)
    edits.apply(spec)


def holder(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Returns the body that carries loads: the exoskeleton's ring, or the hand without one."""
    return spec.body("exo_hand") or spec.body("hand")


def grip(spec: mujoco.MjSpec) -> mujoco.MjsSite:
    """Returns the site at which loads act."""
    return spec.site("attachment_ring") or spec.site("hand_grip")


def add_pushes(spec: mujoco.MjSpec) -> None:
    """Adds motors that push the grip forward, outward and up, in the axes of the torso."""
    torso = spec.body("torso")
    site = torso.add_site(name="workplace", pos=spec.body("shoulder").pos, group=4)
    for name, direction in zip(PUSHES, _DIRECTIONS, strict=True):
        spec.add_actuator(
            name=name,
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            target=grip(spec).name,
            refsite=site.name,
            gear=[*direction, 0, 0, 0],
        )


def add_reaction(spec: mujoco.MjSpec, name: str, limit: float, damping: float) -> None:
    """Adds a force that withstands the grip's motion in the direction of flexion, and no other.

    The force grows with speed by `damping` [N·s/m] up to a limit [N], and cannot drive the arm.
    """
    spec.add_actuator(
        name=name,
        trntype=mujoco.mjtTrn.mjTRN_SITE,
        target=grip(spec).name,
        gear=[1, 0, 0, 0, 0, 0],
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=np.zeros(10),
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0, 0, -damping, *[0] * 7],
        forcelimited=True,
        forcerange=[-limit, 0],
    )


def draw(
    body: mujoco.MjsBody,
    shape: mujoco.mjtGeom,
    material: str,
    *,
    pos: Sequence[float] = (0, 0, 0),
    size: Sequence[float] = (0, 0, 0),
    name: str = "",
    fromto: Sequence[float] | None = None,
) -> mujoco.MjsGeom:
    """Adds a geom that is only drawn; positions are in the frame of the body [m]."""
    geom = body.add_geom(
        type=shape, pos=pos, size=size, group=_DRAWN, contype=0, conaffinity=0, mass=0
    )
    geom.material = material
    if name:
        geom.name = name
    if fromto is not None:
        geom.fromto = fromto
    return geom


def draw_bar(
    body: mujoco.MjsBody,
    shape: mujoco.mjtGeom,
    material: str,
    radius: float,
    begin: Sequence[float] | Array,
    end: Sequence[float] | Array,
) -> None:
    """Adds a capsule or cylinder between two points of the frame of the body [m], only drawn."""
    draw(body, shape, material, size=[radius, 0, 0], fromto=[*begin, *end])


def straight_arm(spec: mujoco.MjSpec) -> float:
    """Returns the distance from the shoulder to the grip of the straight right arm [m]."""
    reach = spec.body("forearm").pos + spec.body("hand").pos + spec.site("hand_grip").pos
    return float(np.linalg.norm(reach))


def place_of(spec: mujoco.MjSpec, angles: Array, point: Array) -> Array:
    """Returns a point of the right hand [m] in the frame of the torso [m].

    `angles` are shoulder, elbow and wrist flexion [rad], shape (3,); abduction is zero.
    """
    place = np.asarray(point, float)
    offsets = (spec.body("hand").pos, spec.body("forearm").pos, spec.body("shoulder").pos)
    for angle, offset in zip(angles[::-1], offsets, strict=True):
        s, c = np.sin(angle), np.cos(angle)  # flexion turns down to forward
        turned = np.array([c * place[0] - s * place[2], place[1], s * place[0] + c * place[2]])
        place = turned + offset
    return place
