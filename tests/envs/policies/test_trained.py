"""Trained policies act as the learner that was saved, by NumPy alone; some ship by a name."""

import json
import sys
from importlib.metadata import PackageNotFoundError

import gymnasium
import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.making import make_arms
from activesuit.envs.policies import (
    Network,
    make_policy,
    needed_options,
    policy_spec,
    save_policy,
    trained,
)
from activesuit.envs.policies.network import read_card
from activesuit.envs.policies.saving import network_of
from activesuit.envs.policies.trained import SHIPPED
from activesuit.envs.sb3 import ArmVecEnv
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.scripts.training.hyperparameters import ALGORITHMS, algorithm_class
from helpers import assert_refused, fails, run
from trained_runs import make_run, write_network

pytest.importorskip("stable_baselines3")


OPTIONS = {"gravity": "moon", "sensors": ("encoders", "preview"), "history": 2, "normalize": True}
SMALL = {
    "ppo": {"n_steps": 16, "batch_size": 16, "use_sde": True},
    "recurrent-ppo": {"n_steps": 16, "batch_size": 16},
    "sac": {"buffer_size": 100, "learning_starts": 8},
    "tqc": {"buffer_size": 100, "learning_starts": 8},
}


@pytest.fixture(scope="module", params=ALGORITHMS)
def saved(request, tmp_path_factory):
    """A learner of each kind that has learned a little, its folder, and rows of arms."""
    algo = request.param
    arms = ArmVectorEnv(3, "ArmTracking", autoreset_mode="SameStep", **OPTIONS)
    policy = "MlpLstmPolicy" if algo == "recurrent-ppo" else "MlpPolicy"
    env = ArmVecEnv(arms)
    model = algorithm_class(algo)(policy, env, seed=3, device="cpu", **SMALL[algo])
    model.learn(60)
    folder = tmp_path_factory.mktemp("saved") / algo
    save_policy(model, folder, env)
    yield model, folder, arms
    arms.close()


def test_acts_as_the_learner_in_rows_and_in_single_arms(saved):
    model, folder, arms = saved
    observed = {"sensors": ["encoders", "preview"], "history": 2, "normalize": True}
    assert needed_options(str(folder)) == {**observed, "belief": None}
    policy = make_policy(str(folder), arms)
    one = make_policy(str(folder), ArmEnv("ArmTracking", **OPTIONS))
    for seed in (5, 6):
        observation, _ = arms.reset(seed=seed)
        policy.reset()
        one.reset()
        state, begin = None, np.ones(3, bool)
        for _ in range(10):
            expected, state = model.predict(observation, state, begin, deterministic=True)
            action = policy.act(observation)
            np.testing.assert_allclose(action, expected, rtol=0, atol=1e-6)
            np.testing.assert_allclose(one.act(observation[1]), action[1], atol=1e-12)
            observation, *_ = arms.step(action)
            begin = np.zeros(3, bool)


def test_a_mean_action_that_the_learner_squashes():
    arms = ArmVecEnv(ArmVectorEnv(3, "ArmTracking", autoreset_mode="SameStep"))
    make = algorithm_class("ppo")
    squashed = {"squash_output": True, "net_arch": [4]}
    model = make("MlpPolicy", arms, seed=3, use_sde=True, policy_kwargs=squashed, device="cpu")
    model.policy.action_net.weight.data *= 100
    seen, network = arms.reset(), network_of(model)
    expected, _ = model.predict(seen, deterministic=True)
    assert abs(expected).max() > 0.3  # where tanh differs
    given = network.act(seen, network.memory(len(seen)))
    np.testing.assert_allclose(given, expected, rtol=0, atol=1e-6)
    arms.close()


def layers(*sizes):
    rng, found = np.random.default_rng(0), {}
    for i, (size, before) in enumerate(zip(sizes[1:], sizes, strict=False)):
        found[f"layer.{i}.weight"] = rng.normal(size=(size, before)).astype(np.float32)
        found[f"layer.{i}.bias"] = np.zeros(size, np.float32)
    return found


