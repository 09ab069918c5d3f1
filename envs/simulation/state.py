"""The state of all rows between two resets, beside the state of the physics."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ..person import VoluntaryControl
from ..person.control import noise_constants, sight_periods
from .inverse_dynamics import Chain
from .measurements import NOISES, WIDTH
from .sensing import Sensing, smoothing
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
