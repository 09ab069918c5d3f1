"""Renders wearers, suit and exoskeleton: what is composed, postures, and both couplings."""

import mujoco
import numpy as np
from activesuit.envs.model import ArmConfig, compose
from PIL import Image

POSE = {"shoulder_flexion": 0.75, "elbow_flexion": 0.85}
BENT = {"shoulder_flexion": 0.55, "elbow_flexion": 1.25}
OFF = (0.03, 0.0, 0.0)  # m, how far the exoskeleton's axes are in front of the arm's
MODEL = [
    (ArmConfig(suit="none", coupling="none"), POSE, "overview"),
    (ArmConfig(coupling="none"), POSE, "overview"),
    (ArmConfig(), POSE, "overview"),
]
POSTURES = [
    (ArmConfig(wearer={"sex": "female", "stature": 1.5}), POSE, "side"),
    (ArmConfig(wearer={"stature": 1.95}, side="left"), POSE, "front"),
    (
        ArmConfig(tilt=(0.4, 0.0), gravity="microgravity", payload={"mass": 20.0}),
        {"shoulder_flexion": 0.2, "elbow_flexion": 1.5},
        "overview",
    ),
]
COUPLINGS = [
    (ArmConfig(), BENT, "cuffs"),
    (ArmConfig(coupling="cuffs", misalignment=OFF), BENT, "cuffs"),
]


def rendered(config, pose, camera, size=400):
    """Returns a square picture of an arm in a posture."""
    model = compose(config)
    model.vis.quality.shadowsize, model.vis.quality.offsamples = 4096, 8
    data = mujoco.MjData(model)
    for name, angle in pose.items():
        data.joint(name).qpos = angle
        if config.coupling == "cuffs":
            data.joint(f"exo_{name}").qpos = angle
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, size, size) as renderer:
        renderer.update_scene(data, camera=camera)
        return renderer.render().copy()


for name, arms in (("model", MODEL), ("postures", POSTURES), ("couplings", COUPLINGS)):
    Image.fromarray(np.hstack([rendered(*arm) for arm in arms])).save(f"{name}.png", optimize=True)
