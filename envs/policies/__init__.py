"""Assist policies: each turns an observation into an action."""

from ..belief import Belief, BelievedArm, BelievedSuit, BelievedWeight
from .base import Policy, Seen, TorquePolicy
from .model_based import (
    Compensation,
    Complement,
    GravityCompensation,
    HysteresisFeedforward,
    ModelBased,
    NoAssist,
    Oracle,
    Transparent,
)
from .network import Network
from .observers import MomentumObserver
from .registry import POLICIES, make_policy, needed_options, policy_spec
from .saving import save_policy
from .spec import AnyPolicy, PolicySpec
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
