"""Makes policies by name."""

import os
from typing import Any

from ...assets import AnySuit, load_suit
from ...errors import InputError, unknown_name
from ..arm_env import ArmEnv
from ..model import resisting_joints
from ..vector_env import ArmVectorEnv
from .base import Policy
from .compensation import Compensation, Complement
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .no_assist import NoAssist
from .oracle import Oracle
from .trained import TrainedPolicy
from .transparent import Transparent

SIMPLE = {
    "none": NoAssist,
    "transparent": Transparent,
    "gravity": GravityCompensation,
    "oracle": Oracle,
}
BELIEVING = {
    "feedforward": HysteresisFeedforward,
    "complement": Complement,
    "compensation": Compensation,
}
SHIPPED = {**SIMPLE, **BELIEVING}
POLICIES = ("none", "transparent", "gravity", "feedforward", "complement", "compensation", "oracle")


def needed_options(name: str) -> dict[str, Any]:
    """Returns the options of an environment in which a policy can act.

    Args:
        name: Name of a policy, which needs its sensor suites in their units; or the folder of a
            training run, which was trained with those that its environment has by itself.

    Raises:
        InputError: There is no such policy or folder.
    """
    if name in SHIPPED:
        return {"sensors": SHIPPED[name].sensors, "normalize": False, "history": 1}
    _check_folder(name)
    return {}


def make_policy(
    name: str, env: ArmEnv | ArmVectorEnv, *, believed_suit: AnySuit | None = None
) -> Policy:
    """Returns a policy for an ActiveSuit environment.

    Args:
        name: Name of the policy, one of `POLICIES`, or the folder of a training run.
        env: Environment in which the policy will act, single or vector, wrapped or not.
        believed_suit: Suit that the policies with a model of it believe in: its name or file, or
            what else `load_suit` takes; by default the simulated one, at its pressure.

    Raises:
        InputError: There is no such policy or folder, or the environment has no motors or not the
            sensors that the policy needs.
    """
    arm = env.unwrapped
    if not isinstance(arm, ArmEnv | ArmVectorEnv):
        raise InputError(f"{arm} is no ActiveSuit environment: make one of ActiveSuit/...")
    episodes, needed = arm.episodes, needed_options(name).get("sensors", ())
    if name != "none" and not episodes.motors:
        raise InputError(
            f"policy {name!r} needs motors, and coupling is 'none': use 'rigid' or 'cuffs', or the "
            "policy 'none'"
        )
    if set(needed) - set(episodes.observer.sensors):
        raise InputError(
            f"policy {name!r} needs the sensors {', '.join(needed)}, and the environment has "
            f"{', '.join(episodes.observer.sensors)}: make it with sensors={list(needed)}"
        )
    if name in SHIPPED and name != "none" and episodes.observer.normalized:
        raise InputError(
            f"policy {name!r} reads angles in rad, and the environment has normalize=True: make it "
            "without"
        )
    if name in SIMPLE:
        return SIMPLE[name](arm)
    if name in BELIEVING:
        config = episodes.simulation.config
        own = believed_suit is None
        return BELIEVING[name](
            arm, resisting_joints(config) if own else load_suit(believed_suit).joints
        )
    return TrainedPolicy(name, arm)


def _check_folder(name: str) -> None:
    if not os.path.isdir(name):  # a name may be too long for a path
        raise unknown_name("policy", name, (*POLICIES, "the folder of a training run"))
