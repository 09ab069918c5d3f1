# %% [markdown]
# # 1. Simulate an assisted arm
#
# **At the end you have** simulated a person who bends the elbow in a pressurized spacesuit, seen
# why the suit is called *hysteretic*, and measured how much an exoskeleton helps.
#
# **It takes** five minutes of reading and half a minute of computing. The first use of ActiveSuit
# compiles code for a minute, and for three on a busy computer. You need [an
# installation](../install.md), and no knowledge of MuJoCo, which simulates the physics.
#
# This page is a program: [1_simulate.py](1_simulate.py). Run `python 1_simulate.py`, or open the
# file in VS Code, Spyder or Jupyter (with Jupytext), cell by cell.

# %%
import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs.evaluation import evaluate  # activesuit registers its environments
from activesuit.envs.policies import make_policy

# %% [markdown]
# ## One arm in a suit
#
# An *environment* is one simulated arm for one motion, with the interface of
# [Gymnasium](https://gymnasium.farama.org). This elbow bends and straightens for ten seconds.
# There is no gravity, so that little but the suit resists the motion.

# %%
env = gymnasium.make("ActiveSuit/ElbowFlexion-v0", suit="emu-like", gravity="microgravity")
observation, info = env.reset(seed=0)

print("the observation has:", *env.unwrapped.layout)
print("the action has", env.action_space.shape[0], "numbers")

# %% [markdown]
# Every hundredth of a second the environment takes an *action* and returns an *observation*. The
# action is the torque of the motors, as a share of their largest torque. The observation is what
# the sensors of the exoskeleton measure.
#
# The **person is part of the simulation**: the simulated wearer gives whatever torque the intended
# motion takes, as muscles would.
#
# First the motors do nothing. The dictionary `info` has what no sensor could measure, such as the
# torque of the suit. A controller does not get `info`.

# %%
JOINTS = ["shoulder abduction", "shoulder flexion", "elbow flexion", "wrist flexion"]
ELBOW = JOINTS.index("elbow flexion")


def simulate(act):
    """Runs one motion; returns the elbow's angle [°], the suit's and the person's torque [N·m]."""
    observation, info = env.reset(seed=0)
    rows, ended = [], False
    while not ended:
        observation, _, terminated, truncated, info = env.step(act(observation))
        measured = info["angle"], info["suit_torque"], info["human_torque"]
        rows.append([values[ELBOW] for values in measured])
        ended = terminated or truncated
    angle, suit, person = np.transpose(rows)
    return np.degrees(angle), suit, person


def motors_off(observation):
    """Returns an action without torque."""
    return np.zeros(2, np.float32)


angle, suit, person = simulate(motors_off)
print(f"{len(angle)} steps, elbow angles from {angle.min():.0f} to {angle.max():.0f} degrees")
print(f"largest torque of the suit   {np.abs(suit).max():4.1f} N·m")
print(f"largest torque of the person {np.abs(person).max():4.1f} N·m")

# %% [markdown]
# ## Why "hysteretic"?
#
# A spring gives one torque for each angle. Look at what the suit does:

# %%
figure, (left, right) = plt.subplots(1, 2, num="The motion, and the torque of the suit")
time = 0.01 * np.arange(len(angle))
left.plot(time, angle)
left.set(xlabel="time [s]", ylabel="elbow angle [°]", title="the motion")
right.plot(angle, suit, color="C1")
right.set(xlabel="elbow angle [°]", ylabel="torque of the suit [N·m]", title="the suit")
plt.show()

# %% [markdown]
# Positive torque bends the elbow, and negative torque straightens it. On the right the elbow goes
# around loops. At the same angle the suit pushes harder against bending than it gives back when the
# elbow straightens. So the torque depends on **how the joint got to its angle**. That is
# hysteresis. The area inside a loop is energy that the person spends in each cycle and never gets
# back.

# %% [markdown]
# ## Let the motors help
#
# A *policy* computes the action from the observation. The policy `compensation` has a model of the
# suit with a memory of its own. Its motors cancel the torque that the model predicts at the
# measured angles, and the friction of the gears.

# %%
policy = make_policy("compensation", env)
policy.reset()
assisted_angle, _, assisted_person = simulate(policy.act)
print(f"largest torque of the person: {np.abs(person).max():.1f} N·m without assistance,")
print(f"and {np.abs(assisted_person).max():.1f} N·m with it")

# %% [markdown]
# ## One number for it
#
# One motion is no proof. `evaluate` runs several motions, lets the simulated person learn each of
# them first, and compares policies with two references: no suit at all, and the suit without an
# exoskeleton. **Relief** is the share of the suit's cost that a policy gives back. At 0 the
# exoskeleton is of no use, and at 1 the suit is as easy as no suit.

# %%
found = evaluate(
    "ActiveSuit/ElbowFlexion-v0",
    ["none", "feedforward", "compensation"],
    motions=8,
    suit="emu-like",
    gravity="microgravity",
)
print(f"{'policy':15}{'effort':>10}   relief")
for name, score in found.scores.items():
    print(f"{name:15}{np.mean(score.effort):10.1%}   {found.relief(name)}")

# %% [markdown]
# **Effort** is the torque of the person as a share of strength. The 10 % without a suit are muscles
# that pull against each other to stiffen the arm (*co-contraction*). The brackets have 95 %
# intervals over motions. `none` is the exoskeleton with its motors off, whose gears the person has
# to move. `feedforward` cancels the suit and leaves that friction.
#
# ## Where to go
#
# `compensation` had the right model of the suit. Such a model comes from a measurement: **[2.
# Identify your own curves](2_identify.md)**. [Environments](../environments.md) has all options,
# and [tasks](../environments.md#tasks) has other motions.
