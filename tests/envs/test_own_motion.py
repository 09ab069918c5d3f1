"""A task with a motion of its own."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.errors import InputError


class Raise(ArmEnv):
    """The straight arm is raised for a second."""

    duration = 1.0

    def intended_motion(self, rng):
        time = np.linspace(0, self.duration, 101)
        motion = np.zeros((3, 101, 4))
        motion[:2, :, JOINTS.index("shoulder_flexion")] = 0.4 + 0.3 * time, np.full(101, 0.3)
        return tuple(motion)


def test_the_wearer_follows_it():
    env = Raise(gravity="moon")
    _, info = env.reset(seed=0)
    steps, truncated = 0, False
    while not truncated:
        _, _, terminated, truncated, info = env.step(np.zeros(2))
        assert not terminated
        steps += 1
    assert steps == 100
    assert info["target_angle"].tolist() == pytest.approx([0, 0.7, 0, 0])
    np.testing.assert_allclose(info["angle"], info["target_angle"], atol=0.05)


@pytest.mark.parametrize(
    ("angle", "message"),
    [
        (np.zeros((10, 4)), r"shape \(10, 4\), .*: give .* numbers of shape \(1001, 4\) each"),
        (np.full((1001, 4), np.nan), "finite numbers"),
        (np.full((1001, 4), [0, 0, 3, 0]), "elbow_flexion from 3 to 3 rad: stay between 0 and 2.5"),
    ],
)
def test_what_no_arm_can_do_is_refused(angle, message):
    class Impossible(ArmEnv):
        def intended_motion(self, rng):
            return angle, np.zeros_like(angle), np.zeros_like(angle)

    env = Impossible()
    with pytest.raises(InputError, match=message):
        env.reset(seed=0)
