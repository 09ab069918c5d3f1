"""Run folders of somebody else: they run no code and end in one sentence."""

import io
import json
import sys

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks
from trained_runs import (
    learner,
    make_run,
    poison_data,
    poison_replay,
    poison_weights,
    replace_part,
    write_config,
)

pytest.importorskip("stable_baselines3")


@pytest.fixture(autouse=True)
def this_machine(tmp_path_factory, monkeypatch):
    """Keeps the notes of what this machine wrote out of the user's own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))


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
    "evaluate": ["evaluate", "--unadapted", "--episodes", "8", "--policies", "{run}"],
    "simulate": ["simulate", "--policy", "{run}", "--out", "{tmp}/out"],
    "animate": ["animate", "--policy", "{run}", "--out", "{tmp}/film.mp3"],
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
        assert "is not a readable policy" in said
    elif command != "view":
        assert said == ""


def test_animate_runs_no_code_either(capsys, tmp_path, monkeypatch, foreign):
    from activesuit.scripts.commands import animate

    monkeypatch.setattr(animate, "_film", lambda *given, **more: sys.exit(2))
    trap = tmp_path / "trap"
    poison_data(foreign, trap)
    with pytest.raises(SystemExit):
        main(["animate", "--policy", str(foreign), "--out", str(tmp_path / "film.gif")])
    assert not trap.exists()


@pytest.mark.parametrize("poison", [poison_data, poison_replay])
def test_trust_means_what_it_says(capsys, tmp_path, foreign, poison):
    trap = tmp_path / "trap"
    poison(foreign, trap)
    answer(capsys, "train", "--resume", "--trust", "--steps", "1", "--out", foreign)
    assert trap.exists() == (poison is poison_data)  # PPO has no experience to read


def test_trust_without_resume(capsys, tmp_path):
    said = answer(capsys, "train", "--trust", "--out", tmp_path / "new")
    assert "--trust is given without --resume" in said


CONFIGS = {
    "[1, 2]": "it must be an object of options",
    "7": "it must be an object of options",
    "[" * 10_000: "inside each other",
    '{"env": 1, "algo": "ppo"}': "has the env 1",
    '{"algo": "ppo"}': "has the env None",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "dqn"}': "unknown algo",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": ["ppo"]}': "has the algo",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "ppo", "exo": 1}': "unknown option",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "ppo", "wearer": 5}': "wearer is 5",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "ppo", "payload": {"mass": NaN}}': "payload",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "ppo", "steps": true}': "has steps True",
    '{"env": "ActiveSuit/ElbowFlexion-v0", "algo": "ppo", "gravity": "venus"}': "unknown gravity",
    '{"env": "ActiveSuit/Knee-v0", "algo": "ppo"}': "unknown environment",
    '{"env": "CartPole-v1", "algo": "ppo"}': "is no arm of ActiveSuit",
    "": "is not complete JSON",
}


@pytest.mark.parametrize("config", CONFIGS, ids=lambda text: text[:60])
@pytest.mark.parametrize("command", ["evaluate", "simulate", "resume"])
def test_damaged_config(capsys, tmp_path, foreign, command, config):
    (foreign / "config.json").write_text(config)
    arguments = [one.format(run=foreign, tmp=tmp_path) for one in COMMANDS[command]]
    trusted = ["--trust"] if command == "resume" else []
    assert CONFIGS[config] in answer(capsys, *arguments, *trusted)
    assert not (tmp_path / "out").exists()


def test_a_module_named_by_somebody_else_is_not_imported(capsys, tmp_path, monkeypatch, foreign):
    trap = tmp_path / "trap"
    (tmp_path / "enemy.py").write_text(f"open({str(trap)!r}, 'w').close()")
    monkeypatch.syspath_prepend(tmp_path)
    write_config(foreign, env="enemy:ActiveSuit/ElbowFlexion-v0")
    said = answer(capsys, "evaluate", "--policies", foreign)
    assert "add --env enemy:ActiveSuit/ElbowFlexion-v0 if that module may be imported" in said
    assert not trap.exists()


@pytest.mark.parametrize("algo", ["ppo", "sac"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_weights_that_are_no_numbers(capsys, tmp_path, algo, value):
    import torch

    run = make_run(tmp_path / "run", algo)
    network = learner(algo, **({"buffer_size": 100} if algo == "sac" else {}))
    with torch.no_grad():
        next(network.policy.parameters()).fill_(value)
    network.save(run / "model.zip")
    for command in ("evaluate", "resume"):
        arguments = [one.format(run=run, tmp=tmp_path) for one in COMMANDS[command]]
        trusted = ["--trust"] if command == "resume" else []
        assert "not finite numbers" in answer(capsys, *arguments, *trusted)


def test_networks_that_are_not_ours(capsys, tmp_path, foreign):
    import torch

    for weights, message in (
        ({"mlp_extractor.policy_net.0.weight": torch.zeros(64, 3)}, "observes 3 numbers"),
        ({"other": torch.zeros(3)}, "is not a readable policy"),
        ([1, 2], "is not a readable policy"),
        (torch.zeros(1).expand(10**9, 10**6), "is not a readable policy"),
    ):
        file = io.BytesIO()
        torch.save(weights, file)
        replace_part(foreign / "model.zip", "policy.pth", file.getvalue())
        assert message in answer(capsys, "evaluate", "--policies", foreign)


def test_a_bomb_in_the_weights(capsys, foreign):
    replace_part(foreign / "model.zip", "policy.pth", bytes(60_000_000))
    assert "is longer than 50,000,000 bytes" in answer(capsys, "evaluate", "--policies", foreign)


def test_foreign_experience(capsys, tmp_path):
    run = make_run(tmp_path / "sac", "sac")
    before = json.loads((run / "config.json").read_text())
    other = learner("sac", "ActiveSuit/ElbowFlexion-v0", buffer_size=10)
    other.replay_buffer.obs_shape = (3,)
    other.save_replay_buffer(run / "replay.pkl")
    arguments = ["train", "--resume", "--trust", "--steps", "9", "--out", run]
    assert "holds the experience of another run" in answer(capsys, *arguments)
    (run / "replay.pkl").write_bytes(b"nothing")
    assert "is not a readable experience" in answer(capsys, *arguments)
    assert json.loads((run / "config.json").read_text()) == before
