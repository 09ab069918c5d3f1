"""Admittance: the exoskeleton moves as a light mass would that the wearer pushes by the cuffs."""

import numpy as np
from activesuit.arrays import Array
from activesuit.checks import within
from activesuit.envs.belief import LEAD, CuffLevers
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Belief, ModelBased, Seen

FRICTION = 0.8  # share of the motors' friction that is cancelled; with all of it the arm drifts
VELOCITY_BANDWIDTH = 10.0  # rad/s, a third of the inverse of the lag of motors and rates, 0.03 s
RELIEVED = 0.7  # share of the suit's torque; with all of it an arm in a stiff suit oscillates
DAMPING = 1.0  # 1/s, so that a push of noise dies away within a second


class Admittance(ModelBased):
    """Moves the exoskeleton as a virtual mass moves that the forces at the cuffs push.

    Law: M_v q'' + B_v q' = tau_cuff - tau_des with tau_des = -rho times the believed torque of the
    suit, and an inner loop K_v (q'_v - q') to the velocity of that mass, beside the exoskeleton's
    own weight, friction and -tau_des. In the end the cuffs press with rho times the suit's torque.
    Tuning rule: M_v is the exoskeleton's believed inertia. Below it, the exoskeleton is no longer
    passive against the springs of the cuffs. K_v is this inertia times a third of the inverse of
    the lag of motors and rates. rho leaves the wearer a part of the suit's torque, since cuffs
    yield and an arm without load is soft: both swing by 0.1 rad in the emu-like suit at rho = 1, by
    0.03 rad at 0.85, and by 0.01 rad at 0.7.
    Signals needed: encoders and cuffs (coupling="cuffs").
    Source: Keemink, van der Kooij and Stienen 2018, Admittance control for physical human-robot
    interaction, Int. J. Robotics Research 37(11).

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        rho: Share of the suit's torque that the cuffs give, 0 to 1; 0 is transparent.
        mass: Virtual mass over the exoskeleton's, 0.5 to 5.
        damping: Virtual damping B_v over the virtual mass [1/s], 0 to 10.
        lead: Time by which the motors answer late [s], 0 to 0.2.
    """

    sensors = ("encoders", "cuffs")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        rho: float = RELIEVED,
        mass: float = 1.0,
        damping: float = DAMPING,
        lead: float = LEAD,
    ) -> None:
        arm = plant.believed(belief)
        super().__init__(
            plant, weight=arm.exo_weight(), suit=arm.suit(), friction=FRICTION, lead=lead
        )
        within("rho", rho, 0, 1)
        within("mass", mass, 0.5, 5)
        within("damping", damping, 0, 10, " 1/s")
        self._rho, self._damping = rho, damping
        inertia = arm.exo_inertia().nominal()
        self.virtual_mass, self._gain = mass * inertia, VELOCITY_BANDWIDTH * inertia
        self._levers = CuffLevers(arm.model())

    def begin(self, seen: Seen) -> None:
        """Begins with the virtual mass at rest."""
        super().begin(seen)
        self._velocity = np.zeros((len(seen["angle"]), len(self.peak)))

    def torque(self, seen: Seen) -> Array:
        """Returns own weight, friction, the suit's share and the inner loop [N·m], shape (n, 2)."""
        given = super().torque(seen)
        push = self.cuff_torque(seen) + self._pressing
        change = push / self.virtual_mass - self._damping * self._velocity
        self._velocity = self._velocity + change * self.dt
        return given + self._gain * (self._velocity - seen["rate"][:, self.assisted])

    def suit_torque(self, seen: Seen) -> Array:
        """Keeps the torque with which the cuffs shall press on the arm; returns it."""
        self._pressing = self._rho * super().suit_torque(seen)
        return self._pressing

    def cuff_torque(self, seen: Seen) -> Array:
        """Returns the torque of the cuffs' forces on the exoskeleton's motors [N·m], (n, 2)."""
        levers = self._levers(seen["angle"])[..., self.assisted]
        return -np.einsum("nf,nfm->nm", seen["cuff_force"], levers)
