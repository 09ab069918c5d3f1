"""Adaptive oscillators: learn the rhythm of a motion, and assist what comes next of it."""

import math

import numpy as np
from activesuit.arrays import Array
from activesuit.checks import within
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Belief, Compensation, Seen, Transparent

HARMONICS = 3  # the fundamental and two more, which tell fast ends of a motion from slow ones
FIRST = 0.5  # [Hz], limit of slow and fast repeated motions of an arm
SLOWEST, FASTEST = 0.15, 1.5  # Hz
RATE = 2.0  # 1/s, so that amplitudes settle with 1 s, a third of a period of 0.3 Hz
SLOWER = 0.3  # rate of the other pairs over that of the first, so that the frequency comes first
WINDOW = 1.0  # [s], length of the window that weighs the prediction's error
LOCKED, LOST = 0.1, 0.3  # error over size of the motion, at which all and none is assisted
STILL = 0.05  # rad, root mean square of a motion that is no rhythm yet


class Oscillators:
    """Learns frequency, phase, offset and harmonics of rhythmic signals, one for each joint.

    The prediction is q^ = a_0 + sum of (a_i sin i phi + b_i cos i phi), phi' = w. With the error
    F = q - q^ the pairs learn by a_i' = r F sin i phi, b_i' = r F cos i phi, and the frequency by
    w' = r / 4 times what turns the first pair, which damps frequency and phase by 0.7. The other
    pairs learn the more the better the prediction is, so that none takes the rhythm for its own.
    Source: Righetti, Buchli and Ijspeert 2006, Physica D 216; Ronsse et al. 2011, Med. Biol. Eng.
    Comput. 49, where the first pair is an amplitude and a phase.

    Args:
        rate: Rate of learning r [1/s].
        dt: Period [s].

    Attributes:
        frequency: Frequencies w [rad/s], shape (n, joints).
        confidence: 0 where there is no rhythm to 1 where it is well predicted, the same shape.
    """

    def __init__(self, rate: float, dt: float) -> None:
        self._rate, self._dt = rate, dt
        self._orders = np.arange(1, HARMONICS + 1)

    def begin(self, angle: Array) -> None:
        """Begins at rest at angles [rad], shape (n, joints)."""
        shape = angle.shape
        self.frequency = np.full(shape, math.tau * FIRST)
        self.confidence, self._phase = np.zeros(shape), np.zeros(shape)
        self._offset = angle.copy()
        self._pairs = np.zeros((*shape, 2, HARMONICS))
        self._error, self._size = np.zeros(shape), np.zeros(shape)

    def step(self, angle: Array) -> None:
        """Learns from angles a period later [rad], shape (n, joints)."""
        dt = self._dt
        self._phase = self._phase + self.frequency * dt
        error = angle - self.predicted()[0]
        share = dt / WINDOW
        self._error = self._error + share * (error**2 - self._error)
        self._size = self._size + share * ((angle - self._offset) ** 2 - self._size)
        size = np.sqrt(self._size)
        ratio = np.sqrt(self._error) / np.maximum(size, STILL)
        moving = np.clip(size / STILL - 1, 0, 1)
        self.confidence = moving * np.clip((LOST - ratio) / (LOST - LOCKED), 0, 1)
        learned = self._rate * dt * error[..., None, None] * self._waves()
        learned[..., 1:] *= SLOWER * self.confidence[..., None, None]
        (a, b), (da, db) = (np.moveaxis(one[..., 0], -1, 0) for one in (self._pairs, learned))
        turned = (a * db - b * da) / np.maximum(a**2 + b**2, STILL**2)
        frequency = self.frequency + self._rate / 4 * turned
        self.frequency = np.clip(frequency, math.tau * SLOWEST, math.tau * FASTEST)
        self._pairs = self._pairs + learned
        self._offset = self._offset + self._rate / 2 * dt * error

    def predicted(self) -> tuple[Array, Array]:
        """Returns the predicted angles [rad] and rates [rad/s] of now, shape (n, joints) each."""
        waves = self._waves()
        angle = self._offset + (self._pairs * waves).sum((-2, -1))
        turned = np.stack([waves[..., 1, :], -waves[..., 0, :]], axis=-2) * self._orders
        return angle, self.frequency * (self._pairs * turned).sum((-2, -1))

    def _waves(self) -> Array:
        phase = self._phase[..., None] * self._orders
        return np.stack([np.sin(phase), np.cos(phase)], axis=-2)


class AdaptiveOscillators(Compensation):
    """Learns the rhythm of a motion, and compensates what comes next of it.

    Law: compensation at the angles and rates that oscillators predict, without the delay and noise
    of encoders. It fades in with their confidence; what has no rhythm gets transparency alone.
    Tuning rule: amplitudes settle in 1 s, a third of a period of 0.3 Hz; frequency and phase follow
    with a damping of 0.7 (see `Oscillators`). The rate was picked from a few, by locking to sines.
    Signals needed: encoders. It is made for repeated motions, and assists on for a moment where
    one stops.
    Source: Ronsse et al. 2010, BioRob; 2011, Med. Biol. Eng. Comput. 49, 1173-1185.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        rate: Rate of learning [1/s], 0.1 to 4.
    """

    def __init__(self, plant: Plant, belief: Belief | None = None, *, rate: float = RATE) -> None:
        super().__init__(plant, belief)
        within("rate", rate, 0.1, 4, " 1/s")
        self._transparent = Transparent(plant)
        self.oscillators = Oscillators(rate, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins without a rhythm."""
        super().begin(seen)
        self.oscillators.begin(seen["angle"][:, self.assisted])

    def torque(self, seen: Seen) -> Array:
        """Returns compensation of what is predicted, or transparency [N·m], shape (n, 2)."""
        self.oscillators.step(seen["angle"][:, self.assisted])
        share, mixed = self.oscillators.confidence, dict(seen)
        for name, guess in zip(("angle", "rate"), self.oscillators.predicted(), strict=True):
            mixed[name] = seen[name].copy()
            mixed[name][:, self.assisted] += share * (guess - seen[name][:, self.assisted])
        assisted = share * super().torque(mixed)
        return assisted + (1 - share) * self._transparent.torque(seen)
