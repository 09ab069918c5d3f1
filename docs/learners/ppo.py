"""PPO in pure torch on rows of arms: prints the mean reward, and saves a policy for NumPy."""

import gymnasium
import numpy as np
import torch
from activesuit.envs.policies import save_policy
from torch import nn
from torch.distributions import Normal

UPDATES, ROWS, PERIODS = 245, 64, 64  # a million steps
EPOCHS, BATCH, RATE = 10, 512, 7e-4
GAMMA, LAMBDA, CLIP = 0.9, 0.9, 0.2  # effort answers an action within 0.1 s: a short horizon

torch.manual_seed(0)
torch.set_num_threads(1)  # more threads cost time with networks of this size


def network(size, outputs, gain):
    """Returns two hidden layers and one whose weights begin as small as the gain."""
    layers = [nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs)]
    for layer, scale in zip(layers[::2], (2**0.5, 2**0.5, gain), strict=True):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


arms = gymnasium.make_vec(
    "ActiveSuit/ElbowFlexion-v0",
    ROWS,
    autoreset_mode="SameStep",  # a row begins its next episode in the step that ends one
    stagger=True,  # so that the episodes of the rows do not all end together
    normalize=True,
)
size, motors = arms.single_observation_space.shape[0], arms.single_action_space.shape[0]
actor, critic = network(size, motors, 0.01), network(size, 1, 1.0)
log_std = nn.Parameter(torch.full((motors,), -2.5))  # small, as the reward counts changes of action
parameters = [*actor.parameters(), *critic.parameters(), log_std]
optimizer = torch.optim.Adam(parameters, RATE, eps=1e-5)


def collect(seen):
    """Returns what the rows did in some control periods, and what they observe then."""
    kept = []
    for _ in range(PERIODS):
        with torch.no_grad():
            distribution = Normal(actor(seen), log_std.exp())
            action = distribution.sample()
            log_prob = distribution.log_prob(action).sum(-1)
        observation, reward, terminated, truncated, info = arms.step(action.numpy())
        ended, after = terminated | truncated, observation.copy()
        if ended.any():  # what follows the action is the end of its own episode, not the next one
            after[ended] = np.stack(info["final_obs"][ended])
        arrays = (np.float32(reward), after, np.float32(terminated), np.float32(ended))
        kept.append((seen, action, log_prob, *map(torch.as_tensor, arrays)))
        seen = torch.as_tensor(observation)
    return seen, [torch.stack(one) for one in zip(*kept, strict=True)]


def advantages(seen, reward, after, terminated, ended):
    """Returns advantages by GAE, and the returns; only a lost arm has no value after its end."""
    with torch.no_grad():
        value, next_value = critic(seen)[..., 0], critic(after)[..., 0]
    surprise = reward + GAMMA * (1 - terminated) * next_value - value
    advantage, later = torch.zeros_like(value), 0.0
    for i in reversed(range(PERIODS)):
        advantage[i] = later = surprise[i] + GAMMA * LAMBDA * (1 - ended[i]) * later
    return advantage, advantage + value


def improve(seen, action, log_prob, advantage, target):
    """Changes actor and critic by PPO; each argument has a row for each step."""
    for chosen in (part for _ in range(EPOCHS) for part in torch.randperm(len(seen)).split(BATCH)):
        gain = advantage[chosen]
        gain = (gain - gain.mean()) / (gain.std() + 1e-8)
        distribution = Normal(actor(seen[chosen]), log_std.exp())
        ratio = (distribution.log_prob(action[chosen]).sum(-1) - log_prob[chosen]).exp()
        actor_loss = -torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
        critic_loss = (critic(seen[chosen])[..., 0] - target[chosen]).square().mean()
        optimizer.zero_grad()
        (actor_loss + 0.5 * critic_loss).backward()
        nn.utils.clip_grad_norm_(parameters, 0.5)
        optimizer.step()


observation, _ = arms.reset(seed=0)
seen = torch.as_tensor(observation)
for update in range(1, UPDATES + 1):
    seen, (before, action, log_prob, reward, after, terminated, ended) = collect(seen)
    advantage, target = advantages(before, reward, after, terminated, ended)
    steps = (before, action, log_prob, advantage, target)
    improve(*(one.flatten(0, 1) for one in steps))
    if update % 61 == 1:
        print(f"{update * ROWS * PERIODS:>7} steps: mean reward {reward.mean():.3f}")

save_policy(actor, "my-ppo", arms)
