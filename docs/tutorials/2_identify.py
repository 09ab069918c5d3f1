# %% [markdown]
# # 2. Identify your own curves
#
# **At the end you have** turned a file from a measuring rig into a model of a joint, know how far
# the model can be trusted, and have a *suit file* that the simulation takes.
#
# **It takes** five minutes of reading and half a minute of computing. [Tutorial 1](1_simulate.md)
# explains what hysteresis is. The program of this page is [2_identify.py](2_identify.py). It
# writes its files to the working folder; the next tutorials read them there.

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
# You have a file of your own? Then use it in place of `rig.csv`, and leave this section out.
#
# We have no rig here, so we simulate one. It bends the elbow of an empty suit up and down, each
# time farther, for one minute, and writes time, angle and torque. A quicker, small motion on top
# makes small loops inside the large ones, as everyday motions have them. The sensor adds noise.
# The file is as a computer with German settings writes it: semicolons between the columns,
# decimal commas, degrees, newton millimetres, and a line of text at the top.

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
# that predicts as well as the best. In a terminal it is
#
# ```bash
# activesuit identify rig.csv --joint elbow_flexion --base emu-like --out my-suit
# ```
#
# A program gives the same words to `main`. `--joint` says which joint was measured, and `--base`
# takes all other joints from a suit that ActiveSuit has.

# %%
main("identify rig.csv --joint elbow_flexion --base emu-like --out my-suit --force".split())

# %% [markdown]
# ## How to read this
#
# - **The first line** says how the file was understood. Check it: a wrong unit makes a wrong
#   suit. The options `--columns`, `--units` and `--decimal` correct it ([all of
#   them](../identification.md#the-file-of-your-rig)).
# - **The first table** compares kinds of model. *NRMSE* is the error, divided by the largest
#   torque. The column *predicts* is the honest one: each part of the record was predicted by a
#   model that had not seen it. An error as large as the noise of the sensor is as good as it
#   gets.
# - **The table of parameters** has a 95 % interval for each of them. A wide interval means that
#   the record says little about that parameter, and often that another parameter makes up for it.
# - **The verdict** is the sentence to look at. *Describes the curves* means that nothing but
#   noise is left. If it says *does not describe the curves*, the model is wrong or the
#   measurement has a fault; [A bad measurement](../bad_measurement.md) shows how to find out
#   which. *Cannot be judged* [asks](../identification.md#does-the-model-describe-the-curves) for a
#   second record of the same motion: `activesuit identify first.csv second.csv --method auto`.
# - **Notes** say what the record leaves open, the most important first.
#
# ## Look at it
#
# Never trust a number without a picture. On the left are the measured torque and the model, on
# the right is their difference. It must look like noise, without any shape.

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
# ## How wrong is it really?
#
# Since our rig is a simulated one, we know the true torque without noise. No laboratory can print
# the next lines.

# %%
error = modeled - true_elbow.response(curve.angle)
print(f"noise of the sensor: {noise.std():.3f} N·m")
print(f"error of the model:  {np.sqrt(np.mean(error**2)):.3f} N·m")

# %% [markdown]
# The model is much better than a single sample of the record, because it averages the noise of
# all of them.
#
# ## Where to go
#
# A small error in a file is not yet good assistance. What is the model worth in the closed loop,
# with motors and a person in it? **[3. Validate in closed loop](3_validate.md)**.
#
# [Identification](../identification.md) has everything about models, noise and intervals, and
# [Measuring rig](../identification.md#a-simulated-measuring-rig) says how to measure.
