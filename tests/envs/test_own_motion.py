"""A task with a motion of its own."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv, Task


class Raise(Task):
    """The straight arm is raised for a second."""

    def motion(self, rng, samples, dt):
        time = dt * np.arange(samples)
        motion = np.zeros((3, samples, 4))
        motion[:2, :, JOINTS.index("shoulder_flexion")] = 0.4 + 0.3 * time, np.full(samples, 0.3)
        return tuple(motion)


def test_the_wearer_follows_it():
    env = ArmEnv(Raise(name="Raise", duration=1.0), gravity="moon")
    _, info = env.reset(seed=0)
    steps, truncated = 0, False
    while not truncated:
        _, _, terminated, truncated, info = env.step(np.zeros(2))
        assert not terminated
        steps += 1
    assert steps == 100
    assert info["target_angle"].tolist() == pytest.approx([0, 0.7, 0, 0])
    np.testing.assert_allclose(info["angle"], info["target_angle"], atol=0.08)
