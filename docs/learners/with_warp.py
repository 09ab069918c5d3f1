"""PPO in torch on thousands of suited arms in MuJoCo Warp: motors learn to spare the wearer."""

import mujoco_warp as mjw
import numpy as np
import torch
import warp as wp
from activesuit.envs.model import ArmConfig, for_warp, resisting_joints
from activesuit.hysteresis.warp import attach
from torch import nn
from torch.distributions import Normal

ON_GPU = wp.is_cuda_available()
WORLDS, UPDATES = (4096, 150) if ON_GPU else (64, 50)
PERIODS, SUBSTEPS, LENGTH = 32, 5, 4.0  # control periods of 10 ms; length of an episode [s]
EPOCHS, PARTS, RATE, GAMMA, LAMBDA, CLIP = 5, 4, 1e-3, 0.9, 0.9, 0.2
PEAK = (40.0, 25.0)  # N·m, of the motors
STRENGTH = (60.0, 70.0, 55.0, 12.0)  # N·m, round numbers, assumed
MIDDLE, REACH = (0.2, 0.7, 1.0, 0.0), (0.1, 0.4, 0.5, 0.1)  # rad, of the wearer's motion

device = "cuda" if ON_GPU else "cpu"
torch.manual_seed(0)
torch.set_num_threads(1)
if ON_GPU:  # torch and Warp take turns in one stream, and not the default one, for the graph
    torch.cuda.set_stream(torch.cuda.Stream())
    wp.set_stream(wp.stream_from_torch(torch.cuda.current_stream()))

config, rng = ArmConfig(gravity="microgravity"), np.random.default_rng(0)
mjm, joints = for_warp(config), resisting_joints(config)
m, d = mjw.put_model(mjm), mjw.make_data(mjm, nworld=WORLDS, nconmax=8, njmax=16)
scales = rng.uniform(0.8, 1.2, WORLDS)  # each world has a suit of its own stiffness
models = {name: [one.model.scaled(torque=k) for k in scales] for name, one in joints.items()}
starts = {
    name: [model.start(one.start_angle) for model in models[name]] for name, one in joints.items()
}
suit = attach(m, d, mjm, models, starts=starts)
time, ctrl, qpos, qvel = map(wp.to_torch, (d.time, d.ctrl, d.qpos, d.qvel))  # views
force = wp.to_torch(d.actuator_force)
stiffness, damping, peak, strength, middle, reach = (
    torch.tensor(np.array(one), dtype=torch.float32, device=device)
    for one in (*-mjm.actuator_biasprm[:4, 1:3].T, PEAK, STRENGTH, MIDDLE, REACH)
)
rates, phases = torch.rand((2, WORLDS, 4), device=device)
rates, phases = 1.5 + 2.5 * rates, 6.28 * phases  # of the wearer's motion [rad/s], [rad]
begun = LENGTH * torch.rand(WORLDS, device=device)  # so that not all episodes end together
graph = None


def physics():
    """Steps all worlds through a control period."""
    for _ in range(SUBSTEPS):
        mjw.step(m, d)


def period(action):
    """Returns what follows an action: observation, reward, effort and which episodes ended."""
    angle = rates * time[:, None] + phases
    ctrl[:, :4] = stiffness * (middle + reach * angle.sin()) + damping * reach * rates * angle.cos()
    ctrl[:, 4:] = action.clamp(-1, 1) * peak
    physics() if graph is None else wp.capture_launch(graph)
    effort = (force[:, :4] / strength).square().mean(-1)
    ended = time + begun > LENGTH
    if ended.any():  # the hysteresis begins again by itself, since the time goes back
        mjw.reset_data(m, d, wp.from_torch(ended))
        begun[ended] = 0.0
        qpos[ended] = (middle + reach * phases.sin())[ended]
    return observed(action), 0.1 - 10 * effort, effort.sqrt(), ended


def observed(action):
    """Returns what encoders measure, and the last action."""
    return torch.cat([qpos[:, 1:3], 0.2 * qvel[:, 1:3], action.clamp(-1, 1)], -1)


def network(outputs):
    """Returns two hidden layers and one whose weights begin small."""
    layers = [nn.Linear(6, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs)]
    layers[-1].weight.data *= 0.1
    return nn.Sequential(*layers).to(device)


actor, critic = network(2), network(1)
log_std = nn.Parameter(torch.full((2,), -2.5, device=device))
parameters = [*actor.parameters(), *critic.parameters(), log_std]
optimizer = torch.optim.Adam(parameters, RATE)
physics()  # compiles
if ON_GPU:
    with wp.ScopedCapture() as capture:
        physics()
    graph = capture.graph
nothing = torch.zeros((WORLDS, 2), device=device)
seen = observed(nothing)
for update in range(UPDATES):
    kept = []
    for _ in range(PERIODS):
        with torch.no_grad():
            policy = Normal(actor(seen), log_std.exp())
            action = policy.sample()
            after, reward, effort, ended = period(action)
            value, following = critic(seen)[:, 0], critic(after)[:, 0]
            surprise = reward + GAMMA * following * ~ended - value
            log_prob = policy.log_prob(action).sum(-1)
            kept.append((seen, action, log_prob, value, surprise, ended, effort))
            seen = after
    before, action, log_prob, value, surprise, ended, effort = map(
        torch.stack, zip(*kept, strict=True)
    )
    if update % 10 == 0:
        print(
            f"{update * WORLDS * PERIODS:>9} steps: effort {100 * effort.mean():.2f} %", flush=True
        )
    advantage, later = torch.zeros_like(value), 0.0
    for i in reversed(range(PERIODS)):
        advantage[i] = later = surprise[i] + GAMMA * LAMBDA * ~ended[i] * later
    steps = [one.flatten(0, 1) for one in (before, action, log_prob, advantage, advantage + value)]
    for _ in range(EPOCHS):
        for chosen in torch.randperm(WORLDS * PERIODS, device=device).chunk(PARTS):
            before, action, log_prob, gain, target = (one[chosen] for one in steps)
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            policy = Normal(actor(before), log_std.exp())
            ratio = (policy.log_prob(action).sum(-1) - log_prob).exp()
            loss = -torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
            loss = loss + 0.5 * (critic(before)[:, 0] - target).square().mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(parameters, 0.5)
            optimizer.step()


@torch.no_grad()
def mean_effort(act):
    """Returns the mean effort of episodes of all worlds, without their first second."""
    begun.fill_(LENGTH)
    action, efforts = nothing, []
    for _ in range(int(100 * LENGTH) - 1):
        after, _, effort, _ = period(action)
        action = act(after)
        efforts.append(effort.mean())
    return float(torch.stack(efforts[100:]).mean())


off, on = mean_effort(lambda _: nothing), mean_effort(actor)
print(f"effort with motors off {100 * off:.2f} %, with the policy {100 * on:.2f} %")
