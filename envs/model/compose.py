"""Turns a configuration into a MuJoCo model with the suit inside the physics, and loads models."""

import copy
import math
import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from ...assets import SCENE, Suit, SuitJoint, load_suit
from ...errors import InputError, shown
from ...hysteresis import engine
from ..freed_memory import give_back_after
from ..person import segments
from . import bushing
from .config import GRAVITY, NO_SUIT, ArmConfig, Payload
from .cuffs import couple
from .encoders import delay_encoders
from .exoskeleton import ASSISTED, fit_exoskeleton, remove_exoskeleton
from .fitting import attach_others, attach_suit, fit_person, remove_suit
from .variants import make_lean, mirror, remove_drawings, taken_keyframes
from .workplace import Edits, edit, grip, holder


def compose(
    config: ArmConfig,
    *,
    drawn: bool = True,
    other_suits: Sequence[Suit] = (),
    edits: Edits | None = None,
) -> mujoco.MjModel:
    """Builds the arm, suit and exoskeleton of `config`; every call returns a new model.

    Args:
        config: Configuration of the model.
        drawn: Whether the model has the parts that are only drawn: 244 of 255 geoms, lights and
            cameras. Without these parts the motion is the same to the last digit and takes a third
            less time.
        other_suits: Suits that `replace_model` can activate instead, also with models of another
            kind or size.
        edits: Additions of a task to the model.

    Raises:
        InputError: The suit is unknown, a pressure is given for a suit without one of its own, or a
            joint has no steady cycle to begin with.
        UncertifiedModelError: The suit is not certified and `allow_uncertified` is not set.
    """
    suit = suit_of_config(config)
    others = tuple(other.model_dump_json() for other in other_suits)
    own = None if suit is None else suit.model_dump_json()
    model = copy.copy(_compiled(config, own, drawn, others, edits))
    give_back_after(model)
    return model


def arm_spec(config: ArmConfig) -> mujoco.MjSpec:
    """Returns the specification that `compose` compiles, to add tools, sensors or a scene to it."""
    return _built(config, suit_of_config(config))


def bare_arm(config: ArmConfig) -> mujoco.MjModel:
    """Returns the wearer's arm alone, for inverse dynamics: no suit, exoskeleton or load."""
    alone = ArmConfig(
        suit=NO_SUIT,
        gravity=config.gravity,
        wearer=config.wearer,
        side=config.side,
        tilt=config.tilt,
        coupling="none",
    )
    return copy.copy(_bare(alone))


def suit_of_config(config: ArmConfig) -> Suit | None:
    """Returns the suit at its operating pressure, with its initial memory; None without a suit.

    A suit whose torque changes over its cycles is in the first of them, or after many if it is
    preconditioned.
    """
    if config.suit == NO_SUIT:
        return None
    suit = load_suit(config.suit)
    if config.pressure is not None:
        suit = suit.at_pressure(config.pressure)
    # If the share of the gas is known, its straight line is added now, for episodes to scale.
    shares = {
        joint: entry.at_pressure_ratio(1.0)
        for joint, entry in suit.joints.items()
        if entry.volume_share is not None
    }
    suit = suit.model_copy(update={"joints": {**suit.joints, **shares}}) if shares else suit
    return suit.after(math.inf).preconditioned() if config.preconditioned else suit.after(0)


def resisting_joints(config: ArmConfig) -> dict[str, SuitJoint]:
    """Returns the joints that the suit resists, at its operating pressure."""
    suit = suit_of_config(config)
    return {} if suit is None else dict(suit.joints)


@lru_cache(maxsize=8)
def _bare(config: ArmConfig) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_file(str(SCENE))
    fit_person(spec, config.wearer)
    for part in [*spec.keys, *spec.sensors]:
        spec.delete(part)
    remove_suit(spec)
    remove_exoskeleton(spec)
    # Inertias are explicit, so shapes can go too: inverse dynamics is then three times faster.
    shapes = [*spec.geoms, *spec.sites, *spec.meshes, *spec.materials, *spec.textures]
    for part in [*spec.actuators, *shapes]:
        spec.delete(part)
    for joint in spec.joints:
        joint.armature = 0.0
    _place(spec, config)
    return spec.compile()


@lru_cache(maxsize=8)
def _compiled(
    config: ArmConfig, suit: str | None, drawn: bool, others: tuple[str, ...], edits: Edits | None
) -> mujoco.MjModel:
    # The key has the content of the suit file, since the file at a path may change.
    parsed = None if suit is None else Suit.model_validate_json(suit)
    spec = _built(config, parsed, edits, drawn=drawn)
    other_suits = [Suit.model_validate_json(other) for other in others]
    attach_others(spec, parsed, other_suits, allow_uncertified=config.allow_uncertified)
    if not drawn:
        make_lean(spec)
    return spec.compile()


def _built(
    config: ArmConfig, suit: Suit | None, edits: Edits | None = None, *, drawn: bool = True
) -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(SCENE)) if drawn else _undrawn().copy()
    spec.option.timestep = config.timestep
    fit_person(spec, config.wearer)
    _strip(spec, config)
    if config.coupling != "none":
        fit_exoskeleton(spec, config.exo)
    if config.payload.mass > 0:
        _add_payload(spec, config.payload)
    if edits is not None:
        edit(spec, edits)
    delay_encoders(spec, config.exo.encoder_delay)
    _place(spec, config)
    if config.coupling == "cuffs":
        own = segments(config.wearer)
        excess = {
            name: length - own[name].length
            for name, length in config.exo.lengths.items()
            if length is not None
        }
        couple(spec, config.misalignment, excess)
    if suit is not None:
        attach_suit(spec, suit, allow_uncertified=config.allow_uncertified)
    return spec


