"""Puts a hysteresis model on a joint of any MuJoCo model."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, unknown_name
from ..certificate import UncertifiedModelError
from ..jiles_atherton import PARAMETERS, JilesAtherton
from ._registration import PLUGIN_NAME, register
from ._state import FAULT

SENSORS = ("torque", "stiffness", "dissipated_energy")
JOINT_TYPES = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


def attach(
    spec: mujoco.MjSpec,
    joint: str,
    model: JilesAtherton,
    *,
    start_angle: float | None = None,
    start_torque: float = 0.0,
    sensors: bool = True,
    allow_uncertified: bool = False,
) -> None:
    """Makes `joint` resist its motion with the hysteretic torque of `model`.

    The torque acts as a generalized force (in `qfrc_passive`) at every physics step, under every
    integrator. After a reset the memory stands at (start_angle, start_torque); the first position
    that the simulation sees is reached from there in one monotone motion, so a keyframe or a
    written `qpos` begins on the first branch from `start_angle`.

    With `sensors`, three are added: `<joint>_suit_torque`, the torque that acts on the joint [N·m];
    `<joint>_suit_stiffness`, dM/dtheta in the current direction of motion [N·m/rad]; and
    `<joint>_suit_dissipated_energy` [J], which never decreases for a certified model.

    Compose first, attach last: when a spec is attached to another one under a name prefix, MuJoCo
    renames its joints, but not the joint in the plugin's config.

    Args:
        spec: any model specification; it is changed in place.
        joint: name of a hinge (rad) or slide joint (m, read as the model's angle).
        model: the resistance, positive against positive motion.
        start_angle: where the memory begins [rad]; by default the joint's reference position.
        start_torque: the resistance there [N·m].
        sensors: whether to add the three sensors.
        allow_uncertified: accept a model without a certificate; at a pole the simulation then
            holds the last valid torque, sets the fault flag and warns.

    Raises:
        InputError: there is no such joint, it is neither hinge nor slide, or it has a suit already.
        UncertifiedModelError: the model, or its start, is outside the certificate.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise InputError(
            f"attach got a {type(spec).__name__}: give a mujoco.MjSpec, from MjSpec.from_file "
            "or from_string"
        )
    target = next((j for j in spec.joints if j.name == joint), None)
    if target is None:
        raise unknown_name("joint", joint, (j.name for j in spec.joints if j.name))
    if target.type not in JOINT_TYPES:
        raise InputError(f"joint {joint!r} is a {target.type.name}: use a hinge or a slide joint")
    instance = f"{joint}_suit"
    if any(plugin.name == instance for plugin in spec.plugins):
        raise InputError(f"joint {joint!r} has a hysteresis model already: attach one per joint")
    start = model.start(
        _reference(spec, target) if start_angle is None else start_angle, start_torque
    )
    if not allow_uncertified:
        _require_certificate(model, start, joint)
    if PLUGIN_NAME not in {plugin.plugin_name for plugin in spec.plugins}:
        spec.activate_plugin(PLUGIN_NAME)
    config = {"joint": joint, "angle_unit": model.angle_unit, "start_torque": repr(start.torque)}
    config |= {name: repr(getattr(model, name)) for name in PARAMETERS}
    if start_angle is not None:
        config["start_angle"] = repr(start.angle)
    if allow_uncertified:
        config["allow_uncertified"] = "true"
    plugin = spec.add_plugin(name=instance, plugin_name=PLUGIN_NAME, active=True)
    plugin.config = config
    for quantity in SENSORS if sensors else ():
        sensor = spec.add_sensor(name=f"{instance}_{quantity}", type=mujoco.mjtSensor.mjSENS_PLUGIN)
        sensor.plugin = plugin


def fault_slots(model: mujoco.MjModel) -> NDArray[np.int64]:
    """Returns where in `data.plugin_state` each hysteretic joint keeps its fault flag.

    A flag is 1 from the moment a motion met the model's pole, until the next reset; the joint's
    torque is held meanwhile, and MuJoCo logs a warning. Certified models never set it. With
    MuJoCo's `autoreset` on, a simulation that goes on to diverge is reset, flag included.
    """
    ours = np.flatnonzero(model.plugin == register())
    return model.plugin_stateadr[ours].astype(np.int64) + FAULT


def _reference(spec: mujoco.MjSpec, joint: mujoco.MjsJoint) -> float:
    """Returns the joint's reference position, which its qpos has after a reset."""
    in_degrees = spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE
    return math.radians(joint.ref) if in_degrees else joint.ref


def _require_certificate(model: JilesAtherton, start, joint: str) -> None:
    certificate = model.certificate()
    if not (certificate.certified and certificate.dissipative):
        raise UncertifiedModelError(
            f"the model for joint {joint!r} has certificate margin {certificate.margin:.3g} and "
            f"c = {model.c:.4g}: margin must be above 0 and c at least 1 for the torque to stay "
            "finite and resistive in any motion; use a certified fit, or allow_uncertified=True "
            "(--allow-uncertified)"
        )
    away = abs(start.torque - model.anhysteretic(start))
    if not away <= certificate.memory_bound:
        raise UncertifiedModelError(
            f"the start of joint {joint!r} at {start.angle:.4g} rad, {start.torque:.4g} N·m lies "
            f"{away:.3g} N·m from the anhysteretic torque, outside the certificate's "
            f"{certificate.memory_bound:.3g} N·m: start nearer to it, or allow_uncertified=True"
        )
