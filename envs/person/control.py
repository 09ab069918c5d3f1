"""The wearer's control of the arm: impedance, learned torque, reflex and correction.

In every control period a wearer whose arm is e [rad] and de/dt [rad/s] off the intention gives

    muscle    = own + learned + reflex + correction, within strength
    stiffness = K0 + K1 (|muscle| + co-contraction)        more torque stiffens the joint
    total     = muscle + stiffness (e + damping time · de/dt), within strength

where own is the torque that moves the bare arm along the intention. The stiffness and its damping
act inside the physics, at every step. The reflex responds to stiffness (e + 0.1 s · de/dt) after a
delay, through the lag of muscles. Optional noise is proportional to the total: slow noise (corner 4
Hz) and tremor (a resonance at 10 Hz, 4 Hz wide).

The *correction* is voluntary, and as intermittent as that of people who track with the hand (Miall,
Weir and Stein 1993). Every 0.2 s the wearer sees the error of 0.15 s ago, less what the last two
corrections, whose effect is not visible yet, will still remove (a Smith predictor; Miall, Weir,
Wolpert and Stein 1993, J. Mot. Behav. 25:203-216). If the rest of the error is beyond 12 mrad and
beyond the way that the intention covers in 0.17 s, the torque changes smoothly, within 0.2 s, by
half of the torque that would remove the rest.

A *persistent* wearer (an option) also pushes where the gear's dry friction holds a joint. If the
intention has rested for 0.7 s, and a joint that is felt to be off does not approach the intention
for 0.08 s, the torque rises by 5.2 times the friction in a second until the joint gives, and falls
by the friction when the joint arrives. The friction is known: the wearer knows the exoskeleton.
Such a wearer stiffens while an error is seen, and corrects by less each time that the error changes
its side.

A wearer *learns* the net load: a share of each torque that was needed is given in advance in the
next repetition, and a smaller share is forgotten:

    learned' = (1 - forgetting) learned + rate · answer(t + 0.1 s)

The learned torque converges to rate / (rate + forgetting) of the load, where learning and
forgetting balance.
Where errors beyond what the task tolerates remain, the wearer learns to *co-contract* (Franklin,
Burdet et al. 2008, J. Neurosci. 28:11165):

    contraction' = (1 - relaxing) contraction + stiffening · strength · max(0, |e| - tolerated)
"""

from dataclasses import dataclass
from math import cos, exp, isclose, pi, sin, sqrt
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...checks import flag
from ...errors import InputError
from ..provenance import check_settings, numbers_of, setting
from .anthropometry import Person
from .strength import isometric_strength

PROVENANCE = numbers_of("control")
_VALUE = {one.name.removeprefix("control."): one.value for one in PROVENANCE}


def _by_joint(name: str) -> Array:
    return np.array([_VALUE[f"{name}.{joint}"] for joint in JOINTS])


NOISE_SIZE = _by_joint("noise")
RATE, FORGETTING = _VALUE["learning"], _VALUE["forgetting"]
STIFFENING, RELAXING = _VALUE["stiffening"], _VALUE["relaxing"]
HARDEST = _VALUE["contraction.most"]  # of strength
_PERSISTENCE = [
    one.removeprefix("persistence.") for one in _VALUE if one.startswith("persistence.")
]
LEAD = _VALUE["reflex.lead"]  # s
# Stiffness [N·m/rad] and damping [N·m·s/rad] of an arm guided by stiff hands: those of version 0.1.
STIFF = np.array([[250.0, 250.0, 120.0, 20.0], [26.0, 30.0, 10.0, 1.0]])


