"""Attaches hysteresis models to joints of any MuJoCo model, and replaces attached models."""

import math
import re
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...checks import numbers
from ...errors import InputError, unknown_name
from ..around import Wrapper, parts
from ..around import backlash_kernels as backlash
from ..around import viscoelastic_kernels as viscoelastic
from ..protocol import HysteresisModel, State, follow, read_only
from ..registry import MODELS
from ..safety import require_certificate
from ._callbacks import plugin_name, register
from ._configuration import FAULT, MEMORY, OFF, model_of, state_of
from .native import Instance, compile_plugin

SENSORS = ("torque", "stiffness", "dissipated_energy")
INSTANCE = re.compile(r"(.*)_suit(?:_\d+)?")
JOINT_TYPES = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


def attach(
    spec: mujoco.MjSpec,
    joint: str,
    model: HysteresisModel,
    *,
    start_angle: float | None = None,
    start_torque: float = 0.0,
    start_path: Sequence[float] = (),
    sensors: bool = True,
    allow_uncertified: bool = False,
    taken_off: bool = False,
) -> None:
    """Makes `joint` resist its motion with the hysteretic torque of `model`.

    The torque acts as a generalized force (in `qfrc_passive`) at every physics step, under every
    integrator. A reset starts the memory at (start_angle, start_torque) and moves the memory
    through `start_path`, as `HysteresisModel.response` would. A keyframe or a written `qpos` acts
    like one monotone motion from there, but the memory follows only at the end of a step: if that
    step turns back, the written position does not count as a turning point.

    `sensors` adds three sensors: `<joint>_suit_torque`, the torque that acts on the joint [N·m];
    `<joint>_suit_stiffness`, dM/dtheta in the current direction of motion [N·m/rad]; and
    `<joint>_suit_dissipated_energy` [J], which never decreases in a motion of a certified model.

    Compose first, attach last: when a spec is attached to another one under a name prefix, MuJoCo
    renames its joints, but not the joint in the plugin's config.

    Args:
        spec: Any model specification, which is changed in place.
        joint: Name of a hinge joint (rad) or a slide joint (m, taken as the model's angle).
        model: Model of the resistance, which is positive against positive motion.
        start_angle: Angle at which the memory begins [rad]; by default the joint's reference
            position.
        start_torque: Resistance at that angle [N·m].
        start_path: Angles through which the memory then moves [rad], in a monotone motion each. The
            energy that these motions dissipate counts as dissipated.
        sensors: Whether to add the three sensors.
        allow_uncertified: Whether to accept a model without a certificate. At a pole the simulation
            then keeps the last valid torque, sets the fault flag and warns.
        taken_off: Whether the model gives no torque until `replace_model` puts one of its kind on.
            A joint may have several such models beside the model that resists; the names of these
            models and of their sensors have a number: `<joint>_suit_2`.

    Raises:
        UncertifiedModelError: The model has no certificate, or the start is outside of it.
        PoleError: The path meets the pole of an uncertified model.
    """
    target = _target(spec, joint)
    _require_model(model)
    instance, taken = f"{joint}_suit", {plugin.name for plugin in spec.plugins}
    if instance in taken and not taken_off:
        raise InputError(f"joint {joint!r} has a hysteresis model already: attach one per joint")
    while instance in taken:
        instance = f"{joint}_suit_{int(instance.removeprefix(f'{joint}_suit').strip('_') or 1) + 1}"
    start = model.start(
        _reference(spec, target) if start_angle is None else start_angle, start_torque
    )
    if not allow_uncertified:
        require_certificate(model, start, joint)
    is_empty = isinstance(start_path, Sequence) and not start_path
    path = () if is_empty else numbers("start_path", start_path, "rad")
    follow(model, start, path)
    register()
    name, config = _config(model)
    compile_plugin(name)
    if name not in {plugin.plugin_name for plugin in spec.plugins}:
        spec.activate_plugin(name)
    config |= {"joint": joint, "start_torque": repr(float(start_torque))}
    if start_angle is not None:
        config["start_angle"] = repr(start.angle)
    if path:
        config["start_path"] = _text(path)
    if allow_uncertified:
        config["allow_uncertified"] = "true"
    if taken_off:
        config["taken_off"] = "true"
    plugin = spec.add_plugin(name=instance, plugin_name=name, active=True)
    plugin.config = config
    for quantity in SENSORS if sensors else ():
        sensor = spec.add_sensor(name=f"{instance}_{quantity}", type=mujoco.mjtSensor.mjSENS_PLUGIN)
        sensor.plugin = plugin


