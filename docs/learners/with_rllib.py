"""PPO of RLlib: two processes with 32 rows of arms each; saves a policy for NumPy."""

import gymnasium
import numpy as np
from activesuit.envs.policies import save_policy
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from torch import nn

UPDATES, ROWS, PERIODS = 245, 64, 64  # a million steps
TASK = "activesuit:ActiveSuit/ElbowFlexion-v0"  # each process imports the package before the colon
OPTIONS = {"normalize": True, "stagger": True}


class GentleStart(DefaultPPOTorchRLModule):
    """RLlib's network with a small exploration, as the reward counts changes of the action."""

    def setup(self):
        """Builds the network."""
        super().setup()
        nn.init.constant_(self.pi.log_std, -2.5)
        nn.init.zeros_(self.pi.net.mlp[-1].weight)


config = (
    PPOConfig()
    .environment(TASK, env_config=OPTIONS)
    .env_runners(
        num_env_runners=2,
        num_envs_per_env_runner=ROWS // 2,
        gym_env_vectorize_mode="vector_entry_point",  # rows of arms, not single environments
        rollout_fragment_length=PERIODS,
    )
    .training(
        gamma=0.9,
        lambda_=0.9,
        lr=7e-4,
        clip_param=0.2,
        grad_clip=0.5,
        use_kl_loss=False,
        vf_loss_coeff=0.5,
        train_batch_size_per_learner=ROWS * PERIODS,
        minibatch_size=512,
        num_epochs=10,
    )
    .rl_module(
        rl_module_spec=RLModuleSpec(
            module_class=GentleStart,
            model_config=DefaultModelConfig(
                fcnet_hiddens=[64, 64], free_log_std=True, vf_share_layers=False
            ),
        )
    )
    .debugging(seed=0)
)
algorithm, rewards = config.build_algo(), []
for update in range(1, UPDATES + 1):
    ended = algorithm.train()["env_runners"]  # of the episodes that ended, if any did
    rewards.append(ended["episode_return_mean"] / ended["episode_len_mean"])
    if update % 61 == 1:
        print(f"{update * ROWS * PERIODS:>7} steps: mean reward {np.nanmean(rewards):.3f}")
        rewards.clear()

module = algorithm.get_module()
actor = nn.Sequential(*module.encoder.actor_encoder.net.mlp, *module.pi.net.mlp)
save_policy(actor, "my-rllib", gymnasium.make_vec(TASK, 1, **OPTIONS))
algorithm.stop()
