"""The state of all rows between two resets, and the streams of their random numbers."""

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...checks import HIGHEST_SEED
from ...errors import InputError, shown
from ..model import ArmConfig
from ..model.encoders import count_of
from ..person import VoluntaryControl
from ..person.control import noise_constants, sight_periods
from . import structs
from .faults import RECEPTION, Faults
from .inverse_dynamics import Chain
from .measurements import NOISES, WIDTH, Sensing, smoothing
from .row_models import Variety
from .structs import Motions, allocated, saved
from .wearer_control import FEATURES, PERSISTENCE


def stream(seed: int, episode: int, purpose: str, part: int = 0) -> np.random.Generator:
    """Returns the generator of one purpose, such as "motion", in one episode of a seed.

    Draws for one purpose do not change the draws for another purpose, nor those of other rows of a
    vector environment, in whatever order the draws are made. `part` is the number of the stretch of
    the episode, for series that are drawn in stretches.
    """
    return np.random.default_rng((seed, episode, zlib.crc32(purpose.encode()), part))


def fresh_seed() -> int:
    """Returns a seed from the operating system's entropy."""
    return int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) & HIGHEST_SEED


STRETCH = 64  # control periods for which random numbers are drawn at once
KEPT = ("seed", "episode", "limit", "angle", "rate", "acceleration", "next_gains")
"""Arrays of the state that the next episode keeps, or overwrites as a whole."""


PREVIEW = (0.02, 0.1, 0.24)  # [s], look-ahead times of the target in the observation


class State(NamedTuple):
    """State of the rows outside the physics."""

    episode: structs.Episode
    conditions: structs.Conditions
    intention: structs.Intention
    wearer: structs.Wearer
    muscles: structs.Muscles
    motors: structs.Motors
    sensors: structs.Sensors
    noisy: structs.NoisySensors
    reception: structs.Reception

    def arrays(self) -> dict[str, NDArray]:
        """Returns the arrays of the state by name, not copied, without constants and scratch."""
        return {name: values for name, (values, _) in saved(self).items()}


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulationOptions:
    """What the rows of a simulation have in common, beside the configuration of the arms."""

    samples: int  # number of samples of an intention
    control_dt: float  # control period [s]
    control: VoluntaryControl  # the wearer's control of the arm
    fatigue: bool = False  # whether effort tires the wearers
    sensing: Sensing = field(default_factory=Sensing)  # noise, delay and bandwidth of sensors
    faults: Faults = field(default_factory=Faults)  # faults of sensors and motors
    variety: Variety = field(default_factory=Variety)  # what may differ between rows
    noisy: bool = False  # whether the sensors that have noise are read, which takes time
    # Whether loads change during an episode; rows then may have loads of their own.
    carries: bool = False
    learned: bool = False  # whether episodes may begin with what the wearers have learned for them


