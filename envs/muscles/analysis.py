"""Muscles along one motion: which activations give the wearer's torque, under a convention.

What a study says about muscles depends on choices that no measurement of a suit settles. Each is a
convention here, and scores come with the range over them:

- `standard`: active forces give the wearer's torque and what inverse dynamics asks for about the
  other three axes; the muscles that pull against each joint's torque give at least the
  co-contraction of the wearer's model;
- `relaxed`: the same without co-contraction;
- `rotation free`: nothing is asked for about the shoulder's third axis;
- `passive forces`: the muscles' passive forces replace the elasticity of our joints;
- `least activation`: no muscle is below 1 %;
- `cubes`, `volume`: the sum of a³, or of a times the muscle's volume, is least instead of that
  of a²;
- `Bhargava 2004`: metabolic power by that model.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ..evaluation.rollout import Trace
from ..extras import STANDARD
from ..person import Person, isometric_strength, passive_torque, strength_limits
from ..simulation.inverse_dynamics import Chain
from ..simulation.simulation import Simulation
from .mapping import AXES, OWN, THIRD, constraint_torques
from .metabolic import MODELS, muscle_masses
from .myoarm import Geometry, MyoArm
from .sharing import Cost, share

SOFTNESS = 0.01  # [N²·m²], see `Cost`
LINEAR = 0.05  # coefficient of a² beside that of a times volume, and of a² beside that of a³
ALIKE = 1e-6  # relative difference of strengths that counts as none


@dataclass(frozen=True, kw_only=True)
class Convention:
    """Choices in sharing torque among muscles.

    Attributes:
        cost: What is least: "squares", "cubes" or "volume".
        contraction: Whether antagonists contract as the wearer's model says.
        third: Whether inverse dynamics sets the torque about the shoulder's third axis.
        passive: Whether the muscles' passive forces replace the elasticity of our joints.
        least: Least activation of all muscles.
        metabolic: Model of metabolic power.
    """

    cost: str = "squares"
    contraction: bool = True
    third: bool = True
    passive: bool = False
    least: float = 0.0
    metabolic: str = "Umberger 2010"


CONVENTIONS: dict[str, Convention] = {
    STANDARD: Convention(),
    "relaxed": Convention(contraction=False),
    "rotation free": Convention(third=False),
    "passive forces": Convention(passive=True),
    "least activation": Convention(least=0.01),
    "cubes": Convention(cost="cubes"),
    "volume": Convention(cost="volume"),
    "Bhargava 2004": Convention(metabolic="Bhargava 2004"),
}
"""Conventions by name, the standard one first."""


class Demand(NamedTuple):
    """What a motion asks of the wearer's muscles.

    Attributes:
        scale: Strength of the wearer over that of the average man.
        torque: The wearer's torque, and that of inverse dynamics about the other axes [N·m], shape
            (samples, 7).
        elastic: Torque of the relaxed joints of our arm [N·m], shape (samples, 4).
        contraction: Torque with which the muscles of each joint oppose each other [N·m], shape
            (samples, 4).
        geometry: The muscles of the average man along the motion.
        dt: Time between samples [s].
    """

    scale: float
    torque: Array
    elastic: Array
    contraction: Array
    geometry: Geometry
    dt: float

    def last(self) -> "Demand":
        """Returns what the last sample asks."""
        series = {name: getattr(self, name)[-1:] for name in ("torque", "elastic", "contraction")}
        return self._replace(**series, geometry=Geometry(*(one[-1:] for one in self.geometry)))


class Moments(NamedTuple):
    """Some moments of a motion, with the series of a `Trace` that muscles need."""

    time: Array
    angle: Array
    rate: Array
    human_torque: Array
    effort: Array
    strength: Array
    fatigue: Array | None
    dressed: Chain


class Shared(NamedTuple):
    """The muscles of one motion under one convention.

    Attributes:
        activation: Activations, shape (samples, muscles).
        power: Metabolic power of each muscle [W], shape (samples, muscles).
        reserve: Torque that muscles do not give [N·m], shape (samples, axes).
    """

    activation: Array
    power: Array
    reserve: Array


def check_wearer(simulation: Simulation) -> None:
    """Checks, before anything moves, that muscles can give the wearer's torque."""
    MyoArm.load()
    if simulation.fatigue:
        raise InputError(
            "muscles need a wearer who does not tire, since MyoArm is scaled by one factor: "
            "choose another task, or set fatigue=false"
        )


