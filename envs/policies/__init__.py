"""Assist policies: each turns an observation into an action."""

from .base import Policy
from .build import POLICIES, make_policy, needed_options
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .no_assist import NoAssist
from .oracle import Oracle
from .trained import TrainedPolicy

__all__ = [
    "POLICIES",
    "GravityCompensation",
    "HysteresisFeedforward",
    "NoAssist",
    "Oracle",
    "Policy",
    "TrainedPolicy",
    "make_policy",
    "needed_options",
]
