"""The torques at the elbow in one motion, with motors off and under two policies."""

import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs.evaluation import rollout
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy

ELBOW, MOTOR = 2, 1
PANELS = {
    "none": "motors off",
    "feedforward": "suit cancelled",
    "compensation": "suit, weight and friction",
}
arms = make_arms("ActiveSuit/ElbowFlexion-v0", 1, gravity="microgravity")
figure, axes = plt.subplots(
    2, 2, figsize=(6.4, 5.4), sharex=True, sharey=True, layout="constrained"
)
for ax, (name, title) in zip(axes.flat, PANELS.items(), strict=False):
    (trace,) = rollout(arms, make_policy(name, arms), seeds=[0])
    angle = np.degrees(trace.angle[:, ELBOW])
    ax.plot(angle, trace.suit_torque[:, ELBOW], color="C0", lw=1.2, label="suit")
    ax.plot(angle, trace.assist_torque[:, MOTOR], color="C2", lw=1.2, label="motor")
    ax.plot(angle, trace.human_torque[:, ELBOW], color="C1", lw=1.8, label="wearer")
    ax.axhline(0, color="0.8", lw=0.8, zorder=0)
    ax.set_title(f"{name}:\n{title}")
    ax.spines[["top", "right"]].set_visible(False)
    ax.xaxis.set_tick_params(labelbottom=True)
axes[1, 1].axis("off")
axes[1, 1].legend(*axes[0, 0].get_legend_handles_labels(), loc="center", frameon=False)
figure.supxlabel("elbow angle [°]")
figure.supylabel("torque on the joint [N·m]")
arms.close()
figure.savefig("controllers.png", dpi=130)