@lru_cache(maxsize=1)
def _undrawn() -> mujoco.MjSpec:
    """Returns the scene without drawings, cached: the deletion takes longer than the rest."""
    spec = mujoco.MjSpec.from_file(str(SCENE))
    keyframes = taken_keyframes(spec)
    remove_drawings(spec)
    for keyframe in keyframes:
        spec.add_key(**keyframe)
    return spec


def _strip(spec: mujoco.MjSpec, config: ArmConfig) -> None:
    """Removes the parts that a configuration lacks."""
    keyframes = taken_keyframes(spec)  # their sizes depend on the next lines
    if config.suit == NO_SUIT:
        remove_suit(spec)
    if config.coupling == "none":
        remove_exoskeleton(spec)
        for keyframe in keyframes:
            keyframe |= {"act": [], "ctrl": keyframe["ctrl"][: -len(ASSISTED)]}
    if config.gravity == "microgravity":
        spec.delete(spec.geom("floor"))
        for geom in spec.body("foot_restraint").geoms:
            geom.group = 2
    else:
        spec.delete(spec.body("foot_restraint"))
    for keyframe in keyframes:
        spec.add_key(**keyframe)


def _add_payload(spec: mujoco.MjSpec, payload: Payload) -> None:
    center = grip(spec).pos - np.array([0, 0, payload.radius])
    body = holder(spec).add_body(name="payload", pos=center)
    body.mass, body.inertia, body.explicitinertial = payload.mass, payload.moments, True
    body.ipos = np.zeros(3)  # without this line, `center` again, and saved without the mass
    body.add_geom(
        name="payload",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[payload.radius, 0, 0],
        group=2,
        contype=2,
        mass=0,
        material="exo_steel",
    )


def _place(spec: mujoco.MjSpec, config: ArmConfig) -> None:
    """Chooses the side, leans the torso on the hips, and lets gravity act."""
    if config.side == "left":
        mirror(spec)
    spec.option.gravity = [0, 0, -GRAVITY[config.gravity]]
    pitch, roll = config.tilt
    lean = np.zeros(4)
    mujoco.mju_mulQuat(
        lean,
        np.array([math.cos(pitch / 2), 0, math.sin(pitch / 2), 0]),
        np.array([math.cos(roll / 2), math.sin(roll / 2), 0, 0]),
    )
    hips, torso = spec.body("legs"), spec.body("torso")
    raised = np.zeros(3)
    mujoco.mju_rotVecQuat(raised, torso.pos - hips.pos, lean)
    torso.pos, torso.quat = hips.pos + raised, lean


PID, FIXED = mujoco.mjtGain.mjGAIN_PID, mujoco.mjtGain.mjGAIN_FIXED
AUTORESET = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def for_warp(config: ArmConfig) -> mujoco.MjModel:
    """Builds the arm and the exoskeleton of a configuration for MuJoCo Warp.

    The model has no drawings, no plugins and no keyframes. `activesuit.hysteresis.warp.attach` adds
    the torque of the suit: models and starts are those of `resisting_joints(config)`. The inputs
    are those of the wearer's four actuators, and then those of the motors. Each of the wearer's
    actuators has one input u instead of three. Its torque is u - kp q - kv v within the same
    limits, where kp and kv are `-actuator_biasprm[i, 1:3]`. So u = kp q* + kv v* + ff gives the
    torque that `compose` gives with the inputs q*, v* and ff, to the last bit in MuJoCo. The caller
    must keep the ranges of these three inputs.
    """
    if config.coupling == "cuffs":
        raise InputError(
            "coupling is 'cuffs', whose forces are a plugin, and MuJoCo Warp has no plugins: use "
            "'rigid' or 'none'"
        )
    spec = _built(config, None, drawn=False)
    taken_keyframes(spec)
    for motor in spec.actuators:
        if motor.gaintype == PID:
            motor.gaintype, motor.gainprm, motor.ctrlspec = FIXED, np.eye(10)[0], 0
    spec.option.disableflags &= ~AUTORESET
    make_lean(spec)
    return spec.compile()


READERS = {".xml": mujoco.MjModel.from_xml_path, ".mjb": mujoco.MjModel.from_binary_path}


def load_model(path: str | os.PathLike[str]) -> mujoco.MjModel:
    """Returns the model in a file of MJCF (.xml) or in MuJoCo's binary format (.mjb).

    A binary file has the numbers of its plugins, and not their names: all plugins must be
    registered in the same order as in the process that saved the file, or MuJoCo ends the process.
    MJCF has the names, and MuJoCo reports an unknown name.
    """
    engine.register()
    bushing.register()
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"the model is {shown(path)}: give the path of a .xml or .mjb file")
    file = Path(path)
    read = READERS.get(file.suffix.lower())
    if read is None:
        raise InputError(
            f"{shown(str(path))} is no .xml and no .mjb file: give one of these, or save the model "
            "as one"
        )
    if not file.is_file():
        raise InputError(f"there is no file {shown(str(path))}: give the path of a model")
    try:
        return read(str(file))
    except ValueError as error:
        why = " ".join(str(error).split())
        raise InputError(
            f"MuJoCo {mujoco.__version__} cannot load {shown(str(path))} ({why}): repair the file, "
            "or save the model again with this version"
        ) from error
