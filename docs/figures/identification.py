"""A certified fit of the shipped elbow, its prediction of held-out curves, and its residuals."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from activesuit.assets import curves_path
from activesuit.identification import fit_curves, load_curves

OFFSET = 0.3  # N·m, error of a torque sensor that was not zeroed
MEASURED, MODEL = "#8a94a6", "#c2185b"

curves = load_curves(curves_path("elbow"))
shifted = [replace(curve, torque=curve.torque + OFFSET) for curve in curves]
right, wrong = fit_curves(curves), fit_curves(shifted)
PANELS = {
    "fitted curves": (right, right.curves.fitted()),
    "held-out curves": (right, right.curves.held_out()),
    f"sensor off by {OFFSET:g} N·m, fitted curves": (wrong, wrong.curves.fitted()),
}

plt.style.use("seaborn-v0_8-whitegrid")
figure, axes = plt.subplots(
    *(2, 3),
    figsize=(12, 5.4),
    layout="constrained",
    sharex=True,
    sharey="row",
    height_ratios=(2, 1),
)
for (loops, residual), (title, (fit, shown)) in zip(axes.T, PANELS.items(), strict=True):
    noise = fit.judgement.noise.deviation
    residual.axhspan(-2 * noise, 2 * noise, color=MEASURED, alpha=0.25, linewidth=0)
    for curve in shown:
        torque = fit.predict(curve)
        loops.plot(curve.angle, curve.torque, ".", color=MEASURED, markersize=3.5)
        loops.plot(curve.angle, torque, color=MODEL, linewidth=1.4)
        residual.plot(curve.angle, curve.torque - torque, ".", color=MODEL, markersize=2.5)
    errors = np.concatenate([fit.predict(curve) - curve.torque for curve in shown])
    loops.set_title(f"{title}\nerror {np.sqrt(np.mean(errors**2)) / noise:.2f} times the noise")
    residual.set_xlabel("angle [rad]")
axes[0, 0].set_ylabel("resistance [N·m]")
axes[1, 0].set_ylabel("measured less\nmodel [N·m]")
axes[0, 0].plot([], [], "o", color=MEASURED, markersize=4, label="measured")
axes[0, 0].plot([], [], color=MODEL, label="model")
axes[0, 0].legend(loc="upper left")
axes[1, 0].fill_between([], [], color=MEASURED, alpha=0.25, label="noise, two deviations")
axes[1, 0].legend(loc="upper left")
figure.savefig("identification.png", dpi=160)
