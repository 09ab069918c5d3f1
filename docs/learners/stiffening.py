"""A reward that prices tracking errors as adapted wearers do: with co-contraction.

`activesuit train --reward stiffening:price ...` in this folder. Wearers of a training never learn
to co-contract. Those who are scored do, where errors of the last quarter second are beyond 0.03
rad.
"""

import numpy as np

STRENGTH = np.array([55.0, 85.0, 52.0, 10.0])  # N·m, of the four joints of the default person
USUAL = np.array([27.0, 27.0, 27.6, 5.0])  # N·m/rad, stiffness without co-contraction
SLOPE = np.array([3.2, 3.2, 6.2, 6.2])  # N·m/rad more for each N·m of co-contraction
PER_ERROR, TOLERATED = 10.0, 0.03  # co-contraction over strength per rad, beyond that error [rad]
MOST, WINDOW, PERIOD = 0.3, 0.25, 0.01  # of strength; s; s


class Price:
    """The reward, which remembers the largest recent errors of each row."""

    def __init__(self):
        self.error = None

    def __call__(self, terms, measured):
        """Returns the shipped reward with the effort of the co-contraction, shape (rows,)."""
        error = np.abs(measured["angle"] - measured["target_angle"])
        begins = measured["time"][:, :1] < 1.5 * PERIOD
        if self.error is None or self.error.shape != error.shape:
            self.error = error
        faded = np.where(begins, 0.0, self.error * np.exp(-PERIOD / WINDOW))
        self.error = np.maximum(error, faded)
        gain = SLOPE * STRENGTH * PER_ERROR
        half = (gain * TOLERATED - USUAL) / 2
        stiffness = np.sqrt(half**2 + gain * self.error * USUAL) - half
        more = np.clip((stiffness - USUAL) / SLOPE, 0, MOST * STRENGTH) / STRENGTH
        before = np.mean(measured["effort"] ** 2, axis=1)
        after = np.mean((measured["effort"] + more) ** 2, axis=1)
        effort = terms["effort"] * after / np.maximum(before, 1e-9)
        reward = 1 / (1 + effort + terms["tracking"] + terms["smoothness"])
        return np.where(measured["lost"], 0.0, reward)


price = Price()
