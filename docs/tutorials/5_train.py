# %% [markdown]
# # 5. Train a controller
#
# **At the end you have** trained a network that corrects a controller whose model of the suit is
# wrong, seen its learning curve, and compared it in motions that it never met.
#
# **It takes** five minutes of reading and one to two minutes of computing. It needs the extra
# `train`: `pip install '.[train]' -c constraints.txt` in a clone of the repository. The program
# of this page is [5_train.py](5_train.py).

# %%
import json

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import make_policy, save_policy
from activesuit.envs.sb3 import ArmVecEnv, ResidualVecEnv
from activesuit.scripts.main import main
from stable_baselines3 import PPO

ARM = {"suit": "emu-like", "gravity": "microgravity"}

# %% [markdown]
# ## What is there to learn?
#
# In [tutorial 3](3_validate.md) a controller with the model of another suit helped less. A person
# may get a suit that nobody has measured, so this is no rare case. How much is lost?

# %%
wrong = {"name": "compensation", "suit": "mock-suit"}
right = {"name": "compensation", "suit": "emu-like"}
before = evaluate(
    "ActiveSuit/ArmTracking-v0", {"wrong model": wrong, "right model": right}, motions=8, **ARM
)
for name in ("wrong model", "right model"):
    print(f"{name}: relief {before.relief(name)}")

# %% [markdown]
# ## Correct a policy instead of replacing it
#
# *Reinforcement learning* tries actions at random and prefers those after which the reward was
# larger. The reward of a control period is large if the person works little, follows the intended
# motion, and the action does not jump ([the formula](../environments.md#action-reward-and-end)).
#
# A network that begins with random torques would throw the arm about for a long time. So it gets
# an easier job: **add a correction to the policy that we have**. The motors then get *policy +
# scale × network*. The network begins at zero, which is the policy itself. It sees what the
# sensors see, and nothing of the true suit.
#
# In a terminal this is
#
# ```bash
# activesuit train --task ArmTracking --suit emu-like --gravity microgravity \
#     --residual compensation:suit=mock-suit --steps 80000 --out trained
# ```
#
# The algorithm is PPO of Stable-Baselines3, with 64 arms side by side. After every tenth of the
# training the network is tested in eight motions of persons who have learned to move with it. The
# folder keeps the best one.

# %% tags=["varies"]
line = "train --task ArmTracking --suit emu-like --gravity microgravity --residual {} --steps {}"
main([*line.format("compensation:suit=mock-suit", 80000).split(), "--out", "trained", "--force"])

# %% [markdown]
# ## The learning curve

# %%
with open("trained/evaluations.json", encoding="utf-8") as file:
    tests = json.load(file)["results"]
steps = [test["steps"] for test in tests]
relief = [test["relief"]["value"] for test in tests]
band = [[test["relief"][end] for test in tests] for end in ("low", "high")]

figure, axes = plt.subplots(num="Relief over the steps of the training, with 95 % intervals")
axes.plot(steps, relief, "o-", label="with correction")
axes.fill_between(steps, *band, color="C0", alpha=0.2)
for name, color in (("wrong model", "C1"), ("right model", "C2")):
    axes.axhline(before.relief(name).value, color=color, label=name)
axes.set(xlabel="steps of training", ylabel="relief", ylim=(0, 1))
axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
plt.show()

# %% [markdown]
# ## An honest test
#
# The best of ten tests looks a little too good, because it was chosen for its result. So compare
# again in motions that neither the training nor the choice has used. The folder of the training
# is a policy wherever a policy is named:

# %% tags=["varies"]
after = evaluate(
    "ActiveSuit/ArmTracking-v0",
    {"wrong model": wrong, "with correction": "trained", "right model": right},
    motions=8,
    **ARM,
)
for name, score in after.scores.items():
    print(f"{name:15} relief {after.relief(name)}, went well {sum(score.success)} of 8")
print("difference by the correction:", after.relief_difference("with correction", "wrong model"))

# %% [markdown]
# If the last interval is above zero, the correction helps. Compare it with the right model too:
# the learning curve says whether more steps would bring more. And one training is one case: with
# another seed it ends elsewhere. Before you claim anything, train at least five times (`--seeds
# 0-4`).
#
# ## The same in Python
#
# With a learner of your own you need the arms, the correction and `save_policy`. This is too
# short to learn anything; it shows all the parts.

# %%
arms = gymnasium.make_vec("ActiveSuit/ArmTracking-v0", 16, autoreset_mode="SameStep", **ARM)
rows = ResidualVecEnv(ArmVecEnv(arms), wrong)
model = PPO("MlpPolicy", rows, n_steps=64, batch_size=256, gamma=0.98, seed=0)
model.learn(2048)
save_policy(model, "my-policy", rows)

one = gymnasium.make("ActiveSuit/ArmTracking-v0", **ARM)
observation, info = one.reset(seed=0)
policy = make_policy("my-policy", one)
policy.reset()
action = policy.act(observation)
print("a saved policy needs no torch; its action has the shape", np.shape(action))

# %% [markdown]
# ## Where to go
#
# You have simulated, identified, validated, written and trained. What next?
#
# - [Train a controller](../training.md): other algorithms, sensors, teachers, rewards,
#   hyperparameters, and export to other machines as ONNX.
# - [Tasks](../environments.md#tasks): from reaching to hammering, or a task of your own.
# - [Benchmark](../benchmark.md): your controller beside all others, and how to share the result.
# - [Hysteresis on your own robot](../robot.md): the models of tutorial 2 in any MuJoCo model.
