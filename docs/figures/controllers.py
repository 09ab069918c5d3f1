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
figure, axes = plt.subplots(1, 3, figsize=(10, 3.4), sharey=True, layout="constrained")
for ax, (name, title) in zip(axes, PANELS.items(), strict=True):
    (trace,) = rollout(arms, make_policy(name, arms), seeds=[0])
    angle = np.degrees(trace.angle[:, ELBOW])
    ax.plot(angle, trace.suit_torque[:, ELBOW], color="C0", lw=1.2, label="suit")
    ax.plot(angle, trace.assist_torque[:, MOTOR], color="C2", lw=1.2, label="motor")
    ax.plot(angle, trace.human_torque[:, ELBOW], color="C1", lw=1.8, label="wearer")
    ax.axhline(0, color="0.8", lw=0.8, zorder=0)
    ax.set_title(f"{name}: {title}", fontsize=10)
    ax.set_xlabel("elbow angle [°]")
    ax.spines[["top", "right"]].set_visible(False)
axes[0].set_ylabel("torque on the joint [N·m]")
lines = axes[0].get_legend_handles_labels()
figure.legend(*lines, loc="outside upper center", ncols=3, frameon=False)
arms.close()
figure.savefig("controllers.png", dpi=130)
