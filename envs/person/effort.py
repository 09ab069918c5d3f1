"""The effort of a motion: torque, work, estimates of metabolic energy, and smoothness."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...errors import InputError
from ..provenance import numbers_of, values_of

PROVENANCE = numbers_of("effort", "smoothness")
_VALUE = values_of(PROVENANCE)


@dataclass(frozen=True, kw_only=True, eq=False)
class EffortMetrics:
    """Effort of a motion at every joint; the sums of consecutive records add up.

    The two costs estimate metabolic energy, for comparisons within one person and task:
    `torque_cost` ignores motion, and `work_cost` ignores holding.

    Attributes:
        rms: Root mean square of the torque [N·m], shape (..., joints) like all fields.
        peak: Largest |torque| [N·m].
        impulse: Integral of |torque| [N·m·s].
        positive_work: Work done on the arm [J].
        negative_work: Work taken from the arm, positive [J].
        torque_cost: Integral of |torque|^1.36, proportional to the metabolic energy of holding
            [(N·m)^1.36·s].
        work_cost: Positive work / 0.25 + negative work / 1.20, the metabolic energy of working [J].
        spectral_arc_length: Smoothness SPARC of the joint's speed; NaN where nothing moves.
        log_dimensionless_jerk: Smoothness LDLJ of the joint's rate; NaN where nothing moves.
    """

    rms: Array
    peak: Array
    impulse: Array
    positive_work: Array
    negative_work: Array
    torque_cost: Array
    work_cost: Array
    spectral_arc_length: Array
    log_dimensionless_jerk: Array

    def to_dict(self) -> dict[str, list]:
        """Returns the metrics as nested lists."""
        return {name: value.tolist() for name, value in asdict(self).items()}


def effort_metrics(torque: ArrayLike, rate: ArrayLike, dt: float) -> EffortMetrics:
    """Measures the effort of a motion, in which every sample stands for one period of `dt` [s].

    `torque` is the wearer's torque [N·m], shape (..., n, joints), n >= 3; `rate` are the joint
    rates [rad/s], the same shape.
    """
    torque, rate = np.asarray(torque, dtype=float), np.asarray(rate, dtype=float)
    _check(torque, rate, dt)
    size, power = np.abs(torque), torque * rate
    raised = np.maximum(power, 0).sum(axis=-2) * dt
    lowered = np.maximum(-power, 0).sum(axis=-2) * dt
    gain, loss = (_VALUE[f"effort.efficiency.{sign}_work"] for sign in ("positive", "negative"))
    velocity = np.swapaxes(rate, -1, -2)
    return EffortMetrics(
        rms=np.sqrt(np.mean(torque**2, axis=-2)),
        peak=size.max(axis=-2),
        impulse=size.sum(axis=-2) * dt,
        positive_work=raised,
        negative_work=lowered,
        torque_cost=(size ** _VALUE["effort.torque_exponent"]).sum(axis=-2) * dt,
        work_cost=raised / gain + lowered / loss,
        spectral_arc_length=spectral_arc_length(np.abs(velocity), dt),
        log_dimensionless_jerk=log_dimensionless_jerk(velocity, dt),
    )


def _check(torque: Array, rate: Array, dt: float) -> None:
    if torque.shape != rate.shape or torque.ndim < 2 or torque.shape[-2] < 3:
        raise InputError(
            f"torque has shape {torque.shape} and rate {rate.shape}: give both the same shape "
            "(..., samples, joints), with 3 samples or more"
        )
    if not (np.isfinite(torque).all() and np.isfinite(rate).all()):
        raise InputError("torque or rate has values that are not finite: leave those samples out")
    if not (np.isfinite(dt) and dt > 0):
        raise InputError(f"dt is {dt}: give the sampling period in s, above 0")


def spectral_arc_length(speed: ArrayLike, dt: float) -> Array:
    """Returns the smoothness SPARC of a speed profile, shape (...); NaN where nothing moves.

    SPARC is minus the length of the curve of the magnitude spectrum, scaled to 1 in both
    directions, up to the last frequency below 10 Hz with 5 % of the largest magnitude. It is
    negative, and nearer to zero for a smoother motion. Cut the record to the movement, because rest
    before and after the movement changes the result.

    `speed` is |rate| of a joint or the norm of a velocity, shape (..., n), n >= 2, and `dt` the
    sampling period [s].
    """
    speed = np.asarray(speed, dtype=float)
    size = 2 ** (int(np.ceil(np.log2(speed.shape[-1]))) + int(_VALUE["smoothness.padding"]))
    bins = int(_VALUE["smoothness.highest_frequency"] * size * dt * (1 + 1e-12)) + 1
    spectrum = np.abs(np.fft.rfft(speed, size))[..., :bins]
    with np.errstate(invalid="ignore"):
        spectrum /= spectrum.max(axis=-1, keepdims=True)
    bins = spectrum.shape[-1]
    large = spectrum[..., ::-1] >= _VALUE["smoothness.amplitude_threshold"]
    last = bins - 1 - np.argmax(large, axis=-1)[..., None]
    steps = np.hypot(1 / np.maximum(last, 1), np.diff(spectrum))
    return -np.sum(np.where(np.arange(bins - 1) < last, steps, 0), axis=-1)


def log_dimensionless_jerk(rate: ArrayLike, dt: float) -> Array:
    """Returns the smoothness LDLJ of a velocity, shape (...); NaN where nothing moves.

    LDLJ is -log(T³ / peak² · ∫ jerk² dt), and nearer to zero for a smoother motion. A minimum-jerk
    movement has -log(204.8) = -5.32. Measured rates need a low-pass filter first: the second
    derivative raises their noise.

    `rate` is a velocity or speed [rad/s], shape (..., n), n >= 3, and `dt` the sampling period [s].
    """
    rate = np.asarray(rate, dtype=float)
    duration = (rate.shape[-1] - 1) * dt
    jerk = np.diff(rate, 2) / dt**2
    peak = np.abs(rate).max(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return -np.log(duration**4 * np.mean(jerk**2, axis=-1) / peak**2)
