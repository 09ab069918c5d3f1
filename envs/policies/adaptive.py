"""Adaptive compensation: recursive least squares correct the believed suit and weight."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...checks import within
from ..belief import LEAD
from .base import Arms, Seen
from .belief import Belief, BelievedArm
from .model_based import SHARE, ModelBased, friction_of

# The terms: unit hysteresis, a straight spring, bias and carried weight; then acceleration
BELIEVED = np.array([1.0, 0.0, 0.0, 1.0, 0.0])
# 1, N·m/rad, N·m, 1 and kg·m²: how wrong a belief may well be.
SPREAD = np.array([0.7, 3.0, 2.0, 0.3, 0.5])
LASTING = 0.3  # s, for which an error that no term explains stays the same
STILL = 0.02  # rad/s, below which nothing new is learned
NOISE = 0.1  # of the torque, of pads between person and suit
QUIET = 0.2  # N·m, the least error that counts
SCALES = (0.02, 50.0)  # of the unit hysteresis, whose certificate holds for any above 0
LARGEST = np.array([0.0, 40.0, 20.0, 3.0, 5.0])  # bounds of the other terms


class Adaptive(ModelBased):
    """Compensates with a suit and a weight that recursive least squares correct on the way.

    Law: the torque between person and suit and that of the motors together are what suit and
    carried weight need, y = θ·φ with φ = (believed resistance, angle, 1, believed carried weight);
    K = Pφ/(λ + φᵀPφ), θ += K(y - φᵀθ), P = (P - Kφᵀ P)/λ, with a dead zone, P never larger than at
    the start, and θ projected at every update: a Jiles-Atherton model times any number above 0 has
    the same certificate. Tuning: λ = 1 - dt / `forgetting`. Signals: `interaction`, without which
    the person's torque would be taken for the suit's.
    Source: Tan and Baras 2004 (recursive identification of hysteresis), Åström and Wittenmark 1995.

    Args:
        arms: Environment in which the policy acts, single or vector.
        belief: What the controller believes at first of person, suit and load.
        forgetting: Time after which old data count for a third [s], 1 to 1,000.
        delay: Age of the torque between person and suit [s], 0 to 0.5.
        lead: Time by which the motors answer late [s], 0 to 0.2.
        friction: Share of the motors' friction that is cancelled, 0 to 1.

    Raises:
        InputError: An option is out of its range.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders", "interaction")
    tunable: ClassVar = {"forgetting": (3.0, 100.0), "lead": (0.005, 0.06), "friction": (0.3, 1.0)}

    def __init__(
        self,
        arms: Arms,
        belief: Belief | None = None,
        *,
        forgetting: float = 20.0,
        delay: float = 0.05,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        arm = BelievedArm(arms, belief)
        super().__init__(arms, suit=arm.suit(), lead=lead)
        within("forgetting", forgetting, 1, 1000, " s")
        within("delay", delay, 0, 0.5, " s")
        self._carried, self._whole = arm.carried_weight(), arm.whole_weight()
        exo = arms.episodes.simulation.config.exo
        self._rubbing, self._against = friction_of(exo, 1.0), friction_of(exo, friction)
        self._keep, self._late = 1 - self.dt / forgetting, round(delay / self.dt)

    @property
    def estimate(self) -> Array:
        """Factors of believed resistance, angle [N·m/rad], 1 [N·m] and weight, (n, 2, 5)."""
        return self._theta

    def begin(self, seen: Seen) -> None:
        """Begins with what is believed."""
        super().begin(seen)
        shape = (len(seen["angle"]), len(self.peak), len(SPREAD))
        self._theta = np.zeros(shape) + BELIEVED
        self._covariance = np.zeros((*shape, len(SPREAD)))
        self._turned = seen["rate"][:, self.assisted]
        self._covariance[:] = np.diag(SPREAD**2)
        self._past: list[tuple[Array, Array, Array]] = []

    def torque(self, seen: Seen) -> Array:
        """Learns from the last measurement; returns the corrected compensation [N·m], (n, 2)."""
        angle, rate = seen["angle"], seen["rate"]
        turning = rate[:, self.assisted]
        now = self._terms(self._resistance(seen, 0.0), angle, (turning - self._turned) / self.dt)
        self._turned = turning
        given = seen["motor_torque"] * self.peak - self._rubbing(turning)
        self._past.append((now, given, turning))
        if len(self._past) > self._late:
            then, moved, speed = self._past.pop(0)
            measured = seen["interaction_torque"][:, self.assisted] + moved
            self.learn(then, measured, np.abs(speed) > STILL)
        soon = angle + self.lead * rate
        terms = self._terms(self._resistance(seen, self.lead), soon, np.zeros_like(turning))
        own = self._whole(soon) - self._carried(soon)
        return (self._theta * terms).sum(axis=-1) + own + self._against(turning)

    def learn(self, terms: Array, measured: Array, moving: NDArray[np.bool_]) -> None:
        """Corrects the estimate by one measurement of every joint.

        Args:
            terms: Regressors, shape (n, 2, 5).
            measured: Torque that they should explain [N·m], shape (n, 2).
            moving: Which joints move, so that there is something to learn, shape (n, 2).
        """
        error = measured - (self._theta * terms).sum(axis=-1)
        noise = (QUIET + NOISE * np.abs(measured)) ** 2 * LASTING / self.dt
        learns = moving & np.isfinite(error)
        spread = np.einsum("nijk,nik->nij", self._covariance, terms)
        gain = spread / (self._keep * noise + (terms * spread).sum(axis=-1))[..., None]
        step = np.where(learns[..., None], gain * np.where(learns, error, 0.0)[..., None], 0.0)
        self._theta = projected(self._theta + step)
        fresh = (self._covariance - gain[..., :, None] * spread[..., None, :]) / self._keep
        wound = np.einsum("nijj->nij", fresh) > SPREAD**2
        fresh = np.where(wound.any(axis=-1)[..., None, None], fresh * self._keep, fresh)
        self._covariance = np.where(learns[..., None, None], fresh, self._covariance)

    def _resistance(self, seen: Seen, lead: float) -> Array:
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        assert self._suit is not None
        return self._suit.follow(self._memory, angle, rate, lead)

    def _terms(self, resistance: Array, angle: Array, acceleration: Array) -> Array:
        here = angle[:, self.assisted]
        weight, one = self._carried(angle), np.ones_like(here)
        return np.stack([resistance, here, one, weight, acceleration], axis=-1)


def projected(theta: Array) -> Array:
    """Returns the nearest factors that keep the certificate and are physical.

    Args:
        theta: Factors, shape (..., 5).
    """
    found = np.clip(theta, -LARGEST, LARGEST)
    found[..., 0] = np.clip(theta[..., 0], *SCALES)
    return found
