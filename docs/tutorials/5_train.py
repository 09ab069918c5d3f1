# %% [markdown]
# # 5. Train a controller
#
# **At the end you have** trained a network that corrects a controller whose model of the suit is
# wrong, and compared it in motions that it never met.
#
# **It takes** five minutes of reading and two minutes of computing. It needs the extra `train`:
# `pip install '.[train]' -c constraints.txt` in a clone of the repository. The program of this page
# is [5_train.py](5_train.py).

# %%
import json

import matplotlib.pyplot as plt
from activesuit.envs.evaluation import evaluate
from activesuit.scripts.main import main

ARM = {"suit": "emu-like", "gravity": "microgravity"}

# %% [markdown]
# ## What is there to learn?
#
# A person may get a suit that nobody has measured. How much relief is lost with the model of
# another suit?

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
# *Reinforcement learning* tries actions at random and prefers those after which [the
# reward](../environments.md#action-reward-and-end) was larger. The reward is large if the person
# works little, follows the intended motion, and the action does not jump.
#
# A network that begins with random torques would throw the arm about. So the network gets an easier
# job: **add a correction to the policy that we have**. The motors get *policy + scale × network*.
# The network begins at zero, and sees what the sensors see, nothing of the true suit.
#
# ```bash
# activesuit train --task ArmTracking --suit emu-like --gravity microgravity \
#     --residual compensation:suit=mock-suit --steps 80000 --out trained
# ```
#
# The algorithm is PPO of Stable-Baselines3, with 64 arms side by side. After every tenth of the
# training the network is tested in eight motions. The folder keeps the best network.

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
# ## A fair test
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
# If the last interval is above zero, the correction helps. One training is one case: before you
# claim anything, train at least five times (`--seeds 0-4`).
#
# ## Where to go
#
# [Train a controller](../training.md) has other algorithms, sensors, teachers, rewards, and
# learners of your own. [Tasks](../environments.md#tasks) has other motions, the
# [benchmark](../benchmark.md) compares controllers, and [your own robot](../robot.md) takes the
# models of tutorial 2.
