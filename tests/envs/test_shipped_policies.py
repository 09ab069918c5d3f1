"""The trained networks that ship: small, complete, and able to act where they say."""

from pathlib import Path

import numpy as np
import pytest
from activesuit.envs.making import make_arms
from activesuit.envs.policies import POLICIES, make_policy, needed_options, policy_spec
from activesuit.envs.policies.network import read_card
from activesuit.envs.policies.trained import shipped_policies
from activesuit.scripts.main import main

LARGEST = 200_000  # bytes


def test_names_are_their_own():
    assert not {*shipped_policies()} & {*POLICIES}
    assert {"plain-network", "residual-network"} <= {*shipped_policies()}


@pytest.mark.parametrize("name", shipped_policies())
def test_each_is_complete(name):
    folder = Path(shipped_policies()[name])
    assert sum(path.stat().st_size for path in folder.iterdir()) < LARGEST
    card = read_card(folder)
    assert card.license == "Apache-2.0"
    assert card.summary
    assert card.scores and card.scores["relief"]["low"] <= card.scores["relief"]["value"]
    assert len(card.training["best_of_seeds"]) >= 5
    assert card.versions["activesuit"]


@pytest.mark.parametrize("name", shipped_policies())
def test_each_acts_by_its_name(name):
    arms = make_arms("ActiveSuit/ElbowFlexion-v0", 2, suit="emu-like", **needed_options(name))
    policy = make_policy(name, arms)
    observation, _ = arms.reset(seed=0)
    policy.reset()
    for _ in range(20):
        action = policy.act(observation)
        assert action.shape == (2, 2)
        assert np.abs(action).max() <= 1
        observation, *_ = arms.step(action)


def test_the_scene_is_free(capsys):
    """A shipped network brings its sensors, and not the task of its training."""
    given = ["evaluate", "--task", "ElbowFlexion", "--episodes", "8", "--unadapted"]
    main([*given, "--policies", "residual-network"])
    assert "residual-network" in capsys.readouterr().out
    assert str(policy_spec("residual-network")) == "residual-network"


def test_the_list_of_policies_has_them(capsys):
    main(["policies"])
    said = capsys.readouterr().out
    assert all(name in said for name in shipped_policies())
