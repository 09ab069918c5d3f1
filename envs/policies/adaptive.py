"""Policies that learn: suit and weight by recursive least squares, torques from cycle to cycle."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief
from ..plant import Plant
from .base import Seen
from .model_based import SHARE, Compensation, ModelBased
from .observers import Carried, LowPass, person_torque

# The terms: believed hysteresis, a straight spring, bias and carried weight.
BELIEVED = np.array([1.0, 0.0, 0.0, 1.0])
SPREAD = np.array([0.7, 1.0, 1.0, 0.3])  # [1, N·m/rad, N·m, 1], usual errors of a belief
CUTOFF = 3.0  # Hz
LASTING = 0.3  # [s], correlation time of the error that the terms do not explain
STILL = 0.02  # [rad/s], greatest rate at which nothing is learned
NOISE = 0.1  # noise of the torque sensors between person and suit, over the torque
QUIET = 0.2  # [N·m], least noise
SCALES = (0.02, 50.0)  # range of the hysteresis' factor; each factor above 0 keeps the certificate
LARGEST = np.array([0.0, 40.0, 20.0, 3.0])  # bounds of the other terms
LEARNED_CUTOFF = 4.0  # [Hz], greatest frequency of iterative learning; faster is noise and lag
LONGEST = 60.0  # [s], greatest time of a cycle


class Adaptive(ModelBased):
    """Compensates with a suit and a weight that recursive least squares correct.

    Law: the torques of person and motors, less the change of momentum of suit, exoskeleton and
    load, are the torque of suit and weight, y = θ·φ with φ = (believed resistance, angle, 1,
    believed carried weight), both through the same low-pass, so that no acceleration is needed;
    K = Pφ/(λ + φᵀPφ), θ += K(y - φᵀθ), P = (P - Kφᵀ P)/λ, with a dead zone, P never larger than at
    the start, and θ projected at every update: a Jiles-Atherton model times any number above 0 has
    the same certificate. Tuning: λ = 1 - dt / `forgetting`. Signals: `interaction`, since otherwise
    the person's torque would count as the suit's.
    Source: Tan and Baras 2004 (recursive identification of hysteresis), Åström and Wittenmark 1995.

    Args:
        forgetting: Time after which old data count for a third [s], 1 to 1,000.

    Attributes:
        estimate: Factors of believed resistance, angle [N·m/rad], 1 [N·m] and weight, (n, 2, 4).
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders", "interaction")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        forgetting: float = 20.0,
        delay: float = 0.05,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        arm = plant.believed(belief)
        super().__init__(plant, suit=arm.suit(), lead=lead, friction=friction)
        within("forgetting", forgetting, 1, 1000, " s")
        within("delay", delay, 0, 0.5, " s")
        self._weight, self._whole = arm.carried_weight(), arm.whole_weight()
        self._carried = Carried(plant, belief)
        self._keep, self._late = 1 - self.dt / forgetting, round(delay / self.dt)
        self._terms_slowly, self._torque_slowly, self._momentum_slowly = (
            LowPass(CUTOFF, self.dt) for _ in range(3)
        )

    def begin(self, seen: Seen) -> None:
        """Begins with the believed factors."""
        super().begin(seen)
        shape = (len(seen["angle"]), len(self.peak))
        self.estimate = np.tile(BELIEVED, (*shape, 1))
        self._covariance = np.tile(np.diag(SPREAD**2), (*shape, 1, 1))
        terms, (momentum, _) = self._terms(seen, 0.0), self._carried(seen)
        self._past: list[tuple[Array, Array, Array, Array]] = []
        self._terms_slowly.begin(terms)
        self._torque_slowly.begin((self.estimate * terms).sum(axis=-1))
        self._momentum_slowly.begin(momentum)
        self._slow = momentum

    def torque(self, seen: Seen) -> Array:
        """Learns from the last measurement; returns the corrected compensation [N·m], (n, 2)."""
        rate = seen["rate"]
        terms, (momentum, known) = self._terms(seen, 0.0), self._carried(seen)
        known = known + self._weight(seen["angle"])  # without the unknown factor
        self._past.append((terms, momentum, known, rate[:, self.assisted]))
        if len(self._past) > self._late:  # the person's torque comes late
            terms, momentum, known, then = self._past.pop(0)
            slow = self._momentum_slowly.step(momentum)
            change, self._slow = (slow - self._slow) / self.dt, slow
            needed = self._torque_slowly.step(known + person_torque(seen)) - change
            self.learn(self._terms_slowly.step(terms), needed, np.abs(then) > STILL)
        soon = seen["angle"] + self.lead * rate
        own = self._whole(soon) - self._weight(soon)
        corrected = (self.estimate * self._terms(seen, self.lead)).sum(axis=-1)
        return corrected + own + self.friction(rate[:, self.assisted])

    def learn(self, terms: Array, measured: Array, moving: NDArray[np.bool_]) -> None:
        """Corrects the estimate of the joints that move, shape (n, 2), by one measurement of each.

        Regressors have the shape (n, 2, 4), the torques that they explain [N·m] (n, 2).
        """
        error = measured - (self.estimate * terms).sum(axis=-1)
        noise = (QUIET + NOISE * np.abs(measured)) ** 2 * LASTING / self.dt
        learns = moving & np.isfinite(error)
        spread = np.einsum("nijk,nik->nij", self._covariance, terms)
        gain = spread / (self._keep * noise + (terms * spread).sum(axis=-1))[..., None]
        step = np.where(learns[..., None], gain * np.where(learns, error, 0.0)[..., None], 0.0)
        moved = self.estimate + step
        self.estimate = np.clip(moved, -LARGEST, LARGEST)
        self.estimate[..., 0] = np.clip(moved[..., 0], *SCALES)
        fresh = (self._covariance - gain[..., :, None] * spread[..., None, :]) / self._keep
        wound = np.einsum("nijj->nij", fresh) > SPREAD**2
        fresh = np.where(wound.any(axis=-1)[..., None, None], fresh * self._keep, fresh)
        self._covariance = np.where(learns[..., None, None], fresh, self._covariance)

    def _terms(self, seen: Seen, lead: float) -> Array:
        """Returns the regressors after a time [s], shape (n, 2, 4)."""
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        assert self.suit is not None
        resistance = self.suit.follow(self._memory, angle, rate, lead)
        weight = self._weight(seen["angle"] + lead * seen["rate"])
        here = angle + lead * rate
        return np.stack([resistance, here, np.ones_like(here), weight], axis=-1)


