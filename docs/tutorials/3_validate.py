# %% [markdown]
# # 3. Validate in closed loop
#
# **At the end you have** an answer to the question for which models are made: how well does a
# controller work that uses *this* model, and what does a wrong model cost?
#
# **It takes** five minutes of reading and half a minute of computing, two minutes on a busy
# computer. Run [tutorial 2](2_identify.md) first, in the same folder: it makes the suit file
# `my-suit/suit.json`. The program of this page is [3_validate.py](3_validate.py).

# %%
import json

import matplotlib.pyplot as plt
import numpy as np
from activesuit.assets import load_suit
from activesuit.scripts.main import main

# %% [markdown]
# ## Open and closed loop
#
# In tutorial 2 the model followed a motion that was given. In the *closed loop* everything
# depends on everything: the model computes the torque of the motors, the motors move the arm, the
# person answers, and the model sees the new angle. Errors may grow there, or vanish.
#
# ## One suit: what the measurement leaves open
#
# The true suit is not known exactly. It is one of many that could have given the same record.
# `identify` has put 20 of these into the suit file, the *samples*. Here they are, as differences
# from the model, in one large cycle:

# %%
elbow = load_suit("my-suit/suit.json").joints["elbow_flexion"]
time = np.linspace(0, 10, 200)  # s
angle = 0.6 + 0.45 * (1 - np.cos(2 * np.pi * time / 10))  # rad
model = elbow.response(angle)
figure, axes = plt.subplots(num="Torque of the samples less that of the model, in one cycle")
for sample in elbow.samples:
    difference = elbow.response(angle, sample, time) - model
    axes.plot(np.degrees(angle), difference, color="C0", alpha=0.5, linewidth=1)
axes.set(xlabel="elbow angle [°]", ylabel="sample less model [N·m]")
plt.show()
print(f"{len(elbow.samples)} samples; the model's largest torque is {model.max():.1f} N·m")

# %% [markdown]
# `activesuit validate` gives the model to a controller, and lets the simulated person wear one of
# the samples, drawn anew for each motion. In a terminal:
#
# ```bash
# activesuit validate my-suit/suit.json --motions 8 --out validated
# ```

# %%
main("validate my-suit/suit.json --motions 8 --out validated --force".split())

# %% [markdown]
# ## How to read this
#
# - **Relief** is 0 for the suit without an exoskeleton and 1 for no suit. The sentence below the
#   tables has the relief that you can expect of a controller with your model, with a 95 %
#   interval.
# - **`true model`** is the same controller that knows the true suit. The row **`by suit`**
#   believes your model. If both are alike, a better model would not help: the rest is the
#   controller's.
# - **`best-known-plan`** knows the whole motion in advance. It says what these motors could do;
#   *of the bound* is the relief divided by that of this plan.
# - **`late by`** is how long the believed torque comes after the true one; below 0 it is early.
# - **The shoulder** was not measured. It is that of the base suit in the model and in all
#   samples, so that its error is zero here, and says nothing.
# - **There is no verdict**, because a model cannot be wrong about itself. *Not contained* says
#   what this answer leaves out.
#
# ## Two suits: what a wrong model costs
#
# With `--plant` you name the true suit. In our simulated laboratory we know the true one,
# `emu-like`. Beside your model we try one that was made for another suit, `mock-suit`:
#
# ```bash
# activesuit validate my-suit/suit.json mock-suit --plant emu-like --motions 8 --out compared
# ```

# %%
line = "validate my-suit/suit.json mock-suit --plant emu-like --motions 8 --out compared --force"
main(line.split())

# %% [markdown]
# Each cell of the table has the error of the believed torque, the relief, and a verdict. The
# verdict is of the torque alone: *valid* is an error of at most 5 % of the largest torque,
# *usable* one of 15 %.
#
# All numbers are in the folder, as JSON for other programs:

# %%
with open("compared/result.json", encoding="utf-8") as file:
    result = json.load(file)
names, relief, low, high = [], [], [], []
for cell in result["cells"]:
    names.append(cell["believed"])
    relief.append(cell["relief"]["value"])
    low.append(cell["relief"]["value"] - cell["relief"]["low"])
    high.append(cell["relief"]["high"] - cell["relief"]["value"])
    print(f"{names[-1]}: {cell['verdict']}, relief {relief[-1]:.2f}")

figure, axes = plt.subplots(num="Relief by each believed suit, with intervals", figsize=(8.4, 2))
axes.errorbar(relief, names, xerr=[low, high], fmt="o", capsize=4)
axes.set(xlabel="relief: 0 is no exoskeleton, 1 is no suit", xlim=(0, 1), ylim=(-0.5, 1.5))
plt.show()

# %% [markdown]
# ## Where to go
#
# Your model is good enough when a better one brings no more relief. Then look at the controller:
# **[4. Write a controller of your own](4_controller.md)**.
#
# [Is an identified suit good enough?](../controllers.md#is-an-identified-suit-good-enough) has
# the rules of the verdict.
