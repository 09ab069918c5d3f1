# %% [markdown]
# # 2. Identify your own curves
#
# **At the end you have** turned a file from a measuring rig into a model of a joint, know how far
# to trust the model, and have a *suit file* that the simulation takes.
#
# **It takes** five minutes of reading and half a minute of computing. The program,
# [2_identify.py](2_identify.py), writes files that the next tutorials read.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from activesuit.assets import load_suit
from activesuit.identification import load_curves
from activesuit.scripts.main import main

# %% [markdown]
# ## A file from a rig
#
# You have a file of your own? Then use that file in place of `rig.csv`, and leave this section out.
#
# Here a rig is simulated. It bends the elbow of an empty suit up and down for one minute, each time
# farther. A quicker, small motion on top makes small loops inside the large ones. The file has
# semicolons between the columns, decimal commas, degrees and newton millimetres.

# %%
true_elbow = load_suit("emu-like").joints["elbow_flexion"]  # nobody knows it in a laboratory

time = np.arange(0, 60, 0.04)  # s
size = 0.5 + time / 120  # each cycle is larger than the one before
angle = 0.6 + 0.45 * size * (1 - np.cos(2 * np.pi * time / 10))  # rad
angle += 0.07 * np.sin(2 * np.pi * time / 3)  # a quicker, small motion on top
torque = true_elbow.response(angle)  # N·m
noise = 0.2 * np.random.default_rng(0).standard_normal(len(time))

lines = ["Prüfstand 7, Ellbogen", "Zeit [s];Winkel [Grad];Drehmoment [Nmm]"]
for row in zip(time, np.degrees(angle), 1000 * (torque + noise), strict=True):
    lines.append(";".join(f"{value:.2f}" for value in row).replace(".", ","))
Path("rig.csv").write_text("\n".join(lines), encoding="utf-8")
print(*lines[:5], sep="\n")

# %% [markdown]
# ## From the file to a model
#
# One command reads the file, tries several kinds of hysteresis model, and keeps the simplest one
# that predicts as well as the best:
#
# ```bash
# activesuit identify rig.csv --joint elbow_flexion --base emu-like --out my-suit
# ```
#
# `--joint` says which joint was measured, and `--base` takes all other joints from a suit that
# ActiveSuit has. A program gives the same words to `main`.

# %%
main("identify rig.csv --joint elbow_flexion --base emu-like --out my-suit --force".split())

# %% [markdown]
# ## How to read this
#
# - **The first line** says how the file was understood. A wrong unit makes a wrong suit; [options
#   correct it](../identification.md#the-file-of-your-rig).
# - **The first table** compares kinds of model. *NRMSE* is the error over the largest torque. In
#   the column *predicts* each part of the record was predicted by a model that had not seen it.
# - **The table of parameters** has 95 % intervals. A wide interval often means that another
#   parameter makes up for this one.
# - **The verdict** is the sentence to look at. *Describes the curves*: nothing but noise is left.
#   *Does not describe the curves*: the model is wrong or [the measurement has a
#   fault](../bad_measurement.md). *Cannot be judged*: [measure
#   twice](../identification.md#does-the-model-describe-the-curves).
# - **Notes** say what the record leaves open, the most important first.
#
# ## Look at it
#
# On the left are the measured torque and the model. Their difference, on the right, must look like
# noise, without any shape.

# %%
(curve,) = load_curves("rig.csv")
my_elbow = load_suit("my-suit/suit.json").joints["elbow_flexion"]
modeled = my_elbow.response(curve.angle)

figure, (left, right) = plt.subplots(
    *(1, 2), num="Measured torque and model over the angle; their difference over time"
)
degrees = np.degrees(curve.angle)
left.plot(degrees, curve.torque, color="C4", linewidth=1, label="measured")
left.plot(degrees, modeled, color="C3", linewidth=1, label="model")
left.set(xlabel="elbow angle [°]", ylabel="resistance [N·m]")
left.legend()
right.plot(curve.time, curve.torque - modeled, color="C3", linewidth=0.5)
right.set(xlabel="time [s]", ylabel="measured less model [N·m]")
plt.show()

# %% [markdown]
# ## Where to go
#
# What is the model worth in the closed loop, with motors and a person in it? **[3. Validate in
# closed loop](3_validate.md)**. [Identification](../identification.md) has everything about files,
# models, verdicts and [measuring](../identification.md#a-simulated-measuring-rig).
