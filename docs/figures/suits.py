"""Draws the widest loop of every joint of the shipped suits."""

import matplotlib.pyplot as plt
import numpy as np
from activesuit.assets import JOINTS, load_suit

SUITS = ("mock-suit", "emu-like", "exploration-56kpa")

plt.style.use("seaborn-v0_8-whitegrid")
figure, axes = plt.subplots(1, 4, figsize=(13, 3.9), layout="constrained")
for axis, joint in zip(axes, JOINTS, strict=True):
    for name in SUITS:
        entry = load_suit(name).joints[joint]
        low, high = entry.range
        approach, up = np.linspace(entry.start_angle, low, 100), np.linspace(low, high, 200)
        angle = np.concatenate([approach, up, up[::-1]])
        torque = entry.model.response(angle, entry.start_torque)
        axis.plot(angle[100:], torque[100:], label=name)
    axis.set(title=joint.replace("_", " "), xlabel="angle [rad]")
axes[0].set_ylabel("resistance [N·m]")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(SUITS))
figure.savefig("suits.png", dpi=160)