def _target(spec: mujoco.MjSpec, joint: str) -> mujoco.MjsJoint:
    """Returns the joint of that name, which must be a hinge or a slide joint."""
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
    return target


def fault_slots(model: mujoco.MjModel) -> NDArray[np.int64]:
    """Returns the place of each hysteretic joint's fault flag in `data.plugin_state`.

    A flag is 2 where the model is taken off, and 1 from a motion that meets the model's pole until
    the next reset. Meanwhile the joint's torque is constant, and MuJoCo logs a warning. Certified
    models never set the flag. MuJoCo's `autoreset` resets the flags of a simulation that diverges.
    """
    ours = np.flatnonzero(np.isin(model.plugin, list(register().values())))
    return model.plugin_stateadr[ours].astype(np.int64) + FAULT


def replace_model(
    mj_model: mujoco.MjModel,
    plugin_state: NDArray[np.float64],
    joint: str,
    model: HysteresisModel,
    *,
    start_angle: float | None = None,
    start_torque: float | None = None,
    start_path: Sequence[float] | None = None,
    keep_memory: bool = False,
    allow_uncertified: bool = False,
) -> None:
    """Gives one simulation another model of the same kind and size, as in a randomized batch.

    Where models of several kinds are attached to the joint, the new model replaces the model of its
    kind, and all other models are taken off.

    Parameters and memory are part of the simulation's state, so each row of a batch may have its
    own. The memory starts again, by default at the start of the compiled model, and `mj_forward`
    brings forces and sensors up to date. A reset brings the compiled model's parameters back.

    With `keep_memory` the new model continues the motion of the present model, as for a slider that
    changes parameters during a motion. The inner state stays, so the torque changes no more than
    the parameters do: M / Ms of Jiles-Atherton, z of Bouc-Wen, the share of the friction in its
    limit of Dahl and Duhem, the strain of each stop of Prandtl-Ishlinskii and hinged stops, the
    turning points of Preisach, the angle of the suit's side in a play, the deflection of a Maxwell
    element, and the torque of a model from another package without a `carry_over` of its own. A
    state beyond a limit of the new parameters moves to that limit. The dissipated energy goes on
    from its value.

    Args:
        mj_model: Compiled model, with a hysteresis model attached to `joint`.
        plugin_state: The array `data.plugin_state`, or one simulation's row of a batch, which is
            changed in place.
        joint: Name of the joint.
        model: New hysteresis model.
        start_angle: Angle at which the memory begins [rad]; None takes the compiled model's.
        start_torque: Resistance at that angle [N·m]; None takes the compiled model's.
        start_path: Angles of motions after the start [rad]; None takes the compiled model's.
        keep_memory: Whether the new model continues the present motion, without a start.
        allow_uncertified: Whether to accept a model without a certificate.

    Raises:
        UncertifiedModelError: The model has no certificate, or the start is outside of it.
    """
    instances = _instances_at(mj_model, joint)
    _require_model(model)
    if not (
        isinstance(plugin_state, np.ndarray)
        and plugin_state.dtype == np.float64
        and plugin_state.ndim == 1
    ):
        raise InputError(
            "plugin_state must be data.plugin_state or a row of a batch: a float64 array of one "
            f"dimension, not {type(plugin_state).__name__}"
        )
    if plugin_state.size < mj_model.npluginstate:
        raise InputError(
            f"plugin_state has {plugin_state.size} numbers: the compiled model has more; give all "
            "of it"
        )
    same = (i for i in instances if _layout(_compiled(mj_model, i)) == _layout(model))
    instance = next(same, None)
    if instance is None:
        raise InputError(
            f"joint {joint!r} was compiled with another kind or size of model than this "
            f"{model.name} one: replace a model by one with as many parameters"
        )
    begin, size = mj_model.plugin_stateadr[instance], mj_model.plugin_statenum[instance]
    state = plugin_state[begin : begin + size]
    split = parts(model)
    if keep_memory:
        if any(given is not None for given in (start_angle, start_torque, start_path)):
            raise InputError(
                "keep_memory is True, and a start is given: leave start_angle, start_torque and "
                "start_path out, or keep_memory"
            )
        start, path = _kept(model, state, joint), []
        if split.viscoelastic.size:
            old = state[: state.size - split.gap.size][-viscoelastic.SIZE :]
            split = split._replace(viscoelastic=viscoelastic.carried(split.viscoelastic, old))
    else:
        config = Instance(mj_model._address, instance).config
        path = [float(angle) for angle in config["start_path"].split()]
        if start_angle is None:
            start_angle = float(config["start_angle"] or mj_model.joint(joint).qpos0[0])
        if start_torque is None:
            start_torque = float(config["start_torque"] or 0.0)
        start = model.start(start_angle, start_torque)
    if not allow_uncertified:
        require_certificate(model, start, joint)
    begun = follow(model, start, path if start_path is None else start_path)
    take_off(mj_model, plugin_state, joint)
    state[:] = state_of(split, begun)


