"""Radial basis tracker: a network learns, while it tracks the intention, what torque that takes."""

import math

import numpy as np
from activesuit.arrays import Array
from activesuit.checks import within
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Belief, Seen, TorquePolicy
from activesuit.envs.policies.model_based import intended

BANDWIDTH = 1.0  # Hz, a fifth of what the lag of motors and rates, 0.03 s, would let oscillate
CENTERS = (0.0, 0.6, 1.2, 1.8)  # [rad], each angle's, over the reach of shoulder and elbow
RATES = (-1.5, 0.0, 1.5)  # [rad/s], each rate's, over the motions of daily work
FORGETTING = 0.05  # 1/s, so that weights decay where nothing is to be learned


class RadialBasisTracker(TorquePolicy):
    """Tracks the intention and learns by a radial basis network the torque that this takes.

    Law: tau = W'phi(x) + K s with s = e' + L e, and dW/dt = G s phi / |phi|² - f W. The network phi
    is of Gaussians of the intended angles and rates of both joints, which add up to 1; weights stay
    within the motors' peak. No model of weight or suit is needed.
    Tuning rule: L and K as of a critically damped arm of the believed inertia at the bandwidth w,
    L = w / 2 and K = 2 M w; G = K w / 2, which learns at the pace at which s decays.
    Signals needed: encoders and a preview of the intention.
    Source: the law of the published active suits, Li, Dai and Tang 2021, Electronics 10(6) 638, and
    Liu et al. 2025, Electronics 14(10) 1969, without their fuzzy terms.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of masses, for its gains alone.
        bandwidth: Bandwidth w of tracking [Hz], 0.1 to 3.
    """

    sensors = ("encoders", "preview")

    def __init__(
        self, plant: Plant, belief: Belief | None = None, *, bandwidth: float = BANDWIDTH
    ) -> None:
        super().__init__(plant)
        within("bandwidth", bandwidth, 0.1, 3, " Hz")
        inertia, pole = plant.believed(belief).inertia().nominal(), math.tau * bandwidth
        self._slope, self._gain = pole / 2, 2 * inertia * pole
        self._learning = self._gain * pole / 2
        grid = np.meshgrid(CENTERS, CENTERS, RATES, RATES)
        self._centers = np.stack(grid, axis=-1).reshape(-1, 4)
        self._widths = np.repeat([np.diff(one)[0] for one in (CENTERS, RATES)], 2)

    def begin(self, seen: Seen) -> None:
        """Begins with a network that has learned nothing."""
        self._weights = np.zeros((len(seen["angle"]), len(self.peak), len(self._centers)))

    def torque(self, seen: Seen) -> Array:
        """Returns what the network says and the pull to the intention [N·m], shape (n, 2)."""
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        target, target_rate = intended(seen["target"])
        slip = target_rate - rate + self._slope * (target - angle)
        active = self.activity(target, target_rate)[:, None]
        size = (active**2).sum(-1)
        learned = (self._learning * slip / size)[..., None] * active - FORGETTING * self._weights
        limit = self.peak[:, None]
        self._weights = np.clip(self._weights + self.dt * learned, -limit, limit)
        return (self._weights * active).sum(-1) + self._gain * slip

    def activity(self, angle: Array, rate: Array) -> Array:
        """Returns the activity of each Gaussian, shape (n, 144); of one row it adds up to 1."""
        away = np.concatenate([angle, rate], axis=1)[:, None] - self._centers
        active = np.exp(-((away / self._widths) ** 2).sum(-1) / 2)
        return active / active.sum(1, keepdims=True)
