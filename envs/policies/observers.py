"""Policies that estimate the suit's torque, disturbances or the turn of the arm in its cuffs.

Estimated torques are changes of the carried momentum that known torques do not explain.
"""

import math

import numpy as np

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief, CuffLevers
from ..belief.rigid import ASSISTED_PLACES
from ..model.cuffs import CUFFS
from ..plant import Plant
from ..simulation.measurements import smoothing
from .base import Seen
from .model_based import SHARE, Compensation, Friction, ModelBased


class LowPass:
    """A first-order low-pass with one cutoff (-3 dB) [Hz] or one for each component."""

    def __init__(self, cutoff: float | Array, dt: float) -> None:
        self._share = smoothing(cutoff, dt)

    def begin(self, value: Array) -> None:
        """Begins at rest at a value of any shape."""
        self._value = value.copy()

    def step(self, value: Array) -> Array:
        """Returns the filtered value after a period, the same shape."""
        self._value = self._value + self._share * (value - self._value)
        return self._value


class SecondOrderLowPass:
    """A critically damped low-pass of second order with a natural frequency (-6 dB) [Hz].

    `step` returns the output and its rate.
    """

    def __init__(self, cutoff: float, dt: float) -> None:
        self._pole, self._dt = math.tau * cutoff, dt

    def begin(self, value: Array) -> None:
        """Begins at rest at a value, any shape."""
        self._value, self._rate = value.copy(), np.zeros_like(value)

    def step(self, value: Array) -> tuple[Array, Array]:
        """Returns the filtered value after a period and its rate per second."""
        w, dt = self._pole, self._dt
        away = self._value - value
        drive = self._rate + w * away  # the solution is (away + drive t) exp(-w t)
        decay = math.exp(-w * dt)
        self._rate = (drive - w * (away + drive * dt)) * decay
        self._value = value + (away + drive * dt) * decay
        return self._value, self._rate


class Carried:
    """Believed momentum of suit, exoskeleton and load, and the known torques on these.

    The suit's torque and the person's torque, which `person_torque` measures, are not included. The
    bare arm is no part of the momentum: `interaction_torque` is the person's torque less the torque
    of the bare arm, and moves suit, exoskeleton and load alone.
    """

    def __init__(self, plant: Plant, belief: Belief | None) -> None:
        arm = plant.believed(belief)
        self._inertia, self._weight = arm.carried_inertia(), arm.carried_weight()
        self._friction = Friction(arm.config.exo, 1.0, viscous=False)
        self._peak = np.array([motor.peak_torque for motor in arm.config.exo.motors.values()])

    def __call__(self, seen: Seen) -> tuple[Array, Array]:
        """Returns momentum [N·m·s] and torque of motors, weight and friction [N·m], (n, 2) each."""
        angle, rate = seen["angle"], seen["rate"]
        momentum, gyration = self._inertia.momentum(angle, rate)
        given = seen["motor_torque"] * self._peak - self._friction(rate[:, ASSISTED_PLACES])
        return momentum, gyration - self._weight(angle) + given


def person_torque(seen: Seen) -> Array:
    """Returns the person's torque on suit, exoskeleton and load [N·m], shape (n, 2)."""
    return seen["interaction_torque"][:, ASSISTED_PLACES]


class MomentumObserver:
    """Estimates the unknown torque that changes a momentum together with known torques.

    The residual r = K (p - integral of (known + r)) needs no acceleration. It follows the unknown
    torque as a low-pass of first order with the bandwidth K.
    Source: De Luca and Mattone 2003, ICRA; Haddadin, De Luca and Albu-Schäffer 2017, IEEE T-RO 33.

    Args:
        bandwidth: Bandwidth K [rad/s].
        dt: Period [s].
    """

    def __init__(self, bandwidth: float, dt: float) -> None:
        self._gain, self._dt = (1 - math.exp(-bandwidth * dt)) / dt, dt  # exact if constant

    def begin(self, momentum: Array) -> None:
        """Begins at a momentum [N·m·s] of any shape, with residual zero."""
        self._explained, self._residual = momentum.copy(), np.zeros_like(momentum)

    def step(self, momentum: Array, known: Array) -> Array:
        """Returns the residual after a period [N·m], the same shape.

        Args:
            momentum: Momentum at the end of the period [N·m·s].
            known: Known torque during the period, with C'q' - g [N·m].
        """
        self._explained = self._explained + (known + self._residual) * self._dt
        self._residual = self._gain * (momentum - self._explained)
        return self._residual