def demand_of(trace: Trace | Moments, arm: MyoArm, *, threads: int = 0) -> Demand:
    """Returns what a motion, or some moments of one, asks of the wearer's muscles."""
    if len(trace.time) < 3:
        raise InputError(
            f"a motion has {len(trace.time)} samples: muscles need 3 or more, for accelerations"
        )
    low, high = strength_limits(_average(), trace.angle, np.zeros_like(trace.angle))
    ratio = trace.strength / np.stack([-low, high], axis=1)
    if trace.fatigue is not None or ratio.max() > (1 + ALIKE) * ratio.min():
        raise InputError(
            f"the strength of this wearer is from {ratio.min():.2f} to {ratio.max():.2f} of the "
            "average man's, joint by joint and over time, and MyoArm is scaled by one factor: "
            "leave fatigue out"
        )
    scale = float(ratio.mean())
    pull = np.stack([-trace.human_torque, trace.human_torque], axis=1)
    beyond = trace.effort[:, None] * trace.strength - np.maximum(pull, 0)  # the net torque
    dt = float(trace.time[1] - trace.time[0])
    acceleration = np.gradient(trace.rate, dt, axis=0)
    torque, _ = constraint_torques(trace.dressed, trace.angle, trace.rate, acceleration)
    torque[:, OWN] = trace.human_torque
    return Demand(
        scale=scale,
        torque=torque,
        elastic=passive_torque(scale * _average(), trace.angle, np.zeros_like(trace.rate)),
        contraction=np.maximum(beyond.min(axis=1), 0),
        geometry=arm.geometry(trace.angle, trace.rate, threads=threads),
        dt=dt,
    )


def share_among_muscles(
    arm: MyoArm, demand: Demand, convention: Convention, *, before: Array | None = None
) -> Shared:
    """Returns activations, metabolic power and reserve torques of a motion.

    Args:
        arm: The muscles of the average man.
        demand: What the motion asks of the muscles.
        convention: Choices in sharing the torque.
        before: Activations a period before the motion, shape (muscles,); by default any.
    """
    geometry = demand.geometry
    wanted = demand.torque / demand.scale
    if convention.passive:
        slack = np.einsum("nkm,nm->nk", geometry.arms, geometry.passive)
        wanted[:, OWN] += demand.elastic / demand.scale - slack[:, OWN]
        wanted[:, THIRD] -= slack[:, THIRD]
    axes = [axis for axis in range(len(AXES)) if convention.third or axis != THIRD]
    arms, equal = geometry.arms[:, axes], len(axes)
    wanted = wanted[:, axes]
    if convention.contraction:
        against = antagonists(geometry.arms[:, OWN], demand.torque[:, OWN])
        arms = np.concatenate([arms, against], axis=1)
        wanted = np.concatenate([wanted, demand.contraction / demand.scale], axis=1)
    known = np.full(arms.shape[2], np.nan) if before is None else before
    flat = (arms, geometry.full, wanted, equal, convention.least, known, demand.dt)
    activation, reserve, _ = share(*flat, _cost(convention.cost, arm))
    power = MODELS[convention.metabolic](arm, geometry, activation)
    return Shared(activation, demand.scale * power, demand.scale * reserve[:, :equal])


def muscle_activation(trace: Trace, convention: str = STANDARD) -> Array:
    """Returns the activations of a motion, shape (samples, muscles), as `MyoArm.muscles` orders."""
    arm = MyoArm.load()
    return share_among_muscles(arm, demand_of(trace, arm), CONVENTIONS[convention]).activation


def _cost(name: str, arm: MyoArm) -> Cost:
    """Returns what is least; beside cube or volume a small square makes the answer unique."""
    mass = muscle_masses(arm)
    linear = mass / mass.mean() * (name == "volume")
    square, cubic = (1.0, 0.0) if name == "squares" else (LINEAR, float(name == "cubes"))
    return Cost(linear, square, cubic, SOFTNESS)


def antagonists(arms: Array, torque: Array) -> Array:
    """Returns the moment arms of the muscles that pull against torques, as positive numbers [m].

    Moment arms [m] have the shape (samples, axes, muscles), torques [N·m] (samples, axes).
    """
    return np.maximum(np.where(torque[..., None] < 0, arms, -arms), 0)


def _average() -> Array:
    return isometric_strength(Person.percentile("male", 50))
