"""A reward of a user's own, as an option of environments."""

import gymnasium
import numpy as np
import own_rewards
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.errors import InputError
from helpers import assert_refused


def shipped(terms, measured):
    return 1 / (1 + terms["effort"] + terms["tracking"] + terms["smoothness"])


def steps(env, count, motors):
    env.reset(seed=3)
    return np.array([env.step(np.full(motors, 0.3))[1] for _ in range(count)])


def test_terms_are_those_of_the_shipped_reward():
    one = steps(ArmVectorEnv(3, "ArmTracking"), 20, (3, 2))
    other = steps(ArmVectorEnv(3, "ArmTracking", reward=shipped), 20, (3, 2))
    np.testing.assert_allclose(other, one, rtol=1e-12)


def test_a_single_arm_is_a_row():
    one = steps(ArmEnv("ArmTracking", reward="own_rewards:gentle"), 10, 2)
    rows = steps(ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle), 10, (2, 2))
    np.testing.assert_array_equal(rows[:, 0], one)


def test_measurements_have_their_shapes():
    seen = {}

    def looking(terms, measured):
        seen.update({name: values.shape for name, values in measured.items()})
        return np.zeros(2)

    steps(ArmVectorEnv(2, "ArmTracking", coupling="cuffs", reward=looking), 1, (2, 2))
    assert seen["human_torque"] == (2, 4)
    assert seen["assist_torque"] == (2, 2)
    assert seen["cuff_force"] == (2, 9)
    assert seen["lost"] == (2,)
    assert "encoder_angle" not in seen  # what sensors read is no measurement of the arm


def test_the_period_in_which_the_arm_is_lost():
    env = ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle, autoreset_mode="SameStep")
    env.reset(seed=0)
    env.step(np.zeros((2, 2)))
    env.episodes.simulation.batch.bind("qpos")[1, 1] = 2.5
    _, reward, terminated, _, _ = env.step(np.zeros((2, 2)))
    assert terminated.tolist() == [False, True]
    assert reward[1] == -1.0 < reward[0]


def test_rows_that_begin_anew_have_no_reward():
    """In the mode NextStep the reward is of the rows that move."""
    env = ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle, max_episode_steps=2)
    env.reset(seed=0)
    rewards = [env.step(np.zeros((2, 2)))[1] for _ in range(3)]
    assert (rewards[1] > 0).all()
    assert (rewards[2] == 0).all()


def test_mistakes():
    rows = [
        ("own_rewards:nan", "is nan in row 0 of 1"),
        ("own_rewards:scalar", r"has the shape \(\): return \(1,\)"),
        ("own_rewards:failing", "fails .KeyError"),
        ("no_module:reward", "cannot be imported .ModuleNotFoundError"),
        (5, "the reward is 5: give a function"),
    ]
    assert_refused(lambda given: steps(ArmEnv("ArmTracking", reward=given), 1, 2), rows)


def test_scores_stay_those_of_the_shipped_reward():
    with pytest.raises(InputError, match="scores are those of the shipped reward"):
        evaluate("ActiveSuit/ArmTracking-v0", ["none"], motions=8, reward=shipped)


def test_gymnasium_makes_it_with_a_name():
    env = gymnasium.make("ActiveSuit/ArmTracking-v0", reward="own_rewards:gentle")
    env.reset(seed=0)
    assert np.isfinite(env.step(np.zeros(2))[1])
