"""What a controller believes of the arm: the suit's torque, weight, inertia and levers."""

from .arm import Belief, BelievedArm
from .rigid import BelievedWeight, CuffLevers
from .suit import LEAD, BelievedSuit, JointBelief, belief_of

__all__ = [
    "LEAD",
    "Belief",
    "BelievedArm",
    "BelievedSuit",
    "BelievedWeight",
    "CuffLevers",
    "JointBelief",
    "belief_of",
]
