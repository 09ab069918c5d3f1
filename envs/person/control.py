"""The wearer's control of the arm: foreseen torque, delayed feedback, and muscle noise.

The engine's position and velocity inputs give the wearer an instantaneous impedance, the
*intrinsic* torque of co-contracted muscles. What the wearer adds at control rate is

    foreseen:  own feed-forward + suit_learning · resistance of the suit
    feedback:  feedback · intrinsic torque of `delay` ago

so feedback answers errors of angle and rate as the muscles do, but later. The sum, together with
the intrinsic torque, stays within strength. It then varies in proportion to itself: slow noise
(first-order low-pass, corner 4 Hz, whatever the control rate) and tremor (a resonance at 10 Hz,
4 Hz wide).

With the gains of the shipped arm the default feedback is stable for any delay: the loop gain is
below 1 at all frequencies, for all arms from a bare one to one with suit, exoskeleton and 5 kg.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, isclose, pi, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError
from ..provenance import Quantity
from .control_kernels import pull

Generators = np.random.Generator | Sequence[np.random.Generator]

_HAMILTON = "size: ours; falls with strength, Hamilton et al. 2004, Exp. Brain Res. 157:417-430"
_FLUCTUATION = "ours: isometric force varies slowly, at less than the frequency of tremor"
_TREMOR = "Novak and Newell 2017, Neurosci. Lett.: physiological tremor has 8 to 12 Hz"
_NOISE = tuple(
    Quantity(f"control.noise.{joint}", value, "1", _HAMILTON, "assumed")
    for joint, value in zip(JOINTS, (0.025, 0.025, 0.025, 0.045), strict=True)
)
_CORNER = Quantity("control.noise.corner", 4.0, "Hz", _FLUCTUATION, "assumed")
_CENTER = Quantity("control.tremor.center", 10.0, "Hz", _TREMOR, "derived")
_WIDTH = Quantity("control.tremor.width", 4.0, "Hz", _TREMOR, "derived")
_DELAY = Quantity(
    "control.delay",
    0.05,
    "s",
    "long-latency response of arm muscles, from 50 ms: PLOS ONE 11(10) e0163854, without the "
    "muscle's own delay",
    "derived",
)
_FEEDBACK = Quantity(
    "control.feedback", 0.4, "1", "ours: less than the intrinsic part, and stable", "assumed"
)

PROVENANCE: tuple[Quantity, ...] = (*_NOISE, _CORNER, _CENTER, _WIDTH, _DELAY, _FEEDBACK)

NOISE_SIZE = np.array([quantity.value for quantity in _NOISE])


@dataclass(frozen=True, kw_only=True)
class VoluntaryControl:
    """Settings of a wearer's control of the arm. All fields are plain numbers.

    Nothing is random by default, so that two policies or two suits meet the same wearer. With
    `noise=1` the wearer varies as people do.

    Attributes:
        suit_learning: Share of the suit's resistance that the wearer foresees, 0 to 1; a wearer
            who has never worn the suit has 0.
        feedback: Gain of the delayed feedback, a factor of the intrinsic torque, 0 to 1.
        delay: Time from an error to the torque that answers it [s], 0 to 0.5, a multiple of the
            control period.
        noise: Signal-dependent noise in multiples of a typical one, whose standard deviation is
            2.5 % of the torque at shoulder and elbow and 4.5 % at the wrist, 0 to 10.
        tremor: Standard deviation of physiological tremor over the torque, 0 to 0.5.

    Raises:
        InputError: a value is outside its range.
    """

    suit_learning: float = 0.0
    feedback: float = _FEEDBACK.value
    delay: float = _DELAY.value
    noise: float = 0.0
    tremor: float = 0.0

    def __post_init__(self) -> None:
        for name, highest, kind in (
            ("suit_learning", 1, "as a share of the suit's resistance"),
            ("feedback", 1, "as a share of the intrinsic torque"),
            ("delay", 0.5, "in s"),
            ("noise", 10, "as a multiple of a typical person's"),
            ("tremor", 0.5, "as a fraction of the torque"),
        ):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and 0 <= value <= highest):
                raise InputError(f"{name} is {value!r}: give it {kind}, from 0 to {highest:g}")

    def periods(self, dt: float) -> int:
        """Returns the delay in control periods of `dt` [s].

        Raises:
            InputError: The delay is not a multiple of the control period.
        """
        count = round(self.delay / dt)
        if not isclose(count * dt, self.delay, abs_tol=1e-9):
            raise InputError(
                f"delay is {self.delay:g} s: give it as a multiple of the control period, "
                f"{dt:g} s, such as {count * dt:g} s"
            )
        return count


@dataclass(frozen=True, eq=False)
class ControlState:
    """Memory of the wearer's control between two periods.

    Attributes:
        past: Intrinsic torques without an answer yet [N·m], oldest first, shape (..., delay, 4).
        variation: Slow noise, tremor, and tremor a quarter period later, each with variance 1 in
            the long run, shape (..., 3, 4).
    """

    past: Array
    variation: Array


def start_control(settings: VoluntaryControl, intrinsic: ArrayLike, dt: float) -> ControlState:
    """Returns the memory of a wearer who has held still, without any noise yet.

    Args:
        settings: Settings of the wearer's control.
        intrinsic: Intrinsic torque so far [N·m], shape (..., 4); zeros if the arm was free.
        dt: Control period [s].

    Raises:
        InputError: The delay is not a multiple of the control period.
    """
    samples = settings.periods(dt)
    intrinsic = np.asarray(intrinsic, dtype=float)
    past = np.repeat(intrinsic[..., None, :], samples, axis=-2)
    return ControlState(past, np.zeros((*intrinsic.shape[:-1], 3, intrinsic.shape[-1])))


def voluntary_torque(
    settings: VoluntaryControl,
    state: ControlState,
    *,
    intrinsic: Array,
    feedforward: Array,
    suit_resistance: Array,
    limits: tuple[Array, Array],
    dt: float,
    rng: Generators,
) -> tuple[Array, ControlState]:
    """Returns the torque that the wearer adds to the intrinsic one in this control period.

    It goes to the feed-forward input of the engine's actuators, whose position and velocity inputs
    are the intention.

    Args:
        settings: Settings of the wearer's control.
        state: Memory of the period before, or from `start_control`; it is not changed.
        intrinsic: Torque of the wearer's impedance at this instant, stiffness · (intended - actual
            angle) + damping · (intended - actual rate) [N·m], shape (..., 4), the state's.
        feedforward: Torque that moves the bare arm along the intention [N·m], shape (..., 4).
        suit_resistance: Resistance of the suit along the intention, as the wearer could learn it
            [N·m], shape (..., 4).
        limits: Least and greatest torque that the wearer can give now, `strength_limits` of the
            strength that fatigue has left [N·m], shape (..., 4) each.
        dt: Control period [s].
        rng: Random numbers, one generator for all wearers or one for each of a one-dimensional
            batch; nothing is drawn without noise and tremor.

    Returns:
        torque: torque of the wearer without the intrinsic one [N·m], shape (..., 4).
        state: memory for the next period.
    """
    window = np.concatenate([state.past, intrinsic[..., None, :]], axis=-2)
    foreseen = feedforward + settings.suit_learning * suit_resistance
    low, high = limits
    total = pull(intrinsic, foreseen, settings.feedback, window[..., 0, :], low, high)
    variation = state.variation
    if settings.noise > 0 or settings.tremor > 0:
        variation = _vary(variation, dt, rng)
        slow, tremor = variation[..., 0, :], variation[..., 1, :]
        relative = settings.noise * NOISE_SIZE * slow + settings.tremor * tremor
        total = np.clip(total * (1 + relative), low, high)
    return total - intrinsic, ControlState(window[..., 1:, :], variation)


def noise_constants(dt: float) -> Array:
    """Returns how noise and tremor go on from one control period to the next, shape (6,).

    Noise: the share that remains. Tremor: the share that remains, cosine and sine of its turning.
    Then the weights of the random numbers that drive noise and tremor.
    """
    lag, ring = exp(-2 * pi * _CORNER.value * dt), exp(-pi * _WIDTH.value * dt)
    turn = 2 * pi * _CENTER.value * dt
    return np.array([lag, ring, cos(turn), sin(turn), sqrt(1 - lag**2), sqrt(1 - ring**2)])


def _vary(variation: Array, dt: float, rng: Generators) -> Array:
    """Returns the next variation: a first-order autoregression and a randomly driven rotation."""
    lag, ring, cosine, sine, slow_drive, ring_drive = noise_constants(dt)
    slow, x, y = np.moveaxis(variation, -2, 0)
    kept = np.stack(
        [lag * slow, ring * (cosine * x - sine * y), ring * (sine * x + cosine * y)], axis=-2
    )
    if isinstance(rng, np.random.Generator):
        fresh = rng.standard_normal(kept.shape)
    else:
        fresh = np.stack([one.standard_normal(kept.shape[-2:]) for one in rng])
    return kept + np.array([slow_drive, ring_drive, ring_drive])[:, None] * fresh
