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

spec = mujoco.MjSpec.from_file("arm.xml")  # alternative: the file of your robot
for joint, model in MODELS.items():
    attach(spec, joint, model)
data = mujoco.MjData(spec.compile())

rows = []
while data.time < 16:  # all joints swing, ever wider
    data.ctrl[:] = 0.065 * data.time * np.sin(np.pi * data.time)
    angles = [data.joint(joint).qpos[0] for joint in MODELS]
    mujoco.mj_step(data.model, data)  # sensors refer to the positions before the step
    torques = [data.sensor(f"{joint}_suit_torque").data[0] for joint in MODELS]
    rows.append([data.time, *angles, *torques])
time, *series = np.transpose(rows)

plt.style.use("seaborn-v0_8-whitegrid")
figure, axes = plt.subplots(1, 3, figsize=(11, 3.8), layout="constrained")
for i, (axis, (joint, model)) in enumerate(zip(axes, MODELS.items(), strict=True)):
    dots = axis.scatter(series[i], -series[i + 3], c=time, s=2, cmap="plasma", vmax=19)
    axis.set(title=f"{joint}: {model.name}", xlabel="angle [rad]", ylabel="resistance [N·m]")
figure.colorbar(dots, label="time [s]").ax.set_ylim(0, 16)
figure.savefig("three_joints.png", dpi=160)
