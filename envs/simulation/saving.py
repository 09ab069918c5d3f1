"""The check of a saved state before it is restored."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...checks import HIGHEST_SEED
from ...errors import InputError, shown
from ..model.config import HEAVIEST_PAYLOAD, LARGEST_MISALIGNMENT

PHYSICS = mujoco.mjtState.mjSTATE_INTEGRATION  # all that the next step depends on
MOTION = mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_ACT
MOST = 10**9  # [control periods], greatest count
LARGEST = 1e9  # [SI], more than in any episode; sums of it stay finite
STRONGEST = 1e4  # [N·m], more than any torque of reflex, correction or learning
ROUNDING = 1e-9
# The lowest and the highest number of an array, where they are narrower than LARGEST.
BOUNDS: dict[str, tuple[float, float]] = {
    "seed": (0, HIGHEST_SEED),
    "episode": (0, MOST),
    "step": (0, MOST),
    "limit": (1, MOST),
    "clipped": (0, MOST),
    "diverged": (0, 0),
    "angle": (-2 * math.pi, 2 * math.pi),
    "command": (-1.0, 1.0),
    "change": (-2.0, 2.0),
    "mean_square": (0.0, LARGEST),
    "misalignment": (-LARGEST_MISALIGNMENT, LARGEST_MISALIGNMENT),
    "noise_scale": (0.0, 100.0),
    "encoder_offset": (-1.0, 1.0),
    "gains": (-STRONGEST, STRONGEST),
    "next_gains": (-STRONGEST, STRONGEST),
    "reflex": (-STRONGEST, STRONGEST),
    "correction": (-STRONGEST, STRONGEST),
    "learned_torque": (-STRONGEST, STRONGEST),
    "load": (0.0, HEAVIEST_PAYLOAD),
    "carried": (0.0, HEAVIEST_PAYLOAD),
    "free_fall": (0.0, 1000.0),
    "fatigued": (-ROUNDING, 1.0 + ROUNDING),
}


def check_state(
    state: Any,
    config: dict[str, Any],
    present: dict[str, NDArray],
    model: mujoco.MjModel,
    wearers: int,
) -> None:
    """Checks that a state came from an identically configured environment.

    Args:
        state: State that the user gave.
        config: Configuration of the environment.
        present: Present state of the rows to restore, array by array.
        model: Model of the environment.
        wearers: Number of persons whom a row may have as its wearer.
    """
    if not isinstance(state, dict):
        raise InputError(f"the state is a {type(state).__name__}: give the dict of get_state")
    missing = [key for key in ("config", *present) if key not in state]
    if missing:
        raise InputError(f"the state lacks {', '.join(missing)}: give the whole dict of get_state")
    _check_config(state["config"], config)
    rows = len(present["seed"])
    given = state["seed"]
    if isinstance(given, np.ndarray) and given.ndim == 1 and len(given) != rows:
        raise InputError(f"the state is of {len(given)} rows, and {rows} are to be restored")
    diverged = state["diverged"]
    if isinstance(diverged, np.ndarray) and diverged.dtype == np.bool_ and diverged.any():
        raise InputError("the state is of an episode that has diverged: go on from an earlier one")
    for name, value, wanted, usable in _parts(state, present, model, wearers):
        if not usable:
            raise InputError(
                f"the state's {name} is {shown(value)}: it must be {wanted}, as get_state "
                "returned it"
            )


def _check_config(saved: Any, own: dict[str, Any]) -> None:
    if not isinstance(saved, dict) or saved.keys() != own.keys():
        raise InputError(f"the state's config is {shown(saved)}: give that of get_state")
    differing = list(_differences("", saved, own))
    if differing:
        there, here = (
            ", ".join(f"{name}={values[side]!r}" for name, *values in differing)
            for side in range(2)
        )
        raise InputError(
            f"the state is of an environment with {there}, and this one has {here}: make it with "
            "the same options"
        )


def _differences(
    where: str, saved: dict[str, Any], own: dict[str, Any]
) -> Iterator[tuple[str, Any, Any]]:
    """Yields the name of each option that differs, also within others, and both values."""
    for name, value in own.items():
        there = saved[name]
        if isinstance(there, dict) and isinstance(value, dict) and there.keys() == value.keys():
            yield from _differences(f"{where}{name}.", there, value)
        elif not _same(there, value):
            yield f"{where}{name}", there, value


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return type(one) is type(other) and np.array_equal(one, other)
    return bool(one == other)


def _parts(
    state: dict[str, Any], present: dict[str, NDArray], model: mujoco.MjModel, wearers: int
) -> Iterator[tuple[str, Any, str, bool]]:
    """Yields name, value, the required form, and whether the value has it; callers rely on it."""
    bounds = {**BOUNDS, "wearer": (0, wearers - 1)}
    for name, own in present.items():
        value, (low, high) = state[name], bounds.get(name, (-LARGEST, LARGEST))
        form = f"{own.dtype} numbers of shape {own.shape}"
        fits = (
            isinstance(value, np.ndarray) and value.dtype == own.dtype and value.shape == own.shape
        )
        if name == "physics":
            yield name, value, form, fits and bool(np.isfinite(value).all())
            yield name, value, f"a motion below {mujoco.mjMAXVAL:g}", _is_slow(value, model)
        else:
            inside = fits and bool(((low <= value) & (value <= high)).all())  # NaN is outside
            yield name, value, f"{form} from {low:g} to {high:g}", inside


def _is_slow(physics: NDArray, model: mujoco.MjModel) -> bool:
    motion = np.empty(mujoco.mj_stateSize(model, MOTION))
    for row in physics:
        mujoco.mj_extractState(model, row, PHYSICS, motion, MOTION)
        if not np.abs(motion).max() < mujoco.mjMAXVAL:
            return False
    return True
