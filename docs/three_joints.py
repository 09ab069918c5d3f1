"""Three hysteresis models on three joints of a robot arm; draws their torque over angle."""

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from activesuit.hysteresis import TABLE_2, BoucWen, PrandtlIshlinskii
from activesuit.hysteresis.engine import attach

MODELS = {
    "shoulder": TABLE_2["elbow-sa-pso"].scaled(torque=2),
    "elbow": BoucWen(elastic=4, hysteretic=40, beta=6, gamma=2, n=1.5),
    "wrist": PrandtlIshlinskii(stiffness=1, thresholds=[0.05, 0.2, 0.5], weights=[15, 8, 4]),
}

spec = mujoco.MjSpec.from_file("arm.xml")  # or your own robot
for joint, hysteresis in MODELS.items():
    attach(spec, joint, hysteresis)
arm = spec.compile()
data = mujoco.MjData(arm)

rows = []
while data.time < 16:
    for joint in MODELS:
        data.actuator(joint).ctrl = 0.065 * data.time * np.sin(np.pi * data.time)
    angles = [data.joint(joint).qpos[0] for joint in MODELS]
    mujoco.mj_step(arm, data)
    torques = [data.sensor(f"{joint}_suit_torque").data[0] for joint in MODELS]
    rows.append([data.time, *angles, *torques])
time, *columns = np.array(rows).T

figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained")
for i, (axis, joint) in enumerate(zip(axes, MODELS, strict=True)):
    dots = axis.scatter(columns[i], -columns[i + 3], c=time, s=3, cmap="viridis")
    lost = data.sensor(f"{joint}_suit_dissipated_energy").data[0]
    axis.set_title(f"{joint}: {MODELS[joint].name}, {lost:.1f} J lost")
    axis.set(xlabel="angle [rad]", ylabel="resistance [N·m]")
figure.colorbar(dots, label="time [s]")
figure.savefig("three_joints.png", dpi=150)
