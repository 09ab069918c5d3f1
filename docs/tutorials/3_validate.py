# %% [markdown]
# # 3. Validate in closed loop
#
# **At the end you know** how well a controller works that uses *your* model, and what a wrong model
# costs.
#
# **It takes** five minutes of reading and half a minute of computing. Run [tutorial
# 2](2_identify.md) first, in the same folder. The program of this page is
# [3_validate.py](3_validate.py).

# %%
import json

import matplotlib.pyplot as plt
from activesuit.scripts.main import main

# %% [markdown]
# ## One suit: what the measurement leaves open
#
# In the *closed loop* the model computes the torque of the motors, the motors move the arm, the
# person answers, and the model sees the new angle. Errors may grow there, or vanish.
#
# The true suit is one of many that could have given the same record. `identify` has put 20 of these
# *samples* into the suit file. `activesuit validate` gives the model to a controller, and lets the
# simulated person wear one of the samples, drawn anew for each motion:

# %%
main("validate my-suit/suit.json --motions 8 --out validated --force".split())

# %% [markdown]
# ## How to read this
#
# - **Relief** is 0 for the suit without an exoskeleton and 1 for no suit. The sentence below the
#   tables has the relief that you can expect of a controller with your model.
# - **`true model`** is the same controller with the true suit. The row **`by suit`** believes your
#   model. If both are alike, a better model would not help.
# - **`best-known-plan`** knows the whole motion in advance. *Of the bound* is the relief divided by
#   that of this plan.
# - **The shoulder** is that of the base suit everywhere, so its error is zero and says nothing.
# - **There is no verdict**, because a model cannot be wrong about itself.
#
# ## Two suits: what a wrong model costs
#
# With `--plant` you name the true suit, here `emu-like`. Beside your model stands one that was made
# for another suit, `mock-suit`:

# %%
line = "validate my-suit/suit.json mock-suit --plant emu-like --motions 8 --out compared --force"
main(line.split())

# %% [markdown]
# Each cell of the table has the error of the believed torque, the relief, and a verdict of the
# torque alone. `compared/result.json` has all numbers for other programs:

# %%
with open("compared/result.json", encoding="utf-8") as file:
    cells = json.load(file)["cells"]
relief = [cell["relief"] for cell in cells]
errors = [[abs(one[end] - one["value"]) for one in relief] for end in ("low", "high")]
figure, axes = plt.subplots(num="Relief by each believed suit, with intervals", figsize=(8.4, 2))
believed = [cell["believed"] for cell in cells]
axes.errorbar([one["value"] for one in relief], believed, xerr=errors, fmt="o", capsize=4)
axes.set(xlabel="relief: 0 is no exoskeleton, 1 is no suit", xlim=(0, 1), ylim=(-0.5, 1.5))
plt.show()

# %% [markdown]
# ## Where to go
#
# Your model is good enough when a better one brings no more relief. Then look at the controller:
# **[4. Write a controller of your own](4_controller.md)**.
