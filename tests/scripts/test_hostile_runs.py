"""Run folders of somebody else: they run no code and end in one sentence."""

import json

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


def test_trust_without_resume(capsys, tmp_path):
    said = answer(capsys, "train", "--trust", "--out", tmp_path / "new")
    assert "--trust is given without --resume" in said


CARDS = {
    "7": "its content is wrong",
    "[" * 10_000: "inside each other",
    "{}": "its observation is wrong",
    "": "is not complete JSON",
}
OPTIONS = {
    '{"env": 1}': "has the env 1",
    '{"algo": "dqn"}': "unknown algo",
    '{"knee": 1}': "unknown option",
    '{"reward": "enemy:reward"}': "unknown option",
    '{"randomize": {"suits": ["/etc/passwd"]}}': "unknown option",
    '{"exo": 1}': "exo is 1",
    '{"fatigue": "much"}': "fatigue is 'much'",
    '{"payload": {"mass": NaN}}': "payload",
    '{"steps": true}': "has steps True",
    '{"gravity": "venus"}': "unknown gravity",
    '{"env": "ActiveSuit/Knee-v0"}': "unknown environment",
    '{"env": "CartPole-v1"}': "is no arm of ActiveSuit",
}
OF_TRAINING = ("algo", "steps")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["evaluate", "simulate", "resume"])
@pytest.mark.parametrize("given", [*CARDS, *OPTIONS], ids=lambda text: text[:60])
def test_damaged_card(capsys, tmp_path, foreign, command, given):
    path = foreign / "policy.json"
    if given in CARDS:
        path.write_text(given)
    else:
        card, changes = json.loads(path.read_text()), json.loads(given)
        for name, value in changes.items():
            card["training" if name in OF_TRAINING else "environment"][name] = value
        path.write_text(json.dumps(card))
    arguments = [one.format(run=foreign, tmp=tmp_path) for one in COMMANDS[command]]
    trusted = ["--trust"] if command == "resume" else []
    said = answer(capsys, *arguments, *trusted)
    if command == "resume" or not any(name in given for name in OF_TRAINING):
        assert {**CARDS, **OPTIONS}[given] in said  # to act, a policy need not know its training
        assert not (tmp_path / "out").exists()


def test_a_module_named_by_somebody_else_is_not_imported(capsys, tmp_path, monkeypatch, foreign):
    trap = tmp_path / "trap"
    (tmp_path / "enemy.py").write_text(f"open({str(trap)!r}, 'w').close()")
    monkeypatch.syspath_prepend(tmp_path)
    write_card(foreign, env="enemy:ActiveSuit/ElbowFlexion-v0")
    said = answer(capsys, "evaluate", "--policies", foreign)
    assert "add --env enemy:ActiveSuit/ElbowFlexion-v0 if that module may be imported" in said
    assert not trap.exists()


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_weights_that_are_no_numbers(capsys, tmp_path, foreign, value):
    from activesuit.envs.policies.network import read_card, read_network

    network = read_network(foreign, read_card(foreign))
    next(iter(network.weights.values()))[0] = value
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