def changed(**more):
    return {**layers(12, 8, 2), **{name.replace("_", "."): one for name, one in more.items()}}


def test_networks_that_do_not_fit_together():
    rows = [
        ({}, "no layer.0.weight: add this array"),
        (changed(layer_1_bias=[0.0, 0.0]), "give an array of NumPy with 1 dimensions"),
        (changed(layer_1_bias=np.zeros(2, int)), "float32 or float64"),
        (changed(layer_1_bias=np.zeros(3)), r"layer.1.bias has the shape \(3,\)"),
        (changed(layer_0_weight=np.full((8, 12), np.nan)), "values that are not finite"),
        (changed(lstm_hidden=np.zeros((16, 4))), "no lstm.input"),
        ({"layer.0.weight": np.zeros((2, 12))}, "no layer.0.bias"),
    ]
    assert_refused(Network, rows)


def damaged_card(run, **changes):
    path = run / "policy.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


def test_damaged_policies(tmp_path):
    def cut(run):
        weights = run / "policy.safetensors"
        weights.write_bytes(weights.read_bytes()[:-9])

    other = Network(layers(5, 2), "tanh", squashed=False)
    rows = [
        (lambda run: (run / "policy.safetensors").unlink(), "no finished policy.safetensors"),
        (lambda run: damaged_card(run, weights="0" * 64), "do not belong together"),
        (cut, "do not belong together"),
        (lambda run: damaged_card(run, format=2), "its format is wrong"),
        (lambda run: damaged_card(run, contract="0" * 12), "is not that of its observation"),
        (lambda run: write_network(run, other), "5 inputs and 2 outputs, and its card says 12 and"),
        (lambda run: (run / "policy.json").write_text("{"), "not complete JSON"),
    ]
    env = ArmEnv("ElbowFlexion", gravity="moon")
    for i, (damage, message) in enumerate(rows):
        run = make_run(tmp_path / str(i))
        damage(run)
        assert_refused(make_policy, [(str(run), env, message)])
    rows = [(layers(12, 2), "elu", "unknown activation 'elu': use one of relu, tanh")]
    assert_refused(Network, rows)


def test_models_that_make_no_policy(tmp_path):
    import torch
    from stable_baselines3 import PPO, TD3
    from stable_baselines3.common.vec_env import VecNormalize

    arms = ArmVectorEnv(2, "ArmTracking", autoreset_mode="SameStep")
    env, small = ArmVecEnv(arms), {"n_steps": 8, "batch_size": 8, "device": "cpu"}
    (tmp_path / "file").write_text("")
    folder, ppo = tmp_path / "policy", PPO("MlpPolicy", env, **small)
    elu = PPO("MlpPolicy", env, policy_kwargs={"activation_fn": torch.nn.ELU}, **small)
    rows = [
        (TD3("MlpPolicy", env, buffer_size=10), folder, env, "no PPO or SAC"),
        (PPO("MlpPolicy", VecNormalize(env), **small), folder, env, "use normalize=True instead"),
        (elu, folder, env, "Linear, ELU, Linear, ELU, Linear: use Linear layers"),
        (ppo, folder, gymnasium.make("CartPole-v1"), "give the ActiveSuit environment"),
        (ppo, tmp_path / "file" / "policy", env, "cannot make the folder"),
    ]
    assert_refused(save_policy, rows)
    assert not folder.exists()


