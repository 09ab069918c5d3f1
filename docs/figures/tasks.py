"""Draws seven tasks at a moment when their tools can be seen."""

import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs import TASKS, ArmEnv

MOMENTS = {  # s after the reset
    **{"ReachPanel": 0.5, "ObjectRelocation": 1.2, "Handrail": 3.4, "Ratchet": 1.4},
    **{"Hammer": 1.5, "Scoop": 2.9, "OverheadHold": 0.1},
}
fig, axes = plt.subplots(2, 4, figsize=(12, 6.4))
axes[1, 3].remove()
for ax, (name, moment) in zip(axes.flat, MOMENTS.items(), strict=False):
    options = {"render_mode": "rgb_array", "width": 480, "height": 480, "control": {"stiff": True}}
    with ArmEnv(TASKS[name], **options) as env:
        env.reset(seed=0)
        for _ in range(round(moment / env.control_dt)):
            env.step(np.zeros(2))
        ax.imshow(env.render()[30:430, 60:460])
    ax.set_title(name)
    ax.axis("off")
fig.tight_layout()
fig.savefig("tasks.png", dpi=80)
