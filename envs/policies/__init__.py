"""Assist policies: each turns an observation into an action."""

from ..belief import Belief, BelievedArm, BelievedSuit, BelievedWeight
from .base import Policy, Seen, TorquePolicy
from .build import POLICIES, AnyPolicy, PolicySpec, make_policy, needed_options, policy_spec
from .compensation import Compensation, Complement
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .model_based import ModelBased
from .momentum_observer import MomentumObserver
from .network import Network
from .no_assist import NoAssist
from .oracle import Oracle
from .saving import save_policy
from .trained import environment_of
from .transparent import Transparent

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
    "ModelBased",
    "MomentumObserver",
    "Network",
    "NoAssist",
    "Oracle",
    "Policy",
    "PolicySpec",
    "Seen",
    "TorquePolicy",
    "Transparent",
    "environment_of",
    "make_policy",
    "needed_options",
    "policy_spec",
    "save_policy",
]
