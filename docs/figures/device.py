"""Torques of the motors from Python and from C code in the loop, in one motion of the elbow."""

import shutil
import subprocess
from pathlib import Path

import activesuit
import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from activesuit.envs.policies import make_policy
from activesuit.scripts.main import main

SECONDS, PERIODS = 0.01, 500
SHOULDER, ELBOW = 0, 1

shutil.copy(Path(activesuit.__file__).parent / "docs" / "device" / "control.c", "control.c")
main(["export", "compensation", "--c", "--out", "compensation.h", "--force"])
flags = ["-std=c99", "-O2", "-DACTIVESUIT_FLOAT"]
subprocess.run(["cc", *flags, "control.c", "-o", "control", "-lm"], check=True)


def device():
    """Yields torques [N·m] for observations; a process of its own computes them."""
    with subprocess.Popen("./control", stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        observation = yield np.zeros(2)
        while True:
            process.stdin.write(observation[:8].tobytes())  # the angles, then the rates
            process.stdin.flush()
            observation = yield np.frombuffer(process.stdout.read(8), np.float32)


def episode(device=None):
    """Returns the torques [N·m], (periods, 2), of the policy or of a device in its place."""
    env = gymnasium.make("ActiveSuit/ElbowFlexion-v0", gravity="earth")
    observation, _ = env.reset(seed=0)
    policy, given = make_policy("compensation", env), []
    policy.reset()
    for _ in range(PERIODS):
        torque = device.send(observation) if device else policy.act(observation) * policy.peak
        given.append(torque)
        observation, _, terminated, truncated, _ = env.step(np.clip(torque / policy.peak, -1, 1))
        if terminated or truncated:
            break
    return np.array(given)


in_c = device()
next(in_c)
python, c = episode(), episode(in_c)
in_c.close()

plt.style.use("seaborn-v0_8-whitegrid")
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
time = SECONDS * np.arange(len(python))
for joint, name, color in ((SHOULDER, "shoulder", "#1f77b4"), (ELBOW, "elbow", "#e08a1e")):
    above.plot(time, python[:, joint], color=color, lw=4, alpha=0.4, label=f"{name}, Python")
    above.plot(time, c[:, joint], color=color, lw=1.2, ls="--", label=f"{name}, C (float)")
    below.plot(time, 1e6 * (c - python)[:, joint], color=color, lw=1)
above.set(ylabel="torque of the motor [N·m]")
above.legend(ncols=2)
below.set(xlabel="time [s]", ylabel="C less Python [µN·m]")
figure.savefig("device.png", dpi=120)
print(f"largest difference {1e6 * np.abs(c - python).max():.0f} µN·m")
