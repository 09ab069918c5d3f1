"""Gives policies the observations that a test chooses."""

from typing import Any

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.policies import Policy, make_policy, needed_options


def made(name: str, **options: Any) -> tuple[Policy, ArmEnv]:
    """Returns a policy and an arm in which it can act."""
    env = ArmEnv(**{**needed_options(name), **options})
    policy = make_policy(name, env)
    policy.reset()
    return policy, env


def asked(policy: Policy, env: ArmEnv, **parts: Any) -> np.ndarray:
    """Returns the torque [N·m] that a policy gives for parts of an observation; others are 0."""
    observation = np.zeros(env.observation_space.shape, np.float32)
    for name, part in parts.items():
        observation[env.layout[name]] = part
    return policy.act(observation) * env.episodes.simulation.addresses.peak_torque