class IterativeLearning(Compensation):
    """Compensates, and adds in each cycle the torque that the person gave in the cycles before.

    Law: u(k+1, phase) = Q[u(k, phase) + L e(k, phase + lead)], with the torque e that the person
    gives to the suit, plus the part of the arm's weight that the motors carry, and a filter Q
    without delay, since the whole cycle is known. The error shrinks by the factor 1 - L per cycle
    where the person yields to the motors. Tuning: L = 1 would remove the whole error in one cycle,
    half of that is robust; the lead is the motors' lag. Signals: `interaction`, and the time of a
    cycle from the task; in a task without cycles the policy is compensation.
    Source: Zhang, Cheah and Collins (the best of nine torque controllers).

    Args:
        gain: Share L of the missing torque that is added, 0 to 1.
        period: Time of a cycle [s]; 0 is that of the task.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders", "interaction")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        gain: float = 0.5,
        period: float = 0.0,
        delay: float = 0.05,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        super().__init__(plant, belief, lead=lead, friction=friction)
        within("gain", gain, 0, 1)
        within("period", period, 0, LONGEST, " s")
        within("delay", delay, 0, 0.5, " s")
        arm = plant.believed(belief)
        self._own = arm.whole_weight() - arm.carried_weight()
        self._gain, self._late = gain, round(delay / self.dt)
        self._cycle = round((period or plant.period or 0.0) / self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins with nothing learned."""
        super().begin(seen)
        shape = (max(self._cycle, 1), len(seen["angle"]), len(self.peak))
        self._learned, self._missing = np.zeros(shape), np.zeros(shape)
        self._period = 0

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the learned torque of this phase [N·m], (n, 2)."""
        torque = super().torque(seen)
        if not self._cycle:
            return torque
        own = self._own(seen["angle"])  # the arm's weight, which the motors carry too
        given = seen["interaction_torque"][:, self.assisted] + own
        self._missing[(self._period - self._late) % self._cycle] = given
        if self._period and self._period % self._cycle == 0:
            ahead = round(self.lead / self.dt)
            self._learned = learned(self._learned, self._missing, self._gain, ahead, self.dt)
        torque += self._learned[self._period % self._cycle]
        self._period += 1
        return torque


def learned(known: Array, missing: Array, gain: float, ahead: int, dt: float) -> Array:
    """Returns the torques of the next cycle [N·m], shape (periods, ...).

    A share `gain` of the missing torques is added to the known ones, `ahead` control periods
    earlier.
    """
    width = 1 / (2 * np.pi * LEARNED_CUTOFF * dt)
    found = known + gain * np.roll(missing, -ahead, axis=0)
    return gaussian_filter1d(found, width, axis=0, mode="wrap")
