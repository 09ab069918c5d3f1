"""Saved states of an environment: the physics as arrays, and the check before a restore."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from ..arrays import Array
from ..assets import JOINTS
from ..errors import InputError, shown
from .meter import ENERGIES
from .reference import Reference

PHYSICS = mujoco.mjtState.mjSTATE_INTEGRATION  # all that the next step depends on
MOTION = mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_ACT
MOST = 10**9  # control periods
LARGEST = 1e9  # J, N·m, rad/s: more than any episode has, and sums of it stay finite
ROUNDING = 1e-9
# The lowest and the highest number that an array of a state may have.
BOUNDS = {
    "actuator_force": (-LARGEST, LARGEST),
    "previous_action": (-1.0, 1.0),
    "motor_heat": (0.0, LARGEST),
    "past_torque": (-LARGEST, LARGEST),
    "variation": (-LARGEST, LARGEST),
    "fatigued": (-ROUNDING, 1.0 + ROUNDING),
    "angle": (-2 * math.pi, 2 * math.pi),
    "rate": (-LARGEST, LARGEST),
    "feedforward": (-LARGEST, LARGEST),
    "resistance": (-LARGEST, LARGEST),
}
KEYS = (
    "config",
    "physics",
    "actuator_force",
    "reference",
    "step",
    "clipped_actions",
    "energy",
    "dissipated_at_reset",
    "diverged",
    "random",
)


def physics_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Returns the state of the physics at this instant, with the suit's memory."""
    physics = np.empty(mujoco.mj_stateSize(model, PHYSICS))
    mujoco.mj_getState(model, data, physics, PHYSICS)
    return physics


def restore_physics(model: mujoco.MjModel, data: mujoco.MjData, state: dict[str, Any]) -> None:
    """Restores the physics of a checked state, and computes everything that follows from it."""
    data.warning.number[:] = 0
    mujoco.mj_setState(model, data, state["physics"], PHYSICS)
    mujoco.mj_step1(model, data)
    data.actuator_force[:] = state["actuator_force"]


def check_state(
    state: Any,
    config: dict[str, Any],
    model: mujoco.MjModel,
    samples: int,
    memory: dict[str, Array],
    random: np.random.Generator,
) -> None:
    """Checks that `state` came from `get_state` of an identically configured environment.

    Args:
        state: State that the user gave.
        config: Configuration of the environment.
        model: Model of the environment.
        samples: Number of samples of an intention.
        memory: Present values of the further arrays that a state holds.
        random: Random generator of the environment, which is not changed.

    Raises:
        InputError: The state belongs to another environment or to an episode that has diverged, or
            a part of it is missing, has another type or size, or numbers out of their bounds.
    """
    if not isinstance(state, dict):
        raise InputError(f"the state is a {type(state).__name__}: give the dict of get_state")
    missing = [key for key in (*KEYS, *memory) if key not in state]
    if missing:
        raise InputError(f"the state lacks {', '.join(missing)}: give the whole dict of get_state")
    _check_config(state["config"], config)
    if state["diverged"] is not False:
        raise InputError("the state is of an episode that has diverged: go on from an earlier one")
    shapes = {name: value.shape for name, value in memory.items()}
    for name, value, wanted, usable in _parts(state, model, samples, shapes, random):
        if not usable:
            raise InputError(
                f"the state's {name} is {shown(value)}: it must be {wanted}, as get_state "
                "returned it"
            )


def _check_config(saved: Any, own: dict[str, Any]) -> None:
    if not isinstance(saved, dict) or saved.keys() != own.keys():
        raise InputError(f"the state's config is {shown(saved)}: give that of get_state")
    differing = [name for name in own if saved[name] != own[name]]
    if differing:
        there, here = (
            ", ".join(f"{name}={values[name]!r}" for name in differing) for values in (saved, own)
        )
        raise InputError(
            f"the state is of an environment with {there}, and this one has {here}: make it with "
            "the same options"
        )


def _parts(
    state: dict[str, Any],
    model: mujoco.MjModel,
    samples: int,
    shapes: dict[str, tuple[int, ...]],
    random: np.random.Generator,
) -> Iterator[tuple[str, Any, str, bool]]:
    """Yields name, value, the required form, and whether the value has it; callers rely on it."""
    shapes = {"actuator_force": (model.nactuator,), **shapes}
    for name, shape in shapes.items():
        yield _part(name, state[name], shape, BOUNDS[name])
    physics, shape = state["physics"], (mujoco.mj_stateSize(model, PHYSICS),)
    yield "physics", physics, f"float64 numbers of shape {shape}", _is_array(physics, shape)
    motion = np.empty(mujoco.mj_stateSize(model, MOTION))
    mujoco.mj_extractState(model, physics, PHYSICS, motion, MOTION)
    bounded = bool(np.abs(motion).max() < mujoco.mjMAXVAL)
    yield "physics", physics, f"a motion below {mujoco.mjMAXVAL:g}", bounded
    reference, shape = state["reference"], (samples, len(JOINTS))
    yield "reference", reference, "a Reference", isinstance(reference, Reference)
    for name in ("angle", "rate", "feedforward", "resistance"):
        yield _part(f"reference.{name}", getattr(reference, name), shape, BOUNDS[name])
    for name in ("step", "clipped_actions"):
        count = state[name]
        yield name, count, f"a count from 0 to {MOST}", type(count) is int and 0 <= count <= MOST
    energy = state["energy"]
    named = isinstance(energy, dict) and set(energy) == set(ENERGIES)
    yield "energy", energy, f"a dict of {' and '.join(ENERGIES)}", named
    for name, value in {**energy, "dissipated_at_reset": state["dissipated_at_reset"]}.items():
        bounded = isinstance(value, float) and abs(value) <= LARGEST  # nan is not
        yield name, value, f"a number within {LARGEST:g}", bounded
    yield "random", state["random"], "a generator's state", _fits(random, state["random"])


def _part(
    name: str, value: Any, shape: tuple[int, ...], bounds: tuple[float, float]
) -> tuple[str, Any, str, bool]:
    low, high = bounds
    usable = _is_array(value, shape) and bool(((low <= value) & (value <= high)).all())
    return name, value, f"float64 numbers of shape {shape} from {low:g} to {high:g}", usable


def _is_array(value: Any, shape: tuple[int, ...]) -> bool:
    return (
        isinstance(value, np.ndarray)
        and value.dtype == np.float64
        and value.shape == shape
        and bool(np.isfinite(value).all())
    )


def _fits(random: np.random.Generator, state: Any) -> bool:
    try:
        type(random.bit_generator)().state = state
    except Exception:  # a damaged state fails wherever it is damaged
        return False
    return True