class ObserverAssist(ModelBased):
    """Cancels the suit's torque that a momentum observer finds, without any model of the suit.

    Law: believed weight and friction, less the residual of a momentum observer of suit, exoskeleton
    and load. The observer knows motors, weight, friction and the person's torque.
    Tuning rule: the person's torque is measured 0.05 s late, so the loop from motor to wearer and
    back has a gain of at most K times 0.05 s, which is one half by default.
    Signals needed: encoders and the interaction torque. Without the interaction torque the residual
    contains the person's torque as well, and cancelling the residual works against the wearer. The
    believed suit has no effect.
    Source: De Luca and Mattone 2003 (see `MomentumObserver`).

    Args:
        bandwidth: Bandwidth K of the observer [rad/s], 0.1 to 20.
    """

    sensors = ("encoders", "interaction")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        bandwidth: float = 10.0,
        lead: float = LEAD,
    ) -> None:
        weight = plant.believed(belief).whole_weight()
        super().__init__(plant, weight=weight, friction=SHARE, lead=lead)
        within("bandwidth", bandwidth, 0.1, 20, " rad/s")
        self._carried = Carried(plant, belief)
        self._observer = MomentumObserver(bandwidth, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins the observer with nothing unexplained."""
        super().begin(seen)
        self._observer.begin(self._carried(seen)[0])

    def torque(self, seen: Seen) -> Array:
        """Returns weight, friction and the suit's estimated torque [N·m], shape (n, 2)."""
        momentum, known = self._carried(seen)
        return super().torque(seen) - self._observer.step(momentum, known + person_torque(seen))


class Inertial(Compensation):
    """Compensates, and carries a share of the inertia of suit, exoskeleton and load.

    Law: compensation + s (p' - C'q'), with the believed momentum p, whose rate p' comes from a
    critically damped low-pass of second order, and the torque C'q' of the motion itself.
    Tuning rule: the share s is below 1, so that on a free arm the loop has a gain below 1 at every
    frequency. Late torque excites a wearer who aims: the policy helps in fast motions, and harms
    in slow ones with rests.
    Source: Aguirre-Ollinger et al. 2011, Int. J. Robot. Res. 30(4): emulated inertia.

    Args:
        share: Share s of the inertia that the motors carry, 0 to 0.9.
        bandwidth: Natural frequency of the low-pass [Hz], 0.5 to 20.
    """

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        share: float = 0.6,
        bandwidth: float = 5.0,
    ) -> None:
        super().__init__(plant, belief)
        within("share", share, 0, 0.9)
        within("bandwidth", bandwidth, 0.5, 20, " Hz")
        self._inertia, self._share = plant.believed(belief).carried_inertia(), share
        self._moving = SecondOrderLowPass(bandwidth, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins at the momentum of the first observation."""
        super().begin(seen)
        self._moving.begin(self._inertia.momentum(seen["angle"], seen["rate"])[0])

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the share of the inertia's torque [N·m], shape (n, 2)."""
        momentum, gyration = self._inertia.momentum(seen["angle"], seen["rate"])
        _, changed = self._moving.step(momentum)
        return super().torque(seen) + self._share * (changed - gyration)


class DisturbanceObserver(Compensation):
    """Compensates, and cancels torques that the believed arm and suit do not explain.

    Law: compensation + d, with d = Q (known torque - P^-1 q): the torques of motors and person less
    the torques of believed suit, weight, friction and inertia in the measured motion, through a
    critically damped low-pass Q of second order.
    Tuning rule: the person's torque is measured T = 0.05 s late, so the loop from motor to wearer
    and back has the gain |Q| |1 - exp(-jwT)|, which must stay below 1: 5 Hz and less. At the
    default it is 0.31 at most.
    Signals needed: encoders and the interaction torque. Without the interaction torque the policy
    would cancel the wearer's torque as a disturbance.
    Source: Ohnishi, Shibata and Murakami 1996, IEEE/ASME T-Mech 1; Chen et al. 2016, IEEE T-IE 63.

    Args:
        bandwidth: Natural frequency of the filter Q [Hz], 0.1 to 5.
    """

    sensors = ("encoders", "interaction")

    def __init__(
        self, plant: Plant, belief: Belief | None = None, *, bandwidth: float = 2.0
    ) -> None:
        super().__init__(plant, belief)
        within("bandwidth", bandwidth, 0.1, 5, " Hz")
        self._carried = Carried(plant, belief)
        self._moving = SecondOrderLowPass(bandwidth, self.dt)
        self._known = SecondOrderLowPass(bandwidth, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins the filters at rest, with no disturbance."""
        super().begin(seen)
        momentum, known = self._carried(seen)
        self._moving.begin(momentum)
        self._known.begin(0 * known)

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the estimated disturbance [N·m], shape (n, 2)."""
        self._resistance = 0.0
        compensation = super().torque(seen)
        momentum, known = self._carried(seen)
        _, needed = self._moving.step(momentum)
        explained, _ = self._known.step(known + person_torque(seen) - self._resistance)
        return compensation + explained - needed

    def suit_torque(self, seen: Seen) -> Array:
        """Returns the believed resistance of the suit, and keeps it for the observer."""
        self._resistance = super().suit_torque(seen)
        return self._resistance


CUFF_NOISE = 1.0  # [N], standard deviation of a component of a cuff's force
USUAL_TURN = 0.1  # [rad], standard deviation of an arm's turn in its cuffs before any measurement


class CorrectedCompensation(Compensation):
    """Compensates at the angles of the arm, which differ from the encoders' as the cuffs yield.

    Law: a cuff is a spring with a damper, so that its force, lagged by damping over stiffness, is
    stiffness times displacement. The turns of the four joints that explain all three forces best
    (regularized least squares with a standard deviation of 0.1 rad) are added to the encoders'
    angles. The rest is compensation.
    Tuning rule: as of compensation; the cuffs' stiffness is that of `envs.model`.
    Signals needed: encoders and cuffs (coupling="cuffs").
    Source: joint angles from the deflection of physical interfaces, Schiele and van der Helm 2006,
    Kinematic design to improve ergonomics in human machine interaction, IEEE TNSRE 14(4), for the
    error; the correction is ours.
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
        """Begins with the springs of the cuffs in balance."""
        self._elastic.begin(seen["cuff_force"])
        super().begin(self._corrected(seen))

    def torque(self, seen: Seen) -> Array:
        """Returns compensation at the arm's angles [N·m], shape (n, 2)."""
        return super().torque(self._corrected(seen))

    def _corrected(self, seen: Seen) -> Seen:
        return {**seen, "angle": seen["angle"] + self.turn(seen)}

    def turn(self, seen: Seen) -> Array:
        """Returns the angles of the arm less those of the exoskeleton [rad], shape (n, 4)."""
        force = self._elastic.step(seen["cuff_force"])
        spring = self._stiffness[:, None] * self._levers(seen["angle"])
        transposed = np.swapaxes(spring, 1, 2)
        little = (CUFF_NOISE / USUAL_TURN) ** 2 * np.eye(spring.shape[-1])
        pressed = transposed @ force[..., None]
        return -np.linalg.solve(transposed @ spring + little, pressed)[..., 0].astype(np.float64)
