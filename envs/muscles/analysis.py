"""Muscles along one motion: which activations give the wearer's torque, under a convention.

The results of a study of muscles depend on choices that no measurement of a suit settles. Each
choice is a convention here, and scores come with their range over all conventions:

- `standard`: active forces give the wearer's torque and the torque of inverse dynamics about the
  other three axes; the muscles that pull against each joint's torque give at least the
  co-contraction of the wearer's model;
- `relaxed`: the same without co-contraction;
- `rotation free`: the torque about the shoulder's third axis is free;
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
LINEAR = 0.05  # coefficient of a² where the cost is volume or a³
ALIKE = 1e-6  # relative difference of strengths that counts as none


@dataclass(frozen=True, kw_only=True)
class Convention:
    """Choices in sharing torque among muscles."""

    cost: str = "squares"  # the cost that is minimized: "squares", "cubes" or "volume"
    contraction: bool = True  # whether antagonists contract as the wearer's model says
    third: bool = True  # whether inverse dynamics sets the torque about the shoulder's third axis
    passive: bool = False  # whether passive forces of muscles replace the elasticity of our joints
    least: float = 0.0  # least activation of all muscles
    metabolic: str = "Umberger 2010"  # model of metabolic power


RELAXED = "relaxed"  # the convention without co-contraction
CONVENTIONS: dict[str, Convention] = {
    STANDARD: Convention(),
    RELAXED: Convention(contraction=False),
    "rotation free": Convention(third=False),
    "passive forces": Convention(passive=True),
    "least activation": Convention(least=0.01),
    "cubes": Convention(cost="cubes"),
    "volume": Convention(cost="volume"),
    "Bhargava 2004": Convention(metabolic="Bhargava 2004"),
}
"""Conventions by name, the standard one first."""


class Demand(NamedTuple):
    """The torques that a motion demands of the wearer's muscles."""

    scale: float  # strength of the wearer over that of the average man
    torque: Array  # the wearer's, and inverse dynamics' about the other axes [N·m], (samples, 7)
    elastic: Array  # torque of the relaxed joints of our arm [N·m], (samples, 4)
    contraction: Array  # torque of the antagonists of each joint [N·m], (samples, 4)
    geometry: Geometry  # the muscles of the average man along the motion
    dt: float  # time between samples [s]

    def last(self) -> "Demand":
        """Returns the demand of the last sample."""
        series = {name: getattr(self, name)[-1:] for name in ("torque", "elastic", "contraction")}
        return self._replace(**series, geometry=Geometry(*(one[-1:] for one in self.geometry)))


class Moments(NamedTuple):
    """Successive samples of a motion, with the series of a `Trace` that muscles need."""

    time: Array
    angle: Array
    rate: Array
    human_torque: Array
    effort: Array
    strength: Array
    fatigue: Array | None
    dressed: Chain


class Shared(NamedTuple):
    """The muscles of one motion under one convention."""

    activation: Array  # shape (samples, muscles)
    power: Array  # metabolic power of each muscle [W], shape (samples, muscles)
    reserve: Array  # torque that the muscles cannot give [N·m], shape (samples, axes)


def check_wearer(simulation: Simulation) -> None:
    """Checks, before the simulation starts, that muscles can give the wearer's torque."""
    MyoArm.load()
    if simulation.fatigue:
        raise InputError(
            "muscles need a wearer who does not tire, since MyoArm is scaled by one factor: "
            "choose another task, or set fatigue=false"
        )


def demand_of(trace: Trace | Moments, arm: MyoArm, *, threads: int = 0) -> Demand:
    """Returns the torques that a motion, or a part of a motion, demands of the muscles."""
    if len(trace.time) < 3:
        raise InputError(
            f"a motion has {len(trace.time)} samples: muscles need 3 or more, for accelerations"
        )
    low, high = strength_limits(_average(), trace.angle, np.zeros_like(trace.angle))
    ratio = trace.strength / np.stack([-low, high], axis=1)
    if trace.fatigue is not None or ratio.max() > (1 + ALIKE) * ratio.min():
        raise InputError(
            f"the strength of this wearer is from {ratio.min():.2f} to {ratio.max():.2f} of the "
            "average man's over joints and time, and MyoArm is scaled by one factor: leave "
            "fatigue out"
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

    `before` are the activations one period before the motion, shape (muscles,); without `before`
    the motion may begin with any activations.
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


def muscle_activation(trace: Trace) -> Array:
    """Returns the activations of a motion, shape (samples, muscles), in `MyoArm.muscles`' order."""
    arm = MyoArm.load()
    return share_among_muscles(arm, demand_of(trace, arm), CONVENTIONS[STANDARD]).activation


def _cost(name: str, arm: MyoArm) -> Cost:
    """Returns the cost of a name; a small square makes the minimum of the other costs unique."""
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