@pytest.mark.parametrize(("activation", "squashed"), [("Tanh", False), ("ReLU", True)])
def test_a_network_of_torch_is_a_policy(tmp_path, activation, squashed):
    import torch
    from torch import nn

    torch.manual_seed(0)
    between, end = getattr(nn, activation), [nn.Tanh()] if squashed else []
    actor = nn.Sequential(nn.Linear(12, 8), between(), nn.Linear(8, 2), *end)
    arms = ArmVectorEnv(3, "ArmTracking")
    save_policy(actor, tmp_path / "policy", arms)
    observation, _ = arms.reset(seed=0)
    expected = actor(torch.as_tensor(observation)).clamp(-1, 1).detach().numpy()
    found = make_policy(str(tmp_path / "policy"), arms).act(observation)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_a_network_of_arrays_is_a_policy_without_any_learner(tmp_path, monkeypatch):
    def only_ours(name):
        if name in ("torch", "stable-baselines3"):
            raise PackageNotFoundError(name)
        return "1.0"

    for name in ("torch", "stable_baselines3"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr("activesuit.envs.policies.saving.version", only_ours)
    env, network = ArmEnv("ArmTracking", gravity="moon"), Network(layers(12, 8, 2))
    save_policy(network, tmp_path / "policy", env)
    observation, _ = env.reset(seed=0)
    found = make_policy(str(tmp_path / "policy"), env).act(observation)
    np.testing.assert_array_equal(found, network.act(observation[None], network.memory(1))[0])
    card = json.loads((tmp_path / "policy" / "policy.json").read_text())
    assert card["training"] == {"algo": "Network"}
    assert set(card["versions"]) == {"activesuit", "gymnasium", "mujoco", "numpy"}


def test_networks_that_make_no_policy(tmp_path):
    from torch import nn

    rows = [
        (nn.Sequential(nn.Linear(12, 8), nn.Linear(8, 2)), "its parts are Linear, Linear: use"),
        (nn.Sequential(nn.Linear(12, 8), nn.ELU(), nn.Linear(8, 2)), "parts are Linear, ELU"),
        (nn.Sequential(nn.Linear(12, 8), nn.Tanh(), nn.Linear(8, 2), nn.ReLU()), "use Linear"),
        (nn.Sequential(nn.Linear(12, 2, bias=False)), "use Linear layers with bias"),
        (nn.Sequential(), "its parts are none"),
        (nn.Linear(12, 2), "of this Linear: it is no PPO"),
        ("my-policy", "of this str: it is no PPO"),
        (nn.Sequential(nn.Linear(12, 4)), "12 inputs and 4 outputs, and the environment 12"),
        (Network(layers(30, 2)), "30 inputs and 2 outputs"),
    ]
    env = ArmEnv("ArmTracking")
    assert_refused(lambda network: save_policy(network, tmp_path / "policy", env), rows)
    assert not (tmp_path / "policy").exists()


def test_a_belief_of_a_file_is_part_of_the_card(tmp_path):
    from stable_baselines3 import PPO

    load_suit("emu-like").save(tmp_path / "mine.json")
    seen = {"sensors": ("encoders", "belief"), "belief": {"suit": str(tmp_path / "mine.json")}}
    arms = ArmVectorEnv(2, "ArmTracking", autoreset_mode="SameStep", **seen)
    env = ArmVecEnv(arms)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=8, device="cpu")
    save_policy(model, tmp_path / "policy", env)
    (tmp_path / "mine.json").unlink()
    needed = needed_options(str(tmp_path / "policy"))
    again = ArmVectorEnv(2, "ArmTracking", **needed)
    make_policy(str(tmp_path / "policy"), again).act(again.reset(seed=0)[0])


pytest.importorskip("stable_baselines3")


@pytest.fixture
def shipped(tmp_path, monkeypatch):
    """A network of this name ships."""
    make_run(tmp_path / "my-network")
    card = tmp_path / "my-network" / "policy.json"
    card.write_text(json.dumps({**json.loads(card.read_text()), "summary": "It does little."}))
    monkeypatch.setattr(trained, "SHIPPED", tmp_path)


def test_it_acts_by_its_name_in_any_scene(shipped, capsys):
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
def test_what_ships_is_small_and_relieves(name):
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
