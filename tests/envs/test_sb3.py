"""Rows of arms for Stable-Baselines3: the episodes of its own DummyVecEnv."""

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from helpers import assert_refused

pytest.importorskip("stable_baselines3")

from activesuit.envs.sb3 import ArmVecEnv
from activesuit.envs.vector_env import ArmVectorEnv
from gymnasium.wrappers import TimeLimit
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecMonitor, VecNormalize

ROWS, SHORT = 3, 11


def pair():
    """Returns the same rows twice: as one environment, and as single ones one after the other."""
    options = {"max_episode_steps": SHORT, "autoreset_mode": "SameStep"}
    ours = ArmVecEnv(ArmVectorEnv(ROWS, "ElbowFlexion", threads=1, **options))
    theirs = DummyVecEnv([lambda: TimeLimit(ArmEnv("ElbowFlexion"), SHORT)] * ROWS)
    for env in (ours, theirs):
        env.seed(4)
    return ours, theirs


@pytest.mark.parametrize(
    "wrap",
    [lambda env: env, lambda env: VecFrameStack(env, 3), lambda env: VecNormalize(VecMonitor(env))],
    ids=["bare", "stack", "both"],
)
def test_it_is_what_single_ones_are(wrap):
    ours, theirs = (wrap(env) for env in pair())
    np.testing.assert_array_equal(ours.reset(), theirs.reset())
    rng, ends = np.random.default_rng(0), 0
    for _ in range(3 * SHORT + 2):
        actions = rng.uniform(-1, 1, (ROWS, 2)).astype(np.float32)
        one, other = ours.step(actions), theirs.step(actions)
        for a, b in zip(one[:3], other[:3], strict=True):
            np.testing.assert_array_equal(a, b)
        for reported, expected, done in zip(one[3], other[3], one[2], strict=True):
            if done:
                ends += 1
                last = (info["terminal_observation"] for info in (reported, expected))
                np.testing.assert_array_equal(*last)
                assert reported["TimeLimit.truncated"] == expected["TimeLimit.truncated"]
                if "episode" in reported:
                    assert reported["episode"]["l"] == expected["episode"]["l"]
                    assert reported["episode"]["r"] == expected["episode"]["r"]
            else:
                assert not {"terminal_observation", "episode"} & set(reported)
    assert ends == 3 * ROWS


def test_one_seed_for_every_row():
    ours = VecMonitor(pair()[0])
    assert ours.seed([7, 5, 9]) == [7, 5, 9]
    ours.reset()
    assert ours.unwrapped.arms.get_state()["seed"].tolist() == [7, 5, 9]
    assert ours.seed(np.int64(4)) == [4, 5, 6]
    ours.seed([7, 5])
    assert_refused(ours.reset, [("seed has 2 numbers: give one for each of 3 rows",)])


def test_ppo_learns_and_is_evaluated_in_it(tmp_path):
    ours, _ = pair()
    message = "autoreset_mode is 'NextStep': Stable-Baselines3 needs"
    assert_refused(ArmVecEnv, [(ArmVectorEnv(2), message)])
    options = {"max_episode_steps": SHORT, "autoreset_mode": "SameStep"}
    check = ArmVecEnv(ArmVectorEnv(2, "ElbowFlexion", **options))
    learner = PPO("MlpPolicy", VecMonitor(ours), n_steps=16, batch_size=48, device="cpu", seed=0)
    callback = EvalCallback(VecMonitor(check), n_eval_episodes=3, eval_freq=16, verbose=0)
    learner.learn(96, callback=callback)
    assert learner.num_timesteps == 96
    assert np.isfinite(callback.last_mean_reward)


def test_attributes_and_methods_are_of_all_rows():
    ours, _ = pair()
    assert ours.get_attr("num_envs") == [ROWS] * ROWS
    assert ours.get_attr("control_dt", [0, 2]) == [0.01] * 2
    ours.set_attr("remark", "here")
    assert ours.get_attr("remark", 1) == ["here"]
    assert ours.env_is_wrapped(TimeLimit) == [False] * ROWS
    ours.reset()
    assert len(ours.env_method("get_state")) == ROWS
    ours.set_options({"speed": 1})
    rows = [
        (lambda: ours.env_method("get_state", indices=[0]), r"the indices \[0\]: all rows are one"),
        (lambda: ours.set_attr("remark", "there", 1), "set_attr got the indices 1"),
        (ours.reset, "reset got the options {'speed': 1}: there are no such options"),
    ]
    assert_refused(lambda call: call(), rows)
