"""The exoskeleton on its own joints, connected to the arm by compliant cuffs.

arm.xml mounts the exoskeleton rigidly: its parts move with the segments of the arm, and its motors
act on the wearer's joints. Here they become a chain of their own, beside the arm's on the torso,
and three bushings carry all force between the two: at the guards of upper arm and forearm, and at
the ring that holds the glove.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import mujoco
import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError
from ..provenance import numbers_of, values_of
from .bushing import Bushing, Triple, attach_bushing, move_bushing
from .fitting import stretch
from .variants import taken_keyframes

PROVENANCE = numbers_of("cuff")
_VALUE = values_of(PROVENANCE)
_SEGMENTS = ("upper_arm", "forearm", "hand")
FORCE_LIMITS = {segment: _VALUE[f"cuff.{segment}.force_limit"] for segment in _SEGMENTS}
"""Largest force that a person should bear from a machine, by segment [N]."""

# Bodies of the exoskeleton, and the body of the arm in whose frame each is drawn.
CHAIN = {
    "exo_shoulder_support": "shoulder",
    "exo_upper_arm": "upper_arm",
    "exo_forearm": "forearm",
    "exo_hand": "hand",
}
CUFF_SITES = {"upper_arm": "cuff_upper_arm", "forearm": "cuff_forearm", "hand": "attachment_ring"}
MOVED = "moved_"  # prefix of copies until they replace the original


def _cuff(mass: float) -> Bushing:
    """Returns a cuff whose dampers are proportional to its springs (Kelvin-Voigt).

    The damping ratio is that of the effective mass of the segment on the stiffest spring.
    """
    across, along, about_across, about_along = (
        _VALUE[f"cuff.stiffness.{way}"]  # [N/m] and [N·m/deg]
        for way in ("across", "along", "about_across", "about_along")
    )
    turning = [math.degrees(about_across), math.degrees(about_along)]
    stiffness = np.array([across, across, along])
    rotational = np.array([turning[0], *turning])  # N·m/rad
    loss_time = 2 * _VALUE["cuff.damping_ratio"] * math.sqrt(mass / across)
    return Bushing(
        stiffness=tuple(stiffness),
        rotational_stiffness=tuple(rotational),
        damping=tuple(loss_time * stiffness),
        rotational_damping=tuple(loss_time * rotational),
    )


CUFFS = {segment: _cuff(_VALUE[f"cuff.{segment}.mass"]) for segment in _SEGMENTS}
"""The cuff on each segment, z along the limb. Its stiffness was measured on the bare upper arm and
is assumed for the others, and through the sleeve of a suit."""


def couple(
    spec: mujoco.MjSpec,
    misalignment: Triple = (0.0, 0.0, 0.0),
    excess: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Turns the arm with its rigid exoskeleton into two chains joined by cuffs, in place.

    `spec` is arm.xml after it was fitted, loaded and mirrored, and before the suit is attached. The
    exoskeleton gets the joints `exo_<joint>`, in the order of the arm's joints and behind them in
    `qpos`, with the same axes and ranges. Motors, encoders and Coulomb friction move to these
    joints. Each cuff is a bushing `cuff_upper_arm`, `cuff_forearm` or `cuff_hand` with its three
    sensors (see `attach_bushing`), between a new site `limb_<segment>` and the site of the
    exoskeleton, z up the limb. Keyframes put both chains into one pose. The default arm bears steps
    of 2 ms, but not 4 ms.

    `misalignment` is the vector from the wearer's shoulder center to that of the exoskeleton,
    forward, outward and up [m], and moves the whole exoskeleton. `excess` is the length of each
    link less that of the wearer's segment [m], and moves the parts below the link. The cuffs are
    strapped on with the arm hanging, so that neither makes the cuffs bear a force there.
    """
    if spec.body("exo_hand") is None or spec.joint("exo_wrist_flexion") is not None:
        raise InputError("the model is not the arm of arm.xml with its rigid exoskeleton: give it")
    outward = np.sign(spec.body("shoulder").pos[1])
    shift = np.array(misalignment) * (1, outward, 1)
    keyframes = taken_keyframes(spec)  # they prevent moving bodies
    base = spec.body("exo_base")
    base.pos = base.pos + shift
    begins = [shift, np.zeros(3), *_lengthen(spec, excess)]
    ends = _let_go(spec)
    _move(spec, begins)
    for name, (target, reference) in ends.items():
        spec.actuator(name).target, spec.actuator(name).refsite = target, reference
    for joint in JOINTS:
        _hand_over(spec, joint)
    hanging = np.cumsum(begins, axis=0)[1:]  # position of each part in its segment
    for (segment, name), away in zip(CUFF_SITES.items(), hanging, strict=True):
        site = spec.site(name)
        limb = spec.body(segment).add_site(name=f"limb_{segment}", pos=site.pos, quat=site.quat)
        limb.group, limb.size = site.group, site.size
        bushing = replace(CUFFS[segment], offset=tuple((-away).tolist()))
        attach_bushing(spec, f"cuff_{segment}", limb.name, name, bushing)
    for keyframe in keyframes:
        arm = keyframe["qpos"][: len(JOINTS)]
        spec.add_key(**{**keyframe, "qpos": [*arm, *keyframe["qpos"]]})


