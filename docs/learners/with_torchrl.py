"""PPO of TorchRL on rows of arms: prints the mean reward, and saves a policy for NumPy."""

import gymnasium
import torch
from activesuit.envs.policies import save_policy
from tensordict.nn import AddStateIndependentNormalScale, TensorDictModule
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs import GymWrapper
from torchrl.modules import IndependentNormal, ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

UPDATES, ROWS, PERIODS = 245, 64, 64  # a million steps
EPOCHS, BATCH = 10, 512

torch.manual_seed(0)
torch.set_num_threads(1)
arms = gymnasium.make_vec(
    "ActiveSuit/ElbowFlexion-v0",
    ROWS,
    autoreset_mode="Disabled",  # TorchRL resets the rows whose episodes have ended
    stagger=True,
    normalize=True,
)
size, motors = arms.single_observation_space.shape[0], arms.single_action_space.shape[0]


def network(outputs, gain):
    """Returns two hidden layers and one whose weights begin as small as the gain."""
    layers = [nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs)]
    for layer, scale in zip(layers[::2], (2**0.5, 2**0.5, gain), strict=True):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


mean = network(motors, 0.01)
scale = AddStateIndependentNormalScale(motors, scale_mapping="exp")
nn.init.constant_(scale.state_independent_scale, -2.5)
actor = ProbabilisticActor(
    TensorDictModule(nn.Sequential(mean, scale), ["observation"], ["loc", "scale"]),
    in_keys=["loc", "scale"],
    distribution_class=IndependentNormal,
    return_log_prob=True,
)
critic = ValueOperator(network(1, 1.0))
advantage = GAE(gamma=0.9, lmbda=0.9, value_network=critic)
loss = ClipPPOLoss(
    actor,
    critic,
    entropy_bonus=False,
    critic_coeff=0.5,
    loss_critic_type="l2",
    normalize_advantage=True,
)
optimizer = torch.optim.Adam(loss.parameters(), 7e-4, eps=1e-5)

env = GymWrapper(arms)
env.set_seed(0)
collector = Collector(
    env,
    actor,
    frames_per_batch=ROWS * PERIODS,
    total_frames=UPDATES * ROWS * PERIODS,
    auto_register_policy_transforms=False,  # for networks with memory
)
for update, data in enumerate(collector, 1):
    advantage(data)
    steps = data.reshape(-1)
    for _ in range(EPOCHS):
        for chosen in torch.randperm(len(steps)).split(BATCH):
            losses = loss(steps[chosen])
            optimizer.zero_grad()
            (losses["loss_objective"] + losses["loss_critic"]).backward()
            nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimizer.step()
    if update % 61 == 1:
        print(
            f"{update * ROWS * PERIODS:>7} steps: mean reward {data['next', 'reward'].mean():.3f}"
        )
collector.shutdown()

save_policy(mean, "my-torchrl", arms)
