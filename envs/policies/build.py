"""Makes policies by name."""

import os

import gymnasium

from ...assets import AnySuit, load_suit
from ...errors import InputError, unknown_name
from ..arm_env import ArmEnv
from ..model import resisting_joints
from .base import Policy
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .no_assist import NoAssist
from .oracle import Oracle
from .trained import TrainedPolicy

POLICIES = ("none", "gravity", "feedforward", "oracle")


def make_policy(name: str, env: gymnasium.Env, *, believed_suit: AnySuit | None = None) -> Policy:
    """Returns a policy for an ActiveSuit environment.

    Args:
        name: Name of the policy ("none", "gravity", "feedforward" or "oracle"), or the folder of a
            training run.
        env: Environment in which the policy will act, wrapped or not.
        believed_suit: Suit that "feedforward" believes in: its name or file, or what else
            `load_suit` takes; by default the simulated one, at its pressure.

    Raises:
        InputError: There is no such policy or folder, or the environment has no motors.
    """
    arm = env.unwrapped
    if not isinstance(arm, ArmEnv):
        raise InputError(f"{arm} is no ActiveSuit environment: make one of ActiveSuit/...")
    if name != "none" and not arm.wiring.motors.size:
        raise InputError(
            f"policy {name!r} needs motors, and coupling is 'none': use 'rigid' or 'cuffs', or the "
            "policy 'none'"
        )
    simple = {"none": NoAssist, "gravity": GravityCompensation, "oracle": Oracle}
    if name in simple:
        return simple[name](arm)
    if name == "feedforward":
        if believed_suit is None:
            return HysteresisFeedforward(arm, resisting_joints(arm.config))
        return HysteresisFeedforward(arm, load_suit(believed_suit).joints)
    if not os.path.isdir(name):  # a name may be too long for a path
        raise unknown_name("policy", name, (*POLICIES, "the folder of a training run"))
    return TrainedPolicy(name, arm)
