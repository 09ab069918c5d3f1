"""Trained networks that ship are policies by their names, in any scene with their sensors."""

import json

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy, needed_options, policy_spec, trained
from activesuit.envs.policies.network import read_card
from activesuit.envs.policies.trained import SHIPPED
from helpers import assert_refused, fails, run
from trained_runs import make_run

pytest.importorskip("stable_baselines3")


@pytest.fixture(autouse=True)
def shipped(tmp_path, monkeypatch):
    """A network of this name ships."""
    make_run(tmp_path / "my-network")
    card = tmp_path / "my-network" / "policy.json"
    card.write_text(json.dumps({**json.loads(card.read_text()), "summary": "It does little."}))
    monkeypatch.setattr(trained, "SHIPPED", tmp_path)


def test_it_acts_by_its_name_in_any_scene(capsys):
    """It brings its sensors, and not the task and the place of its training."""
    needed = needed_options("my-network")
    arms = make_arms("ActiveSuit/ArmTracking-v0", 2, suit="emu-like", **needed)
    policy = make_policy("my-network", arms)
    action = policy.act(arms.reset(seed=0)[0])
    assert action.shape == (2, 2) and np.abs(action).max() <= 1
    assert str(policy_spec("my-network")) == "my-network"
    rows = [("my-net-work", "my-network"), ("my-network:gain=2", "has no options")]
    assert_refused(policy_spec, rows)
    given = ["evaluate", "--task", "ArmTracking", "--policies", "my-network"]
    assert "my-network" in run(capsys, *given, "--motions", "8", "--unadapted")
    assert "It does little." in run(capsys, "list", "policies")
    observed = fails(capsys, *given, "--history", "3")
    assert "what a policy observes follows from the policy" in observed


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.name for path in SHIPPED.iterdir()))
def test_what_ships_is_small_and_relieves(name, monkeypatch):
    monkeypatch.setattr(trained, "SHIPPED", SHIPPED)
    folder = SHIPPED / name
    assert {path.name for path in folder.iterdir()} == {"policy.json", "policy.safetensors"}
    assert sum(path.stat().st_size for path in folder.iterdir()) < 200_000
    card = read_card(folder)
    assert card.license == "Apache-2.0"
    assert len(card.training["best_of_seeds"]) >= 3
    assert card.summary.endswith(".")
    short = {"motions": 8, "max_episode_steps": 300, "threads": 1}
    found = evaluate("ActiveSuit/ArmTracking-v0", ["none", name], **short)
    assert found.relief(name).low > found.relief("none").high
