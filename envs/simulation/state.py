"""The state of all rows between two resets, and the streams of their random numbers."""

import math
import zlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...checks import HIGHEST_SEED
from ...errors import InputError, shown
from ..model.config import HEAVIEST_PAYLOAD, LARGEST_MISALIGNMENT
from ..person import VoluntaryControl
from ..person.control import noise_constants, sight_periods
from .inverse_dynamics import Chain
from .measurements import NOISES, WIDTH, Sensing, smoothing
from .structs import (
    Conditions,
    Episode,
    Feedback,
    Intention,
    Learning,
    Motions,
    Motors,
    MuscleNoise,
    Muscles,
    NoisySensors,
    Reception,
    Sensors,
    Wearer,
    Whole,
    saved,
)
from .wearer_control import FEATURES


def stream(seed: int, episode: int, purpose: str, part: int = 0) -> np.random.Generator:
    """Returns the generator of one purpose in one episode.

    Draws for one purpose do not change those for another, nor those of other rows of a vector
    environment, in whatever order they are made.

    Args:
        seed: Seed of the row.
        episode: Number of the episode since the row was seeded.
        purpose: Name of the purpose, such as "motion".
        part: Number of the stretch of the episode, for series that are drawn in stretches.
    """
    return np.random.default_rng((seed, episode, zlib.crc32(purpose.encode()), part))


def fresh_seed() -> int:
    """Returns a seed from the operating system's entropy."""
    return int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) & HIGHEST_SEED


STRETCH = 64  # control periods for which random numbers are drawn at once
KEPT = ("seed", "episode", "limit", "angle", "rate", "acceleration", "next_gains")
"""Arrays of the state that the next episode takes over, or overwrites whole."""


class State(NamedTuple):
    """Everything about the rows that is not in the physics."""

    episode: Episode
    conditions: Conditions
    intention: Intention
    wearer: Wearer
    muscles: Muscles
    motors: Motors
    sensors: Sensors
    noisy: NoisySensors
    reception: Reception

    def arrays(self) -> dict[str, NDArray]:
        """Returns the arrays of the state themselves, by name, without constants and scratch."""
        return saved(self)


def episodes_of(n: int, samples: int, dt: float) -> Episode:
    """Returns the counters of rows before their first reset."""
    return Episode(
        seed=np.zeros(n, np.int64),
        episode=np.full(n, -1),
        step=np.zeros(n, np.int64),
        limit=np.full(n, samples - 1),
        clipped=np.zeros(n, np.int64),
        diverged=np.zeros(n, np.bool_),
        dt=dt,
    )


def conditions_of(n: int, masses: int, pushes: int) -> Conditions:
    """Returns the conditions of rows, with masses and pushes at so many samples."""
    return Conditions(
        wearer=np.zeros(n, np.int64),
        misalignment=np.zeros((n, 3)),
        load=np.zeros(n),
        free_fall=np.zeros(n),
        carried=np.zeros((n, masses)),
        push=np.zeros((n, pushes, 3)),
    )


def intention_of(n: int, samples: int, *, learned: bool) -> Intention:
    """Returns the intentions of rows, which take what was learned for them or not."""
    size = (n, samples if learned else 0, len(JOINTS))
    return Intention(motions_of(n, samples), np.zeros(size), np.zeros(size))


def motions_of(n: int, samples: int) -> Motions:
    """Returns motions of rows with so many samples."""
    return Motions(*(np.zeros((n, samples, len(JOINTS))) for _ in range(3)))


def wearer_of(n: int, chain: Chain, control: VoluntaryControl, dt: float) -> Wearer:
    """Returns wearers of rows with the same bare arm."""
    joints, features = len(JOINTS), FEATURES if control.learns else 0
    draws = STRETCH if control.noise > 0 or control.tremor > 0 else 0
    return Wearer(
        arm=chain.rows(n),
        feedback=Feedback(
            reflex=np.zeros((n, joints)),
            correction=np.zeros((n, joints)),
            correction_goals=np.zeros((n, 3, joints)),
            reflex_delay=np.zeros((n, round(control.delay / dt), joints)),
            correction_delay=np.zeros((n, sight_periods(dt), joints)),
            needed=np.zeros((n, joints)),
            **control.feedback(dt),
        ),
        learning=Learning(
            gains=np.zeros((n, joints, features)),
            next_gains=np.zeros((n, joints, features)),
            features=np.zeros((n, joints, FEATURES)),
            **control.learning(dt),
        ),
        noise=MuscleNoise(
            muscle_noise=np.zeros((n, 3, joints)),
            muscle_draws=np.zeros((n, draws, 3, joints)),
            recursion=noise_constants(dt),
            noise=control.noise,
            tremor=control.tremor,
        ),
    )


def muscles_of(n: int, strength: Array, impedance: Array, *, tires: bool) -> Muscles:
    """Returns muscles of rows with the same strength and impedance."""
    return Muscles(
        fatigued=np.zeros((n, 2, len(JOINTS))),
        strength=np.tile(strength, (n, 1, 1)),
        impedance=np.tile(impedance, (n, 1, 1)),
        tires=tires,
    )


def motors_of(n: int, ratings: Array) -> Motors:
    """Returns motors of rows; `ratings` has shape (3, motors)."""
    size = (n, ratings.shape[1])
    return Motors(np.zeros(size), np.zeros(size), np.zeros(size), ratings)


def sensors_of(n: int, preview: Whole, resolution: float, sensing: Sensing, dt: float) -> Sensors:
    """Returns the sensors of rows; `resolution` is the angle of one count of the encoders [rad]."""
    return Sensors(
        measured=np.zeros((n, WIDTH)),
        encoder_counts=np.zeros((n, len(JOINTS))),
        encoder_offset=np.zeros((n, len(JOINTS))),
        dissipated_at_reset=np.zeros(n),
        preview=preview,
        resolution=resolution,
        smoothing=smoothing(sensing.rate_cutoff, dt),
    )


def noisy_sensors_of(n: int, sensing: Sensing, dt: float, *, used: bool) -> NoisySensors:
    """Returns the sensors with noise of rows, without memory if they are not used."""
    delay = round(sensing.interaction_delay / dt) if used else 0
    return NoisySensors(
        noise_scale=np.ones(n),
        sensor_draws=np.zeros((n, STRETCH if used else 0, NOISES)),
        interaction_delay=np.zeros((n, delay + 1, len(JOINTS))),
        present=motions_of(n, 1),
        interaction_noise=sensing.interaction_noise,
        cuff_noise=sensing.cuff_noise,
        emg_noise=sensing.emg_noise,
        emg_lead=round(sensing.emg_lead / dt),
        emg_smoothing=smoothing(sensing.emg_cutoff, dt),
    )


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
