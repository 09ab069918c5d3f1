"""Many reversals inside each other: the first paper's future work."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...assets import JOINTS
from ...published import LI_RANGES
from ..simulation.plan import Motion
from .motions import ramped
from .task import SUSTAINED, Task

FREQUENCIES = np.array([0.3, 0.4, 0.5, 0.6, 0.7])  # Hz
BEGINNING = 1.0  # [s], rise of the amplitude from rest
MOVED = {"shoulder_flexion": LI_RANGES["shoulder"], "elbow_flexion": LI_RANGES["elbow"]}


@dataclass(frozen=True, kw_only=True)
class MinorLoops(Task):
    """Shoulder and elbow move by sums of five sines with random phases."""

    source: ClassVar[str] = (
        "Li et al. 2022, future work: higher-order reversals; 0.3 to 0.7 Hz assumed"
    )

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns sums of sines that fill the measured ranges; see `Task.motion`."""
        time = dt * np.arange(samples)
        motion = np.zeros((3, samples, len(JOINTS)))
        speed = math.tau * FREQUENCIES
        for joint, (low, high) in MOVED.items():
            phase = rng.uniform(0, math.tau, FREQUENCIES.size)
            turned = speed * time[:, None] + phase
            wave = np.sin(turned).sum(axis=1)
            rate = (speed * np.cos(turned)).sum(axis=1)
            acceleration = -(speed**2 * np.sin(turned)).sum(axis=1)
            size = (high - low) / 2 / np.abs(wave).max()
            column = JOINTS.index(joint)
            grown = ramped(wave, rate, acceleration, time, BEGINNING)
            motion[:, :, column] = size * np.array(grown)
            motion[0, :, column] += (low + high) / 2
        return motion[0], motion[1], motion[2]


MINOR_LOOPS = MinorLoops(name="MinorLoops", duration=20.0, effort=SUSTAINED)
"""Nested loops of shoulder and elbow for 20 s."""
