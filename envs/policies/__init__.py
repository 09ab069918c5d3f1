"""Assist policies: each turns an observation into an action."""

from ..belief import Belief, BelievedArm, BelievedSuit, BelievedWeight
from .base import Policy, TorquePolicy
from .build import POLICIES, AnyPolicy, PolicySpec, make_policy, needed_options, policy_spec
from .compensation import Compensation, Complement
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .momentum_observer import MomentumObserver
from .network import Network
from .no_assist import NoAssist
from .oracle import Oracle
from .saving import save_policy
from .trained import environment_of

__all__ = [
    "POLICIES",
    "AnyPolicy",
    "Belief",
    "BelievedArm",
    "BelievedSuit",
    "BelievedWeight",
    "Compensation",
    "Complement",
    "GravityCompensation",
    "HysteresisFeedforward",
    "MomentumObserver",
    "Network",
    "NoAssist",
    "Oracle",
    "Policy",
    "PolicySpec",
    "TorquePolicy",
    "environment_of",
    "make_policy",
    "needed_options",
    "policy_spec",
    "save_policy",
]