def shift_exoskeleton(model: mujoco.MjModel, body_pos: Array, by: Array) -> None:
    """Moves the exoskeleton of one simulation on the torso: forward, outward, up [m], in place."""
    body_pos[model.body(next(iter(CHAIN))).id] += _in_torso(model, by)


def strap_again(model: mujoco.MjModel, plugin_state: Array, by: Array) -> None:
    """Straps the cuffs of one simulation on again after `shift_exoskeleton`, without force."""
    for segment in CUFFS:
        move_bushing(model, plugin_state, f"cuff_{segment}", -_in_torso(model, by))


def _in_torso(model: mujoco.MjModel, by: Array) -> Array:
    return by * (1, np.sign(model.body("shoulder").pos[1]), 1)


def _lengthen(spec: mujoco.MjSpec, excess: Mapping[str, float]) -> list[Array]:
    """Lengthens the drawn links; returns the displacements of the parts below the links."""
    lower = []
    for segment, below in (("upper_arm", "forearm"), ("forearm", "hand")):
        longer, length = excess.get(segment, 0.0), -spec.body(below).pos[2]
        stretch(spec.body(f"exo_{segment}"), np.array([1, 1, 1 + longer / length]), {})
        lower.append(np.array([0, 0, -longer]))
    return lower


def _let_go(spec: mujoco.MjSpec) -> dict[str, tuple[str, str]]:
    """Detaches actuators from the exoskeleton's sites, with which MuJoCo would delete them.

    Returns the names of both sites, target and reference, by the name of the actuator.
    """
    found = {}
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_SITE:
            found[actuator.name] = (actuator.target, actuator.refsite)
            actuator.target, actuator.refsite = "hand_grip", ""
    return found


def _move(spec: mujoco.MjSpec, begins: Sequence[Array]) -> None:
    """Makes the exoskeleton's bodies a chain that hangs on the torso."""
    spec.copy_during_attach = True  # MuJoCo can copy bodies of a spec, but not move them
    parent = spec.body("torso")
    for (part, segment), joint, begin in zip(CHAIN.items(), JOINTS, begins, strict=True):
        limb, sleeve = spec.body(segment), spec.body(part)
        frame = parent.add_frame(pos=limb.pos + begin, quat=limb.quat)
        parent = frame.attach_body(sleeve, MOVED, "")
        spec.delete(sleeve)
        for kind in ("body", "geom", "site", "camera", "light"):
            for element in [parent, *parent.find_all(kind)]:
                element.name = element.name.removeprefix(MOVED)
        for sensor in spec.sensors:  # sensors on the moved body are copies, too
            for field in ("name", "objname", "refname"):
                setattr(sensor, field, getattr(sensor, field).removeprefix(MOVED))
        given = spec.joint(joint)
        moved = parent.add_joint(name=f"exo_{joint}", axis=given.axis, range=given.range)
        moved.type, moved.limited = given.type, given.limited
    spec.copy_during_attach = False


def _hand_over(spec: mujoco.MjSpec, joint: str) -> None:
    """Moves motor, encoder and friction from a joint of the arm to that of the exoskeleton."""
    arm, exo = spec.joint(joint), spec.joint(f"exo_{joint}")
    for sensor in spec.sensors:
        if sensor.name.startswith("encoder_") and sensor.objname == joint:
            sensor.objname = exo.name
    wearer = spec.actuator(f"human_{joint}").forcerange
    motor = spec.actuator(f"assist_{joint}")
    if motor is not None:
        motor.target = exo.name
        arm.frictionloss, exo.frictionloss = 0.0, arm.frictionloss
        arm.actfrcrange, exo.actfrcrange = wearer, arm.actfrcrange - wearer
