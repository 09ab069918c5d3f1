"""Trained policies act as the learner that was saved."""

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.plant import Plant
from activesuit.envs.policies import TrainedPolicy
from activesuit.envs.policies.network import algorithm_class
from activesuit.errors import InputError
from trained_runs import make_run

pytest.importorskip("stable_baselines3")


@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_acts_as_the_learner(tmp_path, algo):
    run = make_run(tmp_path / "run", algo)
    env = ArmEnv("ElbowFlexion", gravity="moon")
    policy = TrainedPolicy(run, Plant.of(env.episodes))
    whole = algorithm_class(algo).load(run / "model.zip", device="cpu")
    observation, _ = env.reset(seed=3)
    for _ in range(20):
        action = policy.act(observation)
        expected, _ = whole.predict(observation, deterministic=True)
        np.testing.assert_array_equal(action, expected)
        observation, *_ = env.step(action)


def test_an_environment_that_shows_more(tmp_path):
    run = make_run(tmp_path / "run")
    arm = ArmEnv("ElbowFlexion", sensors=["encoders", "preview"])
    with pytest.raises(InputError, match=r"observes 12 numbers .* shows 18: give it the sensors"):
        TrainedPolicy(run, Plant.of(arm.episodes))