def _kept(model: HysteresisModel, state: Array, joint: str) -> State:
    """Returns the state of a model that continues the motion in an instance's part of a state."""
    if state[FAULT] != 0:
        why = "it is taken off" if state[FAULT] == OFF else "its torque has met a pole"
        raise InputError(
            f"keep_memory is True, but the {model.name} model of joint {joint!r} has no memory to "
            f"keep: {why}; leave keep_memory out"
        )
    bare, *_, play = parts(model)
    end = MEMORY + bare.memory_size
    memory, parameters = state[MEMORY:end], state[end : end + bare.parameter_vector.size]
    if play.size:
        memory = np.append(memory, state[backlash.END - backlash.SIZE])
    if not np.array_equal(parameters, bare.parameter_vector):
        memory = model.carry_over(memory, parameters)
    return State(read_only(memory), float(memory[0]), float(memory[1]))


def take_off(mj_model: mujoco.MjModel, plugin_state: NDArray[np.float64], joint: str) -> None:
    """Removes the hysteretic torque of a joint in one simulation, until `replace_model` or a reset.

    `plugin_state` is `data.plugin_state`, or a row of a batch, and is changed in place.
    """
    for instance in _instances_at(mj_model, joint):
        plugin_state[mj_model.plugin_stateadr[instance] + FAULT] = OFF


def same_layout(model: HysteresisModel, other: HysteresisModel) -> bool:
    """Returns whether `replace_model` can replace one of two models by the other."""
    return _layout(model) == _layout(other)


def _layout(model: HysteresisModel) -> tuple[object, ...]:
    """Returns the class of the innermost model, and the sizes of the parts of the state."""
    bare, *around = parts(model)
    sizes = (part.size for part in around)
    return type(bare), bare.memory_size, bare.parameter_vector.size, *sizes


def _compiled(mj_model: mujoco.MjModel, number: int) -> HysteresisModel:
    """Returns the model of a compiled instance."""
    kinds = {slot: name for name, slot in register().items()}
    name = kinds[int(mj_model.plugin[number])]
    kind = next(one for one in MODELS.values() if plugin_name(one) == name)
    return model_of(kind, Instance(mj_model._address, number).raw)


def _instances_at(mj_model: mujoco.MjModel, joint: str) -> list[int]:
    """Returns the instances that `attach` has put on a joint."""
    kind = mujoco.mjtObj.mjOBJ_PLUGIN
    names = [mujoco.mj_id2name(mj_model, kind, i) or "" for i in range(mj_model.nplugin)]
    joints = [INSTANCE.fullmatch(name) for name in names]
    found = [i for i, match in enumerate(joints) if match and match[1] == joint]
    if not found:
        attached = (match[1] for match in joints if match)
        raise unknown_name("joint with a hysteresis model", joint, attached)
    return found


def _require_model(model: object) -> None:
    bare = parts(model).bare if isinstance(model, HysteresisModel) else None
    if bare is None or MODELS.get(bare.name) is not type(bare):
        raise InputError(
            f"model is a {type(model).__name__}: give one of activesuit's hysteresis models, or a "
            "model of a class that register_model has registered"
        )


def _config(model: HysteresisModel) -> tuple[str, dict[str, str]]:
    """Returns the name of the model's plugin and its parameters as MJCF config."""
    config = {}
    while isinstance(model, Wrapper):
        config[model.place] = _text(model.given)
        model = model.model
    own = {key: _text(value) for key, value in model.config().items()}
    return plugin_name(type(model)), own | config


def _text(value: float | str | Sequence[float]) -> str:
    if isinstance(value, str):
        return value
    return " ".join(map(repr, value)) if isinstance(value, Sequence) else repr(value)


def _reference(spec: mujoco.MjSpec, joint: mujoco.MjsJoint) -> float:
    """Returns the joint's reference position, which its qpos has after a reset."""
    in_degrees = spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE
    return math.radians(joint.ref) if in_degrees else joint.ref