@dataclass(frozen=True, kw_only=True)
class VoluntaryControl:
    """Settings of a wearer's control of the arm. All fields are plain values.

    Nothing is random by default, so that two policies or two suits meet the same wearer. With
    `noise=1` the torque of the wearer varies as that of people does.

    Attributes:
        stiffness: Stiffness in multiples of a typical person's of that strength, 0.25 to 4.
        damping: Damping over stiffness [s], 0.03 to 0.3.
        contraction: Co-contraction in multiples of a typical one, 0 to 4. It stiffens the joints,
            counts as effort and causes fatigue.
        reflex: Gain of the reflex, a factor of stiffness, 0 to 1.
        delay: Time from an error to the reflex to it [s], 0 to 0.5, a multiple of the
            control period.
        correction: Share of the error that one voluntary correction removes, 0 to 1.
        adaptation: Rate of learning from episode to episode in multiples of a typical person's, 0
            (who never learns) to 1.
        noise: Signal-dependent noise in multiples of a typical one, whose standard deviation is
            2.5 % of the torque at shoulder and elbow and 4.5 % at the wrist, 0 to 10.
        tremor: Standard deviation of physiological tremor over the torque, 0 to 0.5.
        stiff: Whether the arm is guided along the intention by stiff hands instead, whose torque is
            that of inverse dynamics, the most that a person can learn. The other settings of
            impedance, reflex, correction and learning then have no effect.
        persistent: Whether the wearer pushes where the gear's friction holds a joint off its place,
            stiffens while an error is seen, and corrects by less while a joint swings. A push by
            motors is then corrected within a second instead of four. In learned motions such a
            wearer needs some 0.1 points of strength more (`docs/model.md` has the figures).
    """

    stiffness: float = setting(1.0, "times a typical person's", 0.25, 4)
    damping: float = setting(_VALUE["damping"], "s", 0.03, 0.3)
    contraction: float = setting(1.0, "times a typical person's", 0, 4)
    reflex: float = setting(_VALUE["reflex"], "of the stiffness", 0, 1)
    delay: float = setting(_VALUE["delay"], "s", 0, 0.5)
    correction: float = setting(_VALUE["correction"], "of the error", 0, 1)
    adaptation: float = setting(1.0, "of a typical person's rate of learning", 0, 1)
    noise: float = setting(0.0, "times a typical person's", 0, 10)
    tremor: float = setting(0.0, "of the torque", 0, 0.5)
    stiff: bool = False
    persistent: bool = False

    def __post_init__(self) -> None:
        check_settings(self, "control.")
        flag("stiff", self.stiff)
        flag("persistent", self.persistent)

    def periods(self, dt: float) -> int:
        """Returns the delay in control periods of `dt` [s]."""
        count = round(self.delay / dt)
        if not isclose(count * dt, self.delay, abs_tol=1e-9):
            raise InputError(
                f"delay is {self.delay:g} s: give it as a multiple of the control period, "
                f"{dt:g} s, such as {count * dt:g} s"
            )
        return count

    @property
    def learns(self) -> bool:
        """Whether the wearer learns from episode to episode."""
        return self.adaptation > 0 and not self.stiff

    def impedance(self, person: Person) -> Array:
        """Returns the parameters of the joints' impedance, shape (5, 4).

        Rows: stiffness at rest [N·m/rad], its growth with torque [1/rad], damping [N·m·s/rad],
        damping over stiffness [s], and co-contraction [N·m], which the stiffness at rest includes.
        Both grow with strength.
        """
        zero = np.zeros(len(JOINTS))
        if self.stiff:
            return np.array([STIFF[0], zero, STIFF[1], zero, zero])
        base, slope, contraction = map(
            _by_joint, ("stiffness.base", "stiffness.slope", "contraction")
        )
        stronger = isometric_strength(person).sum(axis=0) / isometric_strength(Person()).sum(axis=0)
        rest = stronger * (base + slope * self.contraction * contraction)
        return np.array(
            [
                self.stiffness * rest,
                self.stiffness * slope,
                zero,
                np.full(len(JOINTS), self.damping),
                stronger * self.contraction * contraction,
            ]
        )

    def feedback(self, dt: float) -> dict[str, Any]:
        """Returns the constants of reflex and correction in control periods of `dt` [s].

        The constants are the gain and lead [s] of the reflex, the share of a change that the
        muscles follow in one period, the share of one correction, the periods between two
        corrections, the least error that is corrected [rad], and the time by which an intention may
        be late [s].
        """
        return {
            "reflex_gain": 0.0 if self.stiff else self.reflex,
            "lead": LEAD,
            "lag": 1 - exp(-dt / _VALUE["reflex.lag"]),
            "correction_gain": 0.0 if self.stiff else self.correction,
            "correction_periods": max(1, round(_VALUE["correction.interval"] / dt)),
            "least": _VALUE["correction.least"],
            "late": _VALUE["correction.late"],
        }

    def persistence(self, dt: float) -> dict[str, Any]:
        """Returns the constants of a persistent wearer's law by their fields in `Persistence`.

        The constants hold for control periods of `dt` [s].
        """
        of = {name: _VALUE[f"persistence.{name}"] for name in _PERSISTENCE}
        late, window = (max(1, round(of.pop(name) / dt)) for name in ("felt", "window"))
        return {"dt": dt, "late": late, "window": window, **of, "hardest": HARDEST}

    def learning(self, dt: float) -> dict[str, Any]:
        """Returns the constants of learning in control periods of `dt` [s].

        The constants are the rate of learning, the share that is forgotten, and the number of
        periods by which the learned torque precedes the error that it corrects.
        """
        return {
            "rate": self.adaptation * _VALUE["learning.pace"] if self.learns else 0.0,
            "forgetting": FORGETTING / RATE,
            "ahead": round(_VALUE["learning.credit"] / dt),
        }


def sight_periods(dt: float) -> int:
    """Returns the delay of the voluntary correction in control periods of `dt` [s]."""
    return round(_VALUE["correction.delay"] / dt)


def noise_constants(dt: float) -> Array:
    """Returns coefficients that advance noise and tremor by one control period, shape (6,).

    Decay of the noise; decay of the tremor, cosine and sine of its rotation; then the weights of
    the random numbers that drive noise and tremor.
    """
    lag, ring = exp(-2 * pi * _VALUE["noise.corner"] * dt), exp(-pi * _VALUE["tremor.width"] * dt)
    turn = 2 * pi * _VALUE["tremor.center"] * dt
    return np.array([lag, ring, cos(turn), sin(turn), sqrt(1 - lag**2), sqrt(1 - ring**2)])
