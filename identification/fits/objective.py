"""Errors of a model on measured curves: its torque along them, and the losses of fits."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import Array
from ...checks import number
from ...errors import InputError, unknown_name
from ...hysteresis.around import Viscoelastic
from ...hysteresis.certificate import PoleError
from ...hysteresis.jiles_atherton import PARAMETERS, kernels
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves, noise_floor

Loss = Literal["nrmse", "paper", "sse", "robust"]
Normalize = Literal["family", "curve"]
InitialTorque = float | Literal["measured", "identified"]
# In deviations of the noise: Huber's constant (Holland and Welsch, Commun. Stat. A 6 (1977) 813),
# with which the pseudo-Huber loss too keeps 95 % of the efficiency of least squares.
OUTLYING = 1.345
FEWEST_SAMPLES = 10  # least number of samples of all fitted curves, for five parameters
LEAST_PEAK = 1e-9  # least peak [N·m]: squares of much smaller torques lose their digits
LEAST_NOISE = 1e-3  # least noise over the peak, so that curves without noise have a scale


@dataclass(eq=False)
class CurveObjective:
    """Loss of Jiles-Atherton parameters on a family of curves, for whole populations at once.

    Rows of parameters are (Ms, a, alpha, c, k) with a, k, alpha in degrees, the unit of Tables 1
    and 2 of Li et al. 2022. Parameters whose curve meets the pole score infinity. With the errors
    E = Tc - Tm at all N samples, their weights w of mean 1, and e = E / Tmax, the losses are

        "nrmse"   sqrt(mean(w e^2))
        "paper"   sqrt(sum(w e^2)) / N, eq. (7) of Li et al. 2022
        "sse"     sum(w E^2) [(N·m)^2], eq. (10) of Kao and Fung 2009
        "robust"  sqrt(mean(w p)), p = 2 (sqrt(1 + (E/d)^2) - 1) (d/Tmax)^2, which is e^2 for small
                  errors and grows like |E| beyond d = 1.345 times the noise of the torque
                  (pseudo-Huber; Charbonnier et al., IEEE Trans. Image Process. 6 (1997) 298). The
                  noise is `noise_floor`, and at least 0.1 % of the peak.

    Attributes:
        curves: The measured curves; only the ratios of their weights count.
        loss: The loss that a call returns.
        normalize: Tmax is the largest |Tm| of the "family" or of each "curve" itself.
        initial_torque: The torque with which every curve begins [N·m]; "measured" takes each
            curve's first sample, and "identified" a sixth column of the parameters [N·m].
        evaluations: How many parameter rows have been scored so far.
        torque: The torque of all curves, end to end [N·m], shape (samples,).
        weight: The weight of each sample, of mean 1, shape (samples,).
        peak: The largest |Tm| of all curves [N·m].
    """

    curves: Sequence[Curve]
    _: KW_ONLY
    loss: Loss = "nrmse"
    normalize: Normalize = "family"
    initial_torque: InitialTorque = 0.0
    evaluations: int = field(init=False, default=0)
    torque: NDArray[np.float64] = field(init=False)
    weight: NDArray[np.float64] = field(init=False)
    peak: float = field(init=False)

    def __post_init__(self) -> None:
        if not self.curves:
            raise InputError("there is no curve to fit: give at least one with role 'fit'")
        for kind, allowed in (("loss", get_args(Loss)), ("normalize", get_args(Normalize))):
            if getattr(self, kind) not in allowed:
                raise unknown_name(kind, getattr(self, kind), allowed)
        if self.loss == "sse" and self.normalize == "curve":
            raise InputError(
                "normalize is 'curve' and loss 'sse' does not normalize: use loss 'nrmse', or "
                "weights"
            )
        sizes = [curve.torque.size for curve in self.curves]
        self.torque = np.concatenate([curve.torque for curve in self.curves])
        self.weight = sample_weights(self.curves)
        self.peak = float(np.abs(self.torque).max())
        if self.peak == 0:
            raise InputError("every torque is zero: there is nothing to identify")
        if self.peak < LEAST_PEAK:
            raise InputError(
                f"the torque of the curves peaks at {self.peak:.3g} N·m: give at least "
                f"{LEAST_PEAK:g} N·m; check its unit"
            )
        self._scale = np.sqrt(self.weight) / np.repeat(self._units(), sizes)
        self._outlying = OUTLYING * max(noise_floor(self.curves), LEAST_NOISE * self.peak)
        self._angle = np.degrees(np.concatenate([curve.angle for curve in self.curves]))
        self._starts = np.cumsum([0, *sizes])
        self._initial = self._given_torques()

    def responses(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns the torque of each parameter row along all curves, shape (n, samples) [N·m]."""
        rows = np.atleast_2d(np.asarray(parameters, dtype=np.float64))
        names = [*PARAMETERS]
        if self._initial is None:
            names.append("initial torque")
        if rows.ndim != 2 or rows.shape[1] != len(names):
            raise InputError(
                f"the parameters have shape {rows.shape}: give rows of {len(names)} numbers "
                f"({', '.join(names)})"
            )
        curves = len(self.curves)
        initial = rows[:, 5:].repeat(curves, axis=1) if self._initial is None else self._initial
        # A copy: a read-only view would have the kernel compiled once more.
        initial = np.array(np.broadcast_to(initial, (len(rows), curves)), order="C")
        self.evaluations += len(rows)
        torque = np.empty((len(rows), self._angle.size))
        models = np.ascontiguousarray(rows[:, :5])
        kernels.population_response(self._angle, self._starts, initial, models, torque)
        return torque

    def derivatives(self, row: NDArray[np.float64]) -> NDArray[np.float64]:
        """Returns the Jacobian of the torque for one parameter row, shape (samples, parameters).

        Where a curve meets the pole, the Jacobian is not finite at that sample and all later ones.
        """
        torque = np.empty(self._angle.size)
        by_row = np.empty((torque.size, 6))
        initial = self.first_torques(row)
        kernels.response_and_derivatives(
            self._angle, self._starts, initial, row[:5].copy(), torque, by_row
        )
        return by_row[:, : row.size]

    def first_torques(self, row: NDArray[np.float64]) -> NDArray[np.float64]:
        """Returns the torque [N·m] with which each curve begins, shape (curves,)."""
        if self._initial is None:
            return np.full(len(self.curves), row[5])
        return self._initial

    def nrmse(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns sqrt(mean((Tc - Tm)^2)) / peak of each parameter row, unweighted, shape (n,)."""
        errors = self.responses(parameters)
        errors -= self.torque
        score = np.sqrt(np.einsum("ij,ij->i", errors, errors) / self.torque.size) / self.peak
        return np.where(np.isfinite(score), score, np.inf)

    def __call__(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns the loss of each parameter row, shape (n,)."""
        errors = self.responses(parameters)
        errors -= self.torque
        if self.loss == "robust":
            with np.errstate(over="ignore", invalid="ignore"):  # overflow becomes infinity below
                errors *= np.sqrt(2 / (1 + np.hypot(1, errors / self._outlying)))
        errors *= self._scale
        total = np.einsum("ij,ij->i", errors, errors)
        if self.loss == "paper":
            total = np.sqrt(total) / self.torque.size
        elif self.loss != "sse":
            total = np.sqrt(total / self.torque.size)
        return np.where(np.isfinite(total), total, np.inf)

    def _units(self) -> list[float]:
        """Returns the torque that divides the errors of each curve [N·m]."""
        if self.loss == "sse":
            return [1.0] * len(self.curves)
        if self.normalize == "family":
            return [self.peak] * len(self.curves)
        peaks = [float(np.abs(curve.torque).max()) for curve in self.curves]
        if 0 in peaks:
            raise InputError(
                f"every torque of curve {self.curves[peaks.index(0)].name!r} is zero: use "
                "normalize 'family', or leave the curve out"
            )
        return peaks

    def _given_torques(self) -> NDArray[np.float64] | None:
        """Returns the torque at the beginning of each curve; None where the rows contain it."""
        if self.initial_torque == "identified":
            return None
        if self.initial_torque == "measured":
            return np.array([curve.torque[0] for curve in self.curves])
        if isinstance(self.initial_torque, str):
            allowed = ("a number", "measured", "identified")
            raise unknown_name("initial_torque", self.initial_torque, allowed)
        return np.full(len(self.curves), number("initial_torque", self.initial_torque, "N·m"))


def sample_weights(curves: Sequence[Curve]) -> NDArray[np.float64]:
    """Returns the weight of each sample of curves, end to end, of mean 1, shape (samples,)."""
    sizes = [curve.torque.size for curve in curves]
    weight = np.repeat([curve.weight for curve in curves], sizes)
    weight = weight / weight.max()  # no sum of weights overflows
    return weight / weight.mean()


def torque_errors(
    model: HysteresisModel, initial_torque: InitialTorque, curves: Sequence[Curve]
) -> Array:
    """Returns Tc - Tm [N·m] along all curves, end to end; infinite on a curve with a pole."""
    return np.concatenate(
        [predicted(model, initial_torque, curve) - curve.torque for curve in curves]
    )


def predicted(model: HysteresisModel, initial_torque: InitialTorque, curve: Curve) -> Array:
    """Returns a model's torque along a curve [N·m]; infinite if it meets the pole there."""
    start = curve.torque[0] if initial_torque == "measured" else initial_torque
    try:
        if isinstance(model, Viscoelastic):
            return model.response(curve.angle, cast(float, start), times_of(curve))
        return model.response(curve.angle, cast(float, start))
    except PoleError:
        return np.full(curve.angle.size, np.inf)


def times_of(curve: Curve) -> Array:
    """Returns the times of a curve [s]."""
    if curve.time is None:
        raise InputError(
            f"curve {curve.name!r} has no times, and the model depends on the rate: add the column "
            "time_s, or leave rate out"
        )
    return curve.time


def nrmse(errors: Array, curves: Sequence[Curve]) -> float:
    """Returns the NRMSE: the root mean square of errors [N·m] over the curves' largest |Tm|."""
    return float(np.sqrt(np.mean(errors**2))) / Curves(curves).peak


def price(numbers: int, samples: int) -> float:
    """Returns the least ratio of the errors without and with additional parameters of a model.

    Below this ratio the Bayesian information criterion for independent noise (Schwarz 1978) prefers
    the model without the additional parameters. `numbers` counts them.
    """
    return float(samples ** (numbers / (2 * samples)))


@dataclass(frozen=True)
class Fitted:
    """Result of one run of a fit.

    Attributes:
        model: The model that it found; if the model is safe at the fitted angles only, its torque
            is constant outside them.
        initial_torque: The torque with which all curves begin [N·m]; or "measured": each begins
            with its first sample.
        loss: The objective that the fit minimized: the NRMSE (of Jiles-Atherton with the weights of
            the curves), or the objective of the `Search`.
        evaluations: Number of runs of the model on all curves; None if the fit does not count them.
        agreed: Number of starts from which the search ended at this model; None for a fit with one
            start.
        starts: Number of starts; None for a fit with one start.
        history: Smallest objective after each iteration of an optimizer.
    """

    model: HysteresisModel
    initial_torque: InitialTorque
    loss: float
    evaluations: int | None = None
    agreed: int | None = None
    starts: int | None = None
    history: tuple[Any, ...] = field(default=(), repr=False)


def scored(
    model: HysteresisModel, initial_torque: InitialTorque, curves: Sequence[Curve]
) -> Fitted:
    """Returns a fitted model with its NRMSE on curves."""
    errors = torque_errors(model, initial_torque, curves)
    return Fitted(model, initial_torque, nrmse(errors, curves))
