"""Checks the arguments of `attach`, and makes the arrays of numbers of all worlds."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from ...errors import InputError, shown, unknown_name
from ..around import Wrapper
from ..c_code import LARGEST
from ..protocol import HysteresisModel, State
from ..safety import require_certificate
from .source import Source, row_of, source_of

if TYPE_CHECKING:
    from .worlds import Hysteresis

JOINT_TYPES = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
Models = HysteresisModel | Sequence[HysteresisModel]
Starts = State | Sequence[State]


def attach(
    m: Any,
    d: Any,
    mjm: mujoco.MjModel,
    models: Mapping[str, Models],
    *,
    starts: Mapping[str, Starts] | None = None,
    allow_uncertified: bool = False,
) -> "Hysteresis":
    """Makes joints of a MuJoCo Warp model resist their motion with the torque of models.

    From then on `mujoco_warp.step(m, d)` computes the torque in the passive callback of `m`, under
    every integrator, and adds the torque to `qfrc_passive`. An earlier callback of the model runs
    first. A world whose time goes back, as in `mujoco_warp.reset_data`, begins again at its start.
    A CUDA graph may capture all steps.

    Args:
        m: Model of MuJoCo Warp, whose passive callback is changed.
        d: Data of `m` with the worlds of the memories; the present times are not used.
        mjm: MuJoCo model from which `m` and `d` were made.
        models: Model of each joint, or a list of a model for each world, by name of a hinge joint
            (rad) or a slide joint (m). The models of a joint are of one kind and size.
        starts: State in which the memory of each joint begins, from `model.start`, or a list of a
            state for each world, by name of the joint; by default at the joint's reference
            position, without torque.
        allow_uncertified: Whether to accept models without a certificate. At a pole the torque then
            keeps its last valid value, and the fault flag is set until the world's next reset.

    Returns:
        Torques, work and fault flags of all worlds.

    Raises:
        UncertifiedModelError: A model has no certificate, or a start is outside of it.
    """
    try:
        import mujoco_warp

        from .worlds import Hysteresis, Joint
    except ImportError as error:
        raise InputError(
            f"MuJoCo Warp is not installed ({error}): run pip install 'activesuit[gpu]'"
        ) from error
    for name, value, kind, made in (
        ("m", m, mujoco_warp.Model, "mujoco_warp.put_model(mjm)"),
        ("d", d, mujoco_warp.Data, "mujoco_warp.make_data(mjm, nworld=...)"),
        ("mjm", mjm, mujoco.MjModel, "the mujoco.MjModel from which m was made"),
    ):
        if not isinstance(value, kind):
            raise InputError(f"{name} is {shown(value)}: give {made}")
    if (m.nq, m.nv, m.njnt, d.qpos.shape[1]) != (mjm.nq, mjm.nv, mjm.njnt, mjm.nq):
        raise InputError(
            f"m has {m.njnt} joints, d {d.qpos.shape[1]} positions, and mjm {mjm.njnt} joints and "
            f"{mjm.nq} positions: give a model and data that were made from mjm"
        )
    if not (isinstance(models, Mapping) and models):
        raise InputError(f"models is {shown(models)}: give a hysteresis model for each joint name")
    begins = starts or {}
    for name in begins:
        if name not in models:
            raise unknown_name("joint in starts", name, models)
    taken = Hysteresis.joints_of(m.callback.passive)
    joints = []
    for name, given in models.items():
        joint = _target(mjm, name)
        if name in taken:
            raise InputError(f"joint {name!r} has a hysteresis model already: attach one per joint")
        rows = _each(f"models[{name!r}]", given, HysteresisModel, d.nworld)
        start = begins.get(name)
        if start is None:
            reference = float(mjm.qpos0[mjm.jnt_qposadr[joint]])
            states = [model.start(reference) for model in rows]
        else:
            states = _each(f"starts[{name!r}]", start, State, d.nworld)
        if len(rows) != len(states):
            rows, states = (list(one) * (d.nworld // len(one)) for one in (rows, states))
        source, numbers = _numbers(name, rows, states, allow_uncertified)
        place = int(mjm.jnt_qposadr[joint]), int(mjm.jnt_dofadr[joint])
        joints.append(Joint(name, *place, tuple(rows), tuple(states), source, numbers))
    return Hysteresis(m, d, joints)


def _target(mjm: mujoco.MjModel, name: str) -> int:
    """Returns the id of the joint of that name, which must be a hinge or a slide joint."""
    joint = mujoco.mj_name2id(mjm, mujoco.mjtObj.mjOBJ_JOINT, name) if type(name) is str else -1
    if joint < 0:
        known = (mjm.joint(i).name for i in range(mjm.njnt))
        raise unknown_name("joint", name, (one for one in known if one))
    kind = mujoco.mjtJoint(mjm.jnt_type[joint])
    if kind not in JOINT_TYPES:
        raise InputError(f"joint {name!r} is a {kind.name}: use a hinge or a slide joint")
    return joint


def _each(name: str, given: Any, kind: type, worlds: int) -> list[Any]:
    """Returns a list of one value for all worlds, or of a value for each world."""
    rows = list(given) if isinstance(given, Sequence) else [given]
    wrong = next((one for one in rows if not isinstance(one, kind)), None)
    if wrong is not None:
        raise InputError(f"{name} is {shown(wrong)}: give a {kind.__name__}, or one for each world")
    if isinstance(given, Sequence) and len(rows) != worlds:
        raise InputError(
            f"{name} has {len(rows)} entries, and d has {worlds} worlds: give one for each world, "
            "or one for all of them"
        )
    return rows


def _numbers(
    joint: str, models: list[HysteresisModel], states: list[State], allow_uncertified: bool
) -> tuple[Source, np.ndarray]:
    """Returns the code of a joint's models, and their numbers, shape (1 or worlds, size)."""
    source, rows = source_of(models[0]), []
    checked: set[tuple[int, int]] = set()
    for world, (model, state) in enumerate(zip(models, states, strict=True)):
        if state.memory.size != model.memory_size:
            raise InputError(
                f"the start of world {world} at joint {joint!r} has {state.memory.size} numbers, "
                f"and its model {model.memory_size}: make the start by that model's own `start`"
            )
        rows.append(row_of(model, state))
        if _layout(model) != _layout(models[0]) or len(rows[world]) != len(rows[0]):
            raise InputError(
                f"models[{joint!r}][{world}] is a {model.name} model of another kind or size than "
                f"the {models[0].name} model of world 0: give a joint models of one kind and size"
            )
        if not allow_uncertified and (id(model), id(state)) not in checked:
            checked.add((id(model), id(state)))
            require_certificate(model, state, joint)
    numbers = np.array(rows)
    large = numbers[~(np.abs(numbers) <= LARGEST)]
    if large.size:
        raise InputError(
            f"a model of joint {joint!r} has the number {large[0]:g}: give one whose numbers are "
            f"finite and at most {LARGEST:g}, since Warp computes with 32 bits"
        )
    return source, numbers


def _layout(model: HysteresisModel) -> list[Any]:
    """Returns kinds, files and sizes on which the code of a model depends."""
    inside = _layout(model.model) if isinstance(model, Wrapper) else []
    return [type(model), model.c_source, model.parameter_vector.size, *inside]
