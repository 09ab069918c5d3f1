"""The way of the data through the package, with the module of each step."""

import matplotlib.pyplot as plt

STEPS = {
    "curves": "identification",
    "model of the torque": "hysteresis",
    "suit file": "assets",
    "MuJoCo model": "envs.model",
    "environment": "envs",
    "policy": "envs.policies",
    "evaluation": "envs.evaluation",
}
figure, ax = plt.subplots(figsize=(11, 1.5), layout="constrained")
style = {"boxstyle": "round,pad=0.5", "facecolor": "#eef1fb", "edgecolor": "#4051b5"}
for i, (step, module) in enumerate(STEPS.items()):
    text = f"{step}\n{module}"
    ax.text(i, 0, text, ha="center", va="center", fontsize=8.5, bbox=style)
    if i:
        ax.annotate("", (i - 0.43, 0), (i - 0.57, 0), arrowprops={"arrowstyle": "-|>"})
ax.set(xlim=(-0.5, len(STEPS) - 0.5), ylim=(-1, 1))
ax.axis("off")
figure.savefig("api.png", dpi=130)
