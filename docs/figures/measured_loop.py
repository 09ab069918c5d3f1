"""A noisy record of three first-order curves: its reversals, smoothed loops and metrics."""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from activesuit.hysteresis import TABLE_2
from activesuit.hysteresis.loops import first_order_families, reversals
from activesuit.hysteresis.metrics import loop_metrics
from activesuit.hysteresis.smoothing import smooth

COLORS = ("#1f77b4", "#e08a1e", "#c2185b")


def record(seed=0):
    """Returns angle [rad] and torque [N·m] of a synthetic elbow with dwell, jitter and noise."""
    rng = np.random.default_rng(seed)
    turns = (0.52, 0.87, 0.52, 1.22, 0.52, 1.57, 0.52)
    pieces = [
        (np.linspace(a, b, int(600 * abs(b - a))), np.full(40, b)) for a, b in pairwise(turns)
    ]
    angle = np.concatenate([part for piece in pieces for part in piece])
    torque = TABLE_2["elbow-sa-pso"].response(angle)
    noise = rng.standard_normal((2, angle.size))
    return angle + 0.002 * noise[0], torque + 0.09 * noise[1]


angle, torque = record()
turns = reversals(angle)
clean_angle, clean_torque = smooth(angle, torque)
(family,) = first_order_families(clean_angle, clean_torque)
largest = family.curves[-1]
metrics = loop_metrics(largest.angle, largest.torque)

plt.style.use("seaborn-v0_8-whitegrid")
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
left.plot(angle, color="#8a94a6", linewidth=1)
left.plot(turns, angle[turns], "o", color="#c2185b", label="reversals")
left.set(xlabel="sample", ylabel="angle [rad]")
left.legend(loc="upper left", frameon=True)

right.plot(angle, torque, ".", color="#c9ced8", markersize=2)
right.fill(largest.angle, largest.torque, color=COLORS[-1], alpha=0.08)
for curve, color in zip(family.curves, COLORS, strict=True):
    right.plot(curve.angle, curve.torque, color=color, label=f"turn at {curve.turn:.2f} rad")
half = metrics.remanence
right.errorbar(metrics.center, metrics.mid_torque, half, color="#333333", capsize=4)
right.annotate(f"  ±{half:.2f} N·m", (metrics.center, metrics.mid_torque + 0.4))
right.set(xlabel="angle [rad]", ylabel="resistance [N·m]")
right.set_title(f"largest loop: {metrics.area:.2f} J a cycle", fontsize=11)
right.legend(loc="lower right", frameon=True)
figure.savefig("measured_loop.png", dpi=160)
