"""Policies by name."""

from pathlib import Path

from ...assets import load_suit
from ...errors import unknown_name
from ..arm_env import ArmEnv
from .base import Policy
from .feedforward import HysteresisFeedforward
from .gravity import GravityCompensation
from .no_assist import NoAssist
from .oracle import Oracle
from .trained import TrainedPolicy

POLICIES = ("none", "gravity", "feedforward", "oracle")


def make_policy(name: str, env: ArmEnv, *, believed_suit: str | None = None) -> Policy:
    """Returns a policy for `env`.

    Args:
        name: "none", "gravity", "feedforward", "oracle", or the folder of a training run.
        env: the (unwrapped) environment it will act in.
        believed_suit: name or file of the suit that "feedforward" believes in; by default the
            simulated one.

    Raises:
        InputError: there is no such policy or folder.
    """
    simple = {"none": NoAssist, "gravity": GravityCompensation, "oracle": Oracle}
    if name in simple:
        return simple[name](env)
    if name == "feedforward":
        return HysteresisFeedforward(env, load_suit(believed_suit or env.config.suit))
    if not Path(name).is_dir():
        raise unknown_name("policy", name, (*POLICIES, "the folder of a training run"))
    return TrainedPolicy(name, env.observation_space.shape[0])  # type: ignore[index]