def state_of(
    n: int,
    config: ArmConfig,
    options: SimulationOptions,
    at: structs.Addresses,
    arm: tuple[Chain, Array, Array],
) -> State:
    """Returns the state of rows before their first reset.

    `arm` is what all rows have at first: the bare arm, isometric strength, and impedance.
    """
    control, sensing, faults = options.control, options.sensing, options.faults
    samples, dt, noisy = options.samples, options.control_dt, options.noisy
    chain, strength, impedance = arm
    fails, varies = faults != Faults(), control.noise > 0 or control.tremor > 0
    motors = dict([*config.exo.motors.items()][: at.motors.size])  # none without an exoskeleton
    heat = [(one.continuous_torque, one.thermal_time_constant) for one in motors.values()]
    stopped = [faults.since if joint in faults.stopped else math.inf for joint in motors]
    sizes = {
        **{"n": n, "samples": samples, "motors": len(motors), "features": FEATURES},
        **{"measurements": WIDTH, "noises": NOISES, "sight": sight_periods(dt)},
        **{"reflex_delay": round(control.delay / dt), "gains": FEATURES if control.learns else 0},
        **{
            "learned": samples if options.learned else 0,
            "pushes": samples if at.pushes.size else 0,
        },
        **{"masses": samples if options.carries else 0, "muscle_draws": STRETCH if varies else 0},
        **{"sensor_draws": STRETCH if noisy else 0, "fault_draws": STRETCH if fails else 0},
        "persistence": PERSISTENCE if control.persistent and not control.stiff else 0,
        "received": RECEPTION.size if fails else 0,
        "interaction_delay": 1 + (round(sensing.interaction_delay / dt) if noisy else 0),
    }
    state = State(
        episode=allocated(structs.Episode, sizes, dt=dt),
        conditions=allocated(structs.Conditions, sizes),
        intention=allocated(structs.Intention, sizes, motion=allocated(Motions, sizes)),
        wearer=structs.Wearer(
            arm=chain.rows(n),
            feedback=allocated(
                structs.Feedback,
                sizes,
                persistence=allocated(
                    structs.Persistence,
                    sizes,
                    friction=np.array([motors[j].coulomb if j in motors else 0.0 for j in JOINTS]),
                    **control.persistence(dt),
                ),
                **control.feedback(dt),
            ),
            learning=allocated(structs.Learning, sizes, **control.learning(dt)),
            noise=allocated(
                structs.MuscleNoise,
                sizes,
                recursion=noise_constants(dt),
                noise=control.noise,
                tremor=control.tremor,
            ),
        ),
        muscles=allocated(
            structs.Muscles,
            sizes,
            strength=np.tile(strength, (n, 1, 1)),
            impedance=np.tile(impedance, (n, 1, 1)),
            tires=options.fatigue,
        ),
        motors=allocated(
            structs.Motors,
            sizes,
            ratings=np.array([at.peak_torque, *np.reshape(heat, (-1, 2)).T]),  # not a transpose
            fails=np.array(stopped),
        ),
        sensors=allocated(
            structs.Sensors,
            sizes,
            preview=np.array([round(ahead / dt) for ahead in PREVIEW]),
            resolution=count_of(config.exo.encoder_bits),
            smoothing=smoothing(sensing.rate_cutoff, dt),
        ),
        noisy=allocated(
            structs.NoisySensors,
            sizes,
            present=allocated(Motions, {**sizes, "samples": 1}),
            interaction_noise=sensing.interaction_noise,
            cuff_noise=sensing.cuff_noise,
            emg_noise=sensing.emg_noise,
            emg_lead=round(sensing.emg_lead / dt),
            emg_smoothing=smoothing(sensing.emg_cutoff, dt),
        ),
        reception=allocated(structs.Reception, sizes),
    )
    state.episode.episode[:], state.episode.limit[:] = -1, samples - 1
    state.noisy.noise_scale[:] = 1.0
    return state


PHYSICS = mujoco.mjtState.mjSTATE_INTEGRATION  # everything that the next step depends on
MOTION = mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_ACT


def check_state(
    state: Any,
    config: dict[str, Any],
    present: dict[str, NDArray],
    bounds: dict[str, tuple[float, float]],
    model: mujoco.MjModel,
) -> None:
    """Checks a state that a user gave: it must be of an identically configured environment.

    `config` and `present` are configuration and state of the rows to restore. `bounds` are the
    lowest and highest number of arrays whose range is narrower than LARGEST.
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
    for name, own in present.items():
        value, (low, high) = state[name], bounds.get(name, (-structs.LARGEST, structs.LARGEST))
        wanted, usable = f"{own.dtype} numbers of shape {own.shape}", isinstance(value, np.ndarray)
        usable = usable and value.dtype == own.dtype and value.shape == own.shape
        if name != "physics":
            wanted += f" from {low:g} to {high:g}"
            usable = usable and bool(((low <= value) & (value <= high)).all())  # NaN is outside
        elif usable and np.isfinite(value).all():
            wanted, usable = f"a motion below {mujoco.mjMAXVAL:g}", _is_slow(value, model)
        else:
            usable = False
        if not usable:
            raise InputError(
                f"the state's {name} is {shown(value)}: it must be {wanted}, as get_state "
                "returned it"
            )


def _check_config(saved: Any, own: dict[str, Any]) -> None:
    if not isinstance(saved, dict) or saved.keys() != own.keys():
        raise InputError(f"the state's config is {shown(saved)}: give the config of get_state")
    differing = list(_differences("", saved, own))
    if differing:
        there, here = (
            ", ".join(f"{name}={values[side]!r}" for name, *values in differing)
            for side in range(2)
        )
        raise InputError(
            f"the state is of an environment with {there}, and this environment has {here}: make "
            "both with the same options"
        )


def _differences(
    where: str, saved: dict[str, Any], own: dict[str, Any]
) -> Iterator[tuple[str, Any, Any]]:
    """Yields the name of each option that differs, also of nested options, and both values."""
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


def _is_slow(physics: NDArray, model: mujoco.MjModel) -> bool:
    motion = np.empty(mujoco.mj_stateSize(model, MOTION))
    for row in physics:
        mujoco.mj_extractState(model, row, PHYSICS, motion, MOTION)
        if not np.abs(motion).max() < mujoco.mjMAXVAL:
            return False
    return True
