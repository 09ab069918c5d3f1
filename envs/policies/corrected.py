"""Compensation on cuffs: the arm's angles are those of the exoskeleton, corrected by the cuffs."""

import math

import numpy as np

from ...arrays import Array
from ..belief import LEAD, Belief, CuffLevers
from ..model.cuffs import CUFFS
from ..plant import Plant
from .base import Seen
from .compensation import Compensation
from .filters import LowPass
from .model_based import SHARE

NOISE = 1.0  # [N], standard deviation of a component of a cuff's force
USUAL = 0.1  # [rad], usual turn of an arm in its cuffs: the prior where no cuff measures it


class CorrectedCompensation(Compensation):
    """Compensates at the angles of the arm, which yields in its cuffs, instead of the encoders'.

    Law: a cuff is a spring with a damper, so that its force, lagged by damping over stiffness, is
    stiffness times displacement. The turns of the four joints that explain all three forces best
    (least squares, with a usual turn of 0.1 rad where forces tell little) are added to the
    encoders' angles. The rest is compensation.
    Tuning rule: none beside those of compensation; the cuffs' stiffness is that of `envs.model`.
    Signals needed: encoders and cuffs (coupling="cuffs").
    Source: joint angles from the deflection of physical interfaces, Schiele and van der Helm 2006,
    Kinematic design to improve ergonomics in human machine interaction, IEEE TNSRE 14(4), for the
    error; the correction is ours.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        lead: Time by which the motors answer late [s], 0 to 0.2.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
    """

    sensors = ("encoders", "cuffs")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        super().__init__(plant, belief, lead=lead, friction=friction)
        self._levers = CuffLevers(plant.believed(belief).model())
        self._stiffness = np.concatenate([cuff.stiffness for cuff in CUFFS.values()])
        damping = np.concatenate([cuff.damping for cuff in CUFFS.values()])
        self._elastic = LowPass(self._stiffness / damping / math.tau, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins with the cuffs in balance."""
        self._elastic.begin(seen["cuff_force"])
        super().begin(self._corrected(seen))

    def torque(self, seen: Seen) -> Array:
        """Returns compensation at the arm's angles [N·m], shape (n, 2)."""
        return super().torque(self._corrected(seen))

    def _corrected(self, seen: Seen) -> Seen:
        return {**seen, "angle": seen["angle"] + self.turn(seen)}

    def turn(self, seen: Seen) -> Array:
        """Returns by how much the arm is turned from the exoskeleton [rad], shape (n, 4)."""
        force = self._elastic.step(seen["cuff_force"])
        spring = self._stiffness[:, None] * self._levers(seen["angle"])
        transposed = np.swapaxes(spring, 1, 2)
        little = (NOISE / USUAL) ** 2 * np.eye(spring.shape[-1])
        pressed = transposed @ force[..., None]
        return -np.linalg.solve(transposed @ spring + little, pressed)[..., 0].astype(np.float64)
