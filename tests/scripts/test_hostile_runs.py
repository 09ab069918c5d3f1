"""Run folders and policy files of somebody else: they run no code and end in one sentence."""

import json
import sys

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks
from trained_runs import (
    make_run,
    poison_data,
    poison_replay,
    poison_weights,
    replace_part,
    write_card,
    write_network,
)

pytest.importorskip("stable_baselines3")


@pytest.fixture
def foreign(tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 1.0)
    return make_run(tmp_path / "foreign")


def answer(capsys, *arguments) -> str:
    """Runs a command; returns its error message, or "" if it has none."""
    try:
        main([str(argument) for argument in arguments])
    except SystemExit as stop:
        assert stop.code == 2
        return capsys.readouterr().err.strip().splitlines()[-1]
    return ""


COMMANDS = {
    "evaluate": ["evaluate", "--unadapted", "--motions", "8", "--policies", "{run}"],
    "simulate": ["simulate", "--policy", "{run}", "--out", "{tmp}/out"],
    "view": ["view", "--policy", "{run}"],
    "resume": ["train", "--resume", "--steps", "2048", "--out", "{run}"],
}


@pytest.mark.parametrize("poison", [poison_data, poison_weights, poison_replay])
@pytest.mark.parametrize("command", ["evaluate", "simulate", "view", "resume"])
@pytest.mark.usefixtures("undrawn")
def test_no_code_of_a_run_is_run(capsys, tmp_path, monkeypatch, foreign, command, poison):
    monkeypatch.delenv("DISPLAY", raising=False)
    trap = tmp_path / "trap"
    poison(foreign, trap)
    before = sorted(path.name for path in foreign.iterdir())
    arguments = [one.format(run=foreign, tmp=tmp_path) for one in COMMANDS[command]]
    said = answer(capsys, *arguments)
    assert not trap.exists()
    if command == "resume":
        assert "add --trust if you trust whoever made it" in said
        assert sorted(path.name for path in foreign.iterdir()) == before
    elif poison is poison_weights:
        assert "is not a readable network" in said
    elif command != "view":
        assert said == ""


@pytest.mark.parametrize("poison", [poison_data, poison_replay])
def test_trust_means_what_it_says(capsys, tmp_path, foreign, poison):
    trap = tmp_path / "trap"
    poison(foreign, trap)
    answer(capsys, "train", "--resume", "--trust", "--steps", "64", "--out", foreign)
    assert trap.exists() == (poison is poison_data)  # PPO has no experience to read


OPTIONS = [  # of an environment
    ("env", 1, "has the env 1"),
    ("knee", 1, "unknown option"),
    ("reward", "enemy:reward", "unknown option"),
    ("randomize", {"suits": ["/etc/passwd"]}, "unknown option"),
    ("exo", 1, "exo is 1"),
    ("fatigue", "much", "fatigue is 'much'"),
    ("payload", {"mass": float("nan")}, "payload"),
    ("gravity", "venus", "unknown gravity"),
    ("env", "ActiveSuit/Knee-v0", "unknown environment"),
    ("env", "CartPole-v1", "is no arm of ActiveSuit"),
]
OF_TRAINING = [("algo", "dqn", "unknown algo"), ("steps", True, "has steps True")]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["evaluate", "simulate", "resume"])
@pytest.mark.usefixtures("undrawn")
def test_damaged_card(capsys, tmp_path, foreign, command):
    path, resumes = foreign / "policy.json", command == "resume"
    whole = path.read_text()
    arguments = [one.format(run=foreign, tmp=tmp_path) for one in COMMANDS[command]]
    arguments += ["--trust"] if resumes else []
    for name, value, message in OPTIONS + OF_TRAINING:
        of_training = (name, value, message) in OF_TRAINING
        card = json.loads(whole)
        card["training" if of_training else "environment"][name] = value
        path.write_text(json.dumps(card))
        said = answer(capsys, *arguments)
        if resumes or not of_training:  # a policy acts without the numbers of its training
            assert message in said
            assert not (tmp_path / "out").exists()
        else:
            assert said == "" or "is not empty" in said


def test_a_module_named_by_somebody_else_is_not_imported(capsys, tmp_path, monkeypatch, foreign):
    trap = tmp_path / "trap"
    (tmp_path / "enemy.py").write_text(f"open({str(trap)!r}, 'w').close()")
    monkeypatch.syspath_prepend(tmp_path)
    write_card(foreign, env="enemy:ActiveSuit/ElbowFlexion-v0")
    said = answer(capsys, "evaluate", "--policies", foreign)
    assert "add --env enemy:ActiveSuit/ElbowFlexion-v0 if that module may be imported" in said
    assert not trap.exists()


def test_weights_that_are_no_numbers(capsys, tmp_path, foreign):
    from activesuit.envs.policies.network import read_card, read_network

    network = read_network(foreign, read_card(foreign))
    next(iter(network.weights.values()))[0] = float("nan")
    write_network(foreign, network)
    arguments = [one.format(run=foreign, tmp=tmp_path) for one in COMMANDS["evaluate"]]
    assert "values that are not finite" in answer(capsys, *arguments)


def test_a_bomb_in_the_weights(capsys, foreign):
    (foreign / "policy.safetensors").write_bytes(bytes(60_000_000))
    assert "is longer than" in answer(capsys, "evaluate", "--policies", foreign)


def test_foreign_experience(capsys, tmp_path):
    run = make_run(tmp_path / "sac", "sac")
    before = json.loads((run / "policy.json").read_text())
    arguments = ["train", "--resume", "--trust", "--steps", "64", "--out", run]
    assert "(\"There is no item named 'replay.pkl' in the archive\")" in answer(capsys, *arguments)
    replace_part(run / "model.zip", "replay.pkl", b"nothing")
    assert "is not a readable checkpoint" in answer(capsys, *arguments)
    assert json.loads((run / "policy.json").read_text()) == before


POLICY = """
import pathlib
pathlib.Path("imported").touch()

class Sneaky:
    def __init__(self, env):
        pass

    def reset(self):
        pass

    def act(self, observation):
        return 0 * observation[..., :2]
"""
OF_FILES = [
    "simulate --out out --policy",
    "evaluate --motions 8 --unadapted --out out --policies",
    "benchmark run --tasks ElbowFlexion --levels nominal --motions 8 --out out --policies",
    "view --film film.gif --policy",
    "view --policy",
]


@pytest.fixture
def policy_file(tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 1.0)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "sneaky.py").write_text(POLICY)
    (tmp_path / "foreign.json").write_text(json.dumps({"name": "sneaky:Sneaky"}))
    yield "foreign.json"
    sys.modules.pop("sneaky", None)


@pytest.mark.parametrize("command", OF_FILES)
def test_no_code_of_a_file_is_run(capsys, tmp_path, policy_file, command):
    sys.path.append(str(tmp_path))  # the module can be found all the same
    message = answer(capsys, *command.split(), policy_file)
    assert "'foreign.json' names 'sneaky:Sneaky', and importing that would run its code" in message
    assert "add --trust" in message
    assert sorted(path.name for path in tmp_path.iterdir()) == ["foreign.json", "sneaky.py"]


@pytest.mark.parametrize("command", OF_FILES[:2])
def test_a_trusted_file_is_taken(tmp_path, policy_file, command):
    main([*command.split(), policy_file, "--trust"])
    assert (tmp_path / "imported").exists()


def test_a_class_on_the_command_line_needs_no_trust(tmp_path, policy_file):
    main(["simulate", "--out", "out", "--policy", "sneaky:Sneaky"])
    assert (tmp_path / "imported").exists()
