"""The wearer: turns an intention into inputs of the engine's actuators, every control period.

The intention gives the position and velocity inputs of the actuators. `voluntary_torque` gives
their feed-forward input.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from ..arrays import Array
from ..assets import JOINTS
from ..checks import flag
from .person import (
    Person,
    VoluntaryControl,
    fatigue_step,
    isometric_strength,
    muscle_load,
    start_control,
    strength_limits,
    voluntary_torque,
)
from .reference import Reference
from .wiring import Wiring

SETTLING_STEPS = 6  # of Newton's method, which doubles the digits each time
NUDGE = 1e-6  # rad, for its derivatives


@dataclass(eq=False)
class Wearer:
    """A person who controls one arm.

    Attributes:
        person: Size, sex and strength of the wearer.
        settings: Settings of the wearer's control of the arm.
        tires: Whether effort tires the wearer.
        wiring: Addresses of the model.
        dt: Control period [s].
        control: Memory of the wearer's control.
        fatigued: Fatigued part of every muscle group, as in `fatigue_step`, shape (2, 4).
    """

    person: Person
    settings: VoluntaryControl
    tires: bool
    wiring: Wiring
    dt: float

    def __post_init__(self) -> None:
        flag("fatigue", self.tires)
        self._rested = isometric_strength(self.person)
        self.begin(np.zeros(len(JOINTS)))

    def begin(self, intrinsic: Array) -> None:
        """Begins rested, after holding still with the intrinsic torque [N·m], shape (4,)."""
        self.control = start_control(self.settings, intrinsic, self.dt)
        self.fatigued = np.zeros_like(self._rested)

    def settle(self, model: mujoco.MjModel, data: mujoco.MjData, reference: Reference) -> None:
        """Begins an episode at rest at the first intention, where feedback holds unforeseen torque.

        Strength does not limit that torque: a wearer who is too weak drops the arm from there.
        """
        joints, intended = self.wiring.joints, reference.angle[0]
        foreseen = reference.feedforward[0] + self.settings.suit_learning * reference.resistance[0]

        def added(intrinsic: Array) -> Array:
            return foreseen + self.settings.feedback * intrinsic

        def imbalance(angle: Array) -> Array:
            data.qpos[:] = angle
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            intrinsic = self.wiring.stiffness * (intended - angle[joints])
            torque = data.qfrc_passive - data.qfrc_bias
            torque[joints] += intrinsic + added(intrinsic)
            return torque

        angle = np.zeros(model.nq)
        angle[joints] = angle[self.wiring.exo_joints] = intended
        nudges = NUDGE * np.eye(model.nq)
        for _ in range(SETTLING_STEPS):
            torque = imbalance(angle)
            slope = np.column_stack([imbalance(angle + nudge) - torque for nudge in nudges]) / NUDGE
            angle = angle - np.linalg.solve(slope, torque)
        data.qpos[:] = angle
        intrinsic = self.wiring.stiffness * (intended - angle[joints])
        self.begin(intrinsic)
        self._intend(data, intended, np.zeros_like(intended), added(intrinsic))

    def act(
        self, data: mujoco.MjData, reference: Reference, step: int, rng: np.random.Generator
    ) -> None:
        """Acts on the intention of control period `step`; after its end, holds the last sample."""
        wiring, i = self.wiring, reference.at(step)
        intended, ahead = reference.angle[i], reference.rate[i] * (i == step)
        angle, rate = data.qpos[wiring.joints], data.qvel[wiring.joints]
        strength = self._rested * (1 - self.fatigued) if self.tires else self._rested
        torque, self.control = voluntary_torque(
            self.settings,
            self.control,
            intrinsic=wiring.stiffness * (intended - angle) + wiring.damping * (ahead - rate),
            feedforward=reference.feedforward[i],
            suit_resistance=reference.resistance[i],
            limits=strength_limits(strength, angle, rate),
            dt=self.dt,
            rng=rng,
        )
        self._intend(data, intended, ahead, torque)

    def tire(self, data: mujoco.MjData) -> None:
        """Updates fatigue by the torque of the control period that has passed."""
        if not self.tires:
            return
        wiring = self.wiring
        angle, rate = data.qpos[wiring.joints], data.qvel[wiring.joints]
        limits = strength_limits(self._rested, angle, rate)
        load = muscle_load(data.actuator_force[wiring.human], limits)
        self.fatigued = fatigue_step(self.fatigued, load, self.dt)

    def _intend(self, data: mujoco.MjData, angle: Array, rate: Array, torque: Array) -> None:
        data.ctrl[self.wiring.intention] = angle, rate, torque
