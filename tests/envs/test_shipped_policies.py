"""Trained networks that ship are policies by their names, in any scene with their sensors."""

import json

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy, needed_options, policy_spec, trained
from activesuit.envs.policies.network import read_card
from activesuit.envs.policies.trained import SHIPPED
from activesuit.errors import InputError
from activesuit.scripts.main import main
from helpers import short_benchmark
from trained_runs import make_run

pytest.importorskip("stable_baselines3")


@pytest.fixture(autouse=True)
def shipped(tmp_path, monkeypatch):
    """A network of this name ships."""
    make_run(tmp_path / "my-network")
    card = tmp_path / "my-network" / "policy.json"
    card.write_text(json.dumps({**json.loads(card.read_text()), "summary": "It does little."}))
    monkeypatch.setattr(trained, "SHIPPED", tmp_path)


def test_it_acts_by_its_name():
    arms = make_arms(
        "ActiveSuit/ArmTracking-v0", 2, suit="emu-like", **needed_options("my-network")
    )
    policy = make_policy("my-network", arms)
    observation, _ = arms.reset(seed=0)
    action = policy.act(observation)
    assert action.shape == (2, 2)
    assert np.abs(action).max() <= 1
    assert str(policy_spec("my-network")) == "my-network"


def test_the_scene_is_free(capsys):
    """It brings its sensors, and not the task and the place of its training."""
    given = ["evaluate", "--task", "ArmTracking", "--motions", "8", "--unadapted"]
    main([*given, "--policies", "my-network"])
    assert "my-network" in capsys.readouterr().out


@pytest.mark.slow
def test_the_benchmark_has_its_sensors(tmp_path):
    given = ["benchmark", "run", "--tasks", "ElbowFlexion", "--levels", "nominal", "--motions"]
    given += ["8", "--believed", "emu-like", "--workers", "1", "--backend", "threading"]
    with short_benchmark(1.0):
        main([*given, "--policies", "my-network", "--out", str(tmp_path / "run")])
    assert "| my-network | encoders |" in (tmp_path / "run" / "tables.md").read_text()


def test_what_it_observes_cannot_be_given_beside_it(capsys):
    given = ["evaluate", "--task", "ArmTracking", "--policies", "my-network"]
    with pytest.raises(SystemExit):
        main([*given, "--history", "3"])
    assert "what a policy observes follows from the policy" in capsys.readouterr().err


def test_the_list_of_policies_has_it(capsys):
    main(["list", "policies"])
    assert "It does little." in capsys.readouterr().out


def test_an_unknown_name_is_answered_with_it():
    with pytest.raises(InputError, match="my-network"):
        policy_spec("my-net-work")


def test_it_has_no_options():
    with pytest.raises(InputError, match="has no options"):
        policy_spec("my-network:gain=2")


@pytest.fixture
def really_shipped(monkeypatch):
    monkeypatch.setattr(trained, "SHIPPED", SHIPPED)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.name for path in SHIPPED.iterdir()))
def test_what_ships_is_small_and_relieves(name, really_shipped):
    folder = SHIPPED / name
    assert {path.name for path in folder.iterdir()} == {"policy.json", "policy.safetensors"}
    assert sum(path.stat().st_size for path in folder.iterdir()) < 200_000
    card = read_card(folder)
    assert card.license == "Apache-2.0"
    assert len(card.training["best_of_seeds"]) >= 3
    assert card.summary.endswith(".")
    found = evaluate(
        "ActiveSuit/ArmTracking-v0", ["none", name], motions=8, max_episode_steps=300, threads=1
    )
    assert found.relief(name).low > found.relief("none").high
