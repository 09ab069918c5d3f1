"""Software in the loop: the C code of a policy runs beside the simulated arm, through a pipe.

activesuit export compensation --c --out compensation.h
cc -std=c99 -O2 -DACTIVESUIT_FLOAT control.c -o control -lm
python loop.py
"""

import subprocess

import numpy as np
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import TorquePolicy


class OnDevice(TorquePolicy):
    """Gets the torques of each arm from a process of its own, as from a device."""

    devices: tuple = ()

    def begin(self, seen):
        """Starts a process for each arm; those of the last episode end where their input ends."""
        for device in self.devices:
            device.communicate()
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self.devices = tuple(subprocess.Popen("./control", **pipes) for _ in seen["angle"])

    def torque(self, seen):
        """Sends angles [rad] and rates [rad/s] to the processes; returns their torques [N·m]."""
        messages = np.hstack([seen["angle"], seen["rate"]]).astype(np.float32)
        for device, message in zip(self.devices, messages, strict=True):
            device.stdin.write(message.tobytes())
            device.stdin.flush()
        return np.array([np.frombuffer(one.stdout.read(8), np.float32) for one in self.devices])


if __name__ == "__main__":
    policies = ["compensation", "loop:OnDevice"]
    options = {"motions": 8, "seed": 10_000, "apart": False}  # a policy may begin no process apart
    found = evaluate("ActiveSuit/ElbowFlexion-v0", policies, gravity="earth", **options)
    for policy in policies:
        print(f"{policy}: relief {found.relief(policy)}")
