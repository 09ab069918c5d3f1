"""A ratchet wrench: strokes of the elbow against a reaction, and free strokes back."""

import math
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from ...assets import JOINTS
from ..model.workplace import add_reaction, draw, grip, holder
from ..provenance import setting
from ..simulation.kinematics import Arm
from ..simulation.plan import STRONGEST, Plan
from .motions import between, ramped
from .task import SUSTAINED, Task

MIDDLE, SWING = 1.2, 0.25  # rad of the elbow
FREQUENCY = 1.0  # Hz
SHOULDER = (0.7, 0.9)  # rad
DAMPING = 400.0  # [N·s/m], slope of the reaction, which has its limit at 0.1 m/s
BEGINNING = 1.0  # [s], rise of the strokes from rest
STROKE, STRAIGHT = JOINTS.index("elbow_flexion"), JOINTS.index("shoulder_flexion")


@dataclass(frozen=True, kw_only=True)
class Ratchet(Task):
    """The elbow flexes against a reaction at the grip and extends freely, once a second.

    Attributes:
        reaction: Greatest force that withstands the stroke [N].
    """

    reaction: float = setting(40.0, "N", 0, STRONGEST)

    source: ClassVar[str] = (
        "Pistol Grip Tool (techbriefs 28401): up to 34 N·m, at most 100 N at 0.3 m; stroke assumed"
    )
    place: ClassVar[str] = "microgravity"
    period: ClassVar[float | None] = 1 / FREQUENCY

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Adds the reaction, and draws the wrench."""
        add_reaction(spec, "ratchet", self.reaction, DAMPING)
        at = grip(spec).pos
        body = holder(spec)
        draw(
            body,
            mujoco.mjtGeom.mjGEOM_CAPSULE,
            "exo_steel",
            size=[0.011, 0, 0],
            fromto=[*(at + np.array([0, 0.07, 0])), *(at + np.array([0, -0.23, 0]))],
        )
        draw(
            body,
            mujoco.mjtGeom.mjGEOM_CYLINDER,
            "exo_accent",
            size=[0.028, 0, 0],
            fromto=[*(at + np.array([-0.02, -0.25, 0])), *(at + np.array([0.05, -0.25, 0]))],
        )

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns strokes that grow from rest; their ends are watched."""
        del arm
        time = dt * np.arange(samples)
        speed = math.tau * FREQUENCY
        wave, rate = -np.cos(speed * time), speed * np.sin(speed * time)
        grown = ramped(wave, rate, -(speed**2) * wave, time, BEGINNING)
        motion = np.zeros((3, samples, len(JOINTS)))
        motion[0, :, STRAIGHT] = rng.uniform(*SHOULDER)
        motion[:, :, STROKE] = SWING * np.array(grown)
        motion[0, :, STROKE] += MIDDLE
        ends = (np.arange(1, 1 + round(samples * dt * FREQUENCY)) + 0.5) / FREQUENCY
        windows = [(end, end) for end in ends]
        return Plan((motion[0], motion[1], motion[2]), watched=between(windows, samples, dt))


RATCHET = Ratchet(name="Ratchet", duration=15.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03)
"""Fifteen strokes against 40 N, the hand within 3 cm of the end of each."""
