"""Five models along one motion with five repetitions of a small loop; draws torque over angle."""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from activesuit.hysteresis import TABLE_2, BoucWen, Duhem, PrandtlIshlinskii, Preisach

TURNS = (0, 1, -1, *[0.1, -0.5] * 5, 1, -1)
PER_BRANCH = 100
REPEATED = slice(3 * PER_BRANCH, 12 * PER_BRANCH)

SEGMENTS = range(20)  # relays whose levels lie close together, and more of them at high angles
DENSITY = [
    [0.14 * (i + 4) / 12 * np.exp(-(((i - j) / 6) ** 2)) for j in range(i + 1)] for i in SEGMENTS
]
MODELS = {
    "Jiles-Atherton": TABLE_2["elbow-sa-pso"],
    "Bouc-Wen": BoucWen(elastic=1.5, hysteretic=12, beta=5, gamma=-1, n=1.5),
    "Duhem": Duhem(spring=(0.0, 1.0, 0.0, 2.0), stiffness=14, friction_up=3.5, friction_down=2),
    "Preisach": Preisach(
        levels=np.linspace(-1, 1, 21), density=DENSITY, elastic=np.linspace(9, 18, 20)
    ),
    "Prandtl-Ishlinskii": PrandtlIshlinskii(
        stiffness=1.5, thresholds=[0.1, 0.25, 0.45, 0.7], weights=[5, 4, 2, 1]
    ),
}

branches = [np.linspace(a, b, PER_BRANCH, endpoint=False) for a, b in pairwise(TURNS)]
angle = np.concatenate(branches)

plt.style.use("seaborn-v0_8-whitegrid")
figure, axes = plt.subplots(1, 5, figsize=(14, 3.4), layout="constrained", sharey=True)
for axis, (name, model) in zip(axes, MODELS.items(), strict=True):
    torque = model.response(angle)
    axis.plot(angle, torque, color="#8a94a6", linewidth=1.4)
    axis.plot(angle[REPEATED], torque[REPEATED], color="#c2185b", linewidth=1.4)
    axis.set(title=name, xlabel="angle [rad]")
axes[0].set_ylabel("resistance [N·m]")
figure.savefig("models.png", dpi=160)
