"""Policies that another one corrects, and policies in rows that begin at different times."""

import numpy as np
import pytest
from activesuit.envs.making import make_arms
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.network import Residual
from activesuit.envs.policies.registry import base_of, residual_of
from activesuit.envs.policies.residual import Cohorts, ResidualPolicy, corrected
from helpers import assert_refused

SCENE = {"gravity": "microgravity", "sensors": ("encoders", "interaction")}


class Constant:
    """A policy that always does the same, and keeps what it saw."""

    def __init__(self, action):
        self.action, self.seen, self.resets = np.array(action), [], 0

    def reset(self):
        self.resets += 1

    def act(self, observation):
        self.seen.append(observation)
        return np.broadcast_to(self.action, (*observation.shape[:-1], 2))


def test_the_correction_observes_what_it_corrects():
    given = np.array([[0.5, -0.9]])  # a correction is scaled, and the sum clipped
    np.testing.assert_allclose(corrected(given, np.array([[1.0, -3.0]]), 0.3), [[0.8, -1.0]])
    base, correction = Constant([0.2, 0.4]), Constant([1.0, 0.0])
    policy = ResidualPolicy(base, correction, 0.5)
    policy.reset()
    action = policy.act(np.zeros((3, 5), np.float32))
    np.testing.assert_allclose(action, np.tile([0.7, 0.4], (3, 1)))
    np.testing.assert_allclose(correction.seen[0][:, 5:], np.tile([0.2, 0.4], (3, 1)), rtol=1e-6)
    assert (base.resets, correction.resets) == (1, 1)


@pytest.mark.parametrize("name", ["compensation", "adaptive"])
def test_rows_that_begin_anew_have_a_memory_of_their_own(name):
    """A row acts as it would alone, whenever it and its neighbours begin."""
    arms = make_arms("ActiveSuit/ArmTracking-v0", 3, autoreset_mode="Disabled", **SCENE)
    one = make_arms("ActiveSuit/ArmTracking-v0", 1, **SCENE)
    plant = Plant.of(arms.episodes)
    cohorts = Cohorts(lambda: make_policy(name, plant), 3, 2)
    alone = make_policy(name, plant)
    observation, _ = arms.reset(seed=[0, 1, 2])
    action = cohorts.begin(np.arange(3), observation)
    for period in range(30):
        if period in (7, 12):  # row 1 begins anew, at the second time as the single arm does
            mask = np.array([False, True, False])
            seeds = [None, 40 if period == 12 else 30, None]
            observation, _ = arms.reset(seed=seeds, options={"reset_mask": mask})
            action[1] = cohorts.begin(np.array([1]), observation)[0]
        if period == 12:
            single, _ = one.reset(seed=40)
            alone.reset()
            expected = alone.act(single)
        if period >= 12:
            np.testing.assert_allclose(action[1], expected[0], atol=1e-12)
            single, *_ = one.step(expected)
            expected = alone.act(single)
        observation, *_ = arms.step(action)
        action = cohorts.act(observation)


def test_a_suit_file_is_part_of_the_plain_data(tmp_path):
    from activesuit.assets import load_suit, save_suit

    save_suit(load_suit("emu-like"), tmp_path / "mine.json")
    residual = residual_of(f"compensation:suit={tmp_path / 'mine.json'}", 0.3)
    (tmp_path / "mine.json").unlink()
    again = Residual.model_validate_json(residual.model_dump_json())
    arms = make_arms("ActiveSuit/ArmTracking-v0", 2, **SCENE)
    make_policy(base_of(again), arms)


def test_policies_that_no_network_can_correct_and_cards_with_code_or_files():
    rows = [
        ("compensator", "unknown policy 'compensator'"),
        ("activesuit.envs.policies:NoAssist", "unknown policy that a network corrects"),
        ("compensation:gain=2", "unknown option of policy 'compensation'"),
    ]
    assert_refused(lambda given: residual_of(given, 0.3), rows)
    rows = [
        ({"name": "os:system"}, "unknown policy that a network corrects 'os:system'"),
        ({"name": "compensation", "suit": "/tmp/x.json"}, "a card names shipped suits"),
    ]
    assert_refused(lambda policy: base_of(Residual(policy=policy, scale=0.3)), rows)
