# %% [markdown]
# # 4. Write a controller of your own
#
# **At the end you have** written two controllers, one from nothing and one with the suit model that
# you identified, and know whether the second is better than one that ActiveSuit has.
#
# **It takes** five minutes of reading and little computing. Run [tutorial 2](2_identify.md) first,
# in the same folder. The program of this page is [4_controller.py](4_controller.py).

# %%
import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs.evaluation import evaluate
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Belief, HysteresisFeedforward

ARM = {"suit": "emu-like", "gravity": "microgravity"}

# %% [markdown]
# ## What a controller gets
#
# A controller, or *policy*, is any object with two methods: `reset()`, which forgets the last
# motion, and `act(observation)`, which returns the action. It is made from a `Plant`, which has
# what an engineer would know of the device.

# %%
env = gymnasium.make("ActiveSuit/ArmTracking-v0", **ARM)
plant = Plant.of(env.unwrapped.episodes)
print("control period:", plant.dt, "s")
print("peak torques of the motors:", plant.peak, "N·m")
friction = [motor.coulomb for motor in plant.config.exo.motors.values()]
print("friction of the gears, from the data sheet:", friction, "N·m")

# %% [markdown]
# ## A controller from nothing
#
# The gears of the motors resist every motion with that friction. So push along with the motion by a
# share of the friction. Near standstill the push fades out, because noise of the sensor would make
# it flip.
#
# An observation is one arm, of shape `(size,)`, or many arms at once, of shape `(arms, size)`. The
# dots in `observation[..., part]` make the class work for both.


# %%
class CancelFriction:
    """Cancels a share of the gears' friction."""

    def __init__(self, plant, share: float = 0.8):
        motors = plant.config.exo.motors.values()
        self.push = share * np.array([motor.coulomb for motor in motors]) / plant.peak
        self.rate, self.assisted = plant.layout["rate"], plant.assisted

    def reset(self):
        """Has nothing to forget."""

    def act(self, observation):
        """Returns the torques of both motors, as shares of their peaks."""
        rate = observation[..., self.rate][..., self.assisted]  # rad/s
        return self.push * np.tanh(rate / 0.1)


policy = CancelFriction(plant)
observation, info = env.reset(seed=0)
policy.reset()
for _ in range(100):
    observation, *_ = env.step(policy.act(observation))
print("action after one second:", np.round(policy.act(observation), 3))

# %% [markdown]
# ## A controller with your model
#
# The suit resists much more than the gears. `HysteresisFeedforward` is the class behind the policy
# `feedforward`: it follows the measured angles with a hysteresis model, and returns the torque that
# cancels the suit. It is a `TorquePolicy`, whose method `torque` returns N·m for many arms at once,
# from the parts of the observation by name:


# %%
class SuitAndFriction(HysteresisFeedforward):
    """Cancels the believed suit and a share of the gears' friction."""

    def __init__(self, plant, belief=None, *, share: float = 0.8):
        super().__init__(plant, belief)
        motors = plant.config.exo.motors.values()
        self.push = share * np.array([motor.coulomb for motor in motors])  # N·m

    def torque(self, seen):
        """Returns the torque of both motors [N·m], one row for each arm."""
        rate = seen["rate"][:, self.assisted]  # rad/s
        return super().torque(seen) + self.push * np.tanh(rate / 0.1)


# %% [markdown]
# The argument `belief` is what the controller believes about the arm, for example the suit. `seen`
# also has `angle`, and what other [sensors](../environments.md#sensor-suites) measure that the
# class names in `sensors`.
#
# ## Compare
#
# `evaluate` takes a class, or any other function that makes a policy from a plant, beside the
# policies that ActiveSuit has. All of them get the same motions and the same persons.

# %%
mine = {"suit": "my-suit/suit.json"}
found = evaluate(
    "ActiveSuit/ArmTracking-v0",
    {
        "motors off": "none",
        "friction": CancelFriction,
        "feedforward": {"name": "feedforward", **mine},
        "suit and friction": lambda plant: SuitAndFriction(plant, Belief(**mine)),
        "compensation": {"name": "compensation", **mine},
    },
    motions=8,
    seed=10_000,  # the same motions again; without a seed they would be drawn
    **ARM,
)
for name, score in found.scores.items():
    print(f"{name:18} relief {found.relief(name)}, went well {sum(score.success)} of 8")

# %%
names = [name for name in found.scores if name not in ("unsuited", "suited")]
relief = [found.relief(name) for name in names]
figure, axes = plt.subplots(num="Relief of five controllers, with intervals", figsize=(8.4, 2.6))
errors = [[one.value - one.low for one in relief], [one.high - one.value for one in relief]]
axes.errorbar([one.value for one in relief], names, xerr=errors, fmt="o", capsize=4)
axes.axvline(0, color="C4", linewidth=0.8)
axes.set(xlabel="relief: 0 is no exoskeleton, 1 is no suit")
axes.invert_yaxis()
plt.show()

# %% [markdown]
# Intervals that overlap do not say that two controllers are alike, since both had the same
# motions. The difference, motion by motion, is sharper:

# %%
print("own less feedforward: ", found.relief_difference("suit and friction", "feedforward"))
print("own less compensation:", found.relief_difference("suit and friction", "compensation"))

# %% [markdown]
# An interval without zero means that the difference is real, for motions of this kind.
# `compensation` has the same terms as your class. Beside them it cancels friction that grows with
# the rate, and weight, which is zero here.
#
# ## From the command line
#
# Put a class into a file `my_policies.py`. In its folder every command knows the class, with
# options after a colon:
#
# ```bash
# activesuit evaluate --policies compensation \
#     my_policies:SuitAndFriction:suit=my-suit/suit.json,share=0.6 \
#     --suit emu-like --gravity microgravity
# ```
#
# ## Where to go
#
# Can a computer find such a correction by itself? **[5. Train a controller](5_train.md)**.
# [Controllers and scores](../controllers.md) has all policies that ship, and the
# [benchmark](../benchmark.md) compares yours with them over all tasks.
