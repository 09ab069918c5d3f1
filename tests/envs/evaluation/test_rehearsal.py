"""A policy meets each motion that is scored for the first time, and only by its sensors."""

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from helpers import assert_refused

ELBOW = "ActiveSuit/ElbowFlexion-v0"
FEW = {"motions": 2, "references": False, "max_episode_steps": 100}


class Rehearses:
    """Remembers what it saw of a motion, to know it in the next rollout."""

    def __init__(self, plant):
        self.angle, self.known, self.seen = plant.layout["angle"], None, []

    def reset(self):
        self.known, self.seen = np.array(self.seen) if self.seen else None, []

    def act(self, observation):
        self.seen.append(observation[..., self.angle].copy())
        known = 0.0 if self.known is None else 0.5  # a plan of the whole motion would stand here
        return np.full((*observation.shape[:-1], 2), known)


class Practices:
    """Counts its rollouts, and learns in those of practice."""

    practice = 3
    counts: list

    def __init__(self, plant):
        self.rollouts = 0

    def reset(self):
        self.rollouts += 1
        type(self).counts.append(self.rollouts)

    def act(self, observation):
        return np.zeros((*observation.shape[:-1], 2))


def test_a_rehearsal_is_worth_nothing():
    found = evaluate(ELBOW, {"off": "none", "rehearsed": Rehearses}, **FEW).scores
    assert found["rehearsed"].effort == found["off"].effort
    assert found["rehearsed"].assist_energy == found["off"].assist_energy


def test_a_look_at_the_intention_is_refused():
    ways = ("episodes", "unwrapped", "simulation", "get_state")
    rows = [(way, f"a policy asks for '{way}' of the environment: it gets") for way in ways]
    assert_refused(
        lambda way: evaluate(ELBOW, {"peek": lambda plant: getattr(plant, way)}, **FEW), rows
    )


def test_practice_is_on_other_motions_and_kept():
    Practices.counts = []
    evaluate(ELBOW, {"practiced": Practices}, **FEW)
    # Three rollouts of practice; each of the four after them gets a copy that practiced.
    assert Practices.counts == [1, 2, 3, 4, 4, 4, 4]


def test_the_plant_says_what_a_controller_may_know():
    env = ArmEnv("ArmTracking", sensors=["encoders", "interaction"], suit="emu-like")
    plant = Plant.of(env.episodes)
    assert plant.layout == env.layout and plant.peak.tolist() == [40.0, 25.0]
    assert (plant.dt, plant.motors, plant.assisted.tolist()) == (0.01, 2, [1, 2])
    plant.peak[:] = 0  # a copy
    assert Plant.of(env.episodes).peak.tolist() == [40.0, 25.0]
    observation, _ = env.reset(seed=0)
    plant = Plant.of(env.episodes)
    one, other = make_policy("compensation", plant), make_policy("compensation", env)
    np.testing.assert_array_equal(one.act(observation), other.act(observation))
    assert not hasattr(plant, "intention")
