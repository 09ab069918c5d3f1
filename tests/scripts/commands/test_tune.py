"""`activesuit benchmark tune`."""

import json

import pytest
from activesuit.envs.benchmark import tuning
from activesuit.envs.policies import policy_spec
from activesuit.scripts.commands import tune as command
from activesuit.scripts.main import main


def fails(capsys, *arguments) -> str:
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    assert stop.value.code == 2
    return capsys.readouterr().err


@pytest.fixture
def bowl(monkeypatch):
    """A cost with its least value at a lead of 0.03 s and a friction of 0.5."""

    def cost(spec):
        lead, friction = (spec.options.get(name, 0.1) for name in ("lead", "friction"))
        return 0.1 + (lead - 0.03) ** 2 + (friction - 0.5) ** 2

    monkeypatch.setattr(command, "tuning_cost", cost)
    monkeypatch.setattr(command, "run_all", lambda work, calls, *_: (work(*call) for call in calls))


def test_it_finds_the_least_cost_and_writes_a_policy(capsys, tmp_path, bowl):
    pytest.importorskip("cma")
    path = tmp_path / "mine.json"
    arguments = [
        "benchmark",
        "tune",
        "--policy",
        "compensation:suit=emu-like",
        "--out",
        path,
        "--json",
    ]
    main([str(one) for one in arguments])
    found = json.loads(capsys.readouterr().out.partition("\nwrote")[0])
    assert found["after"] < found["before"]
    assert found["policy"]["friction"] == pytest.approx(0.5, abs=0.02)
    assert policy_spec(str(path)).options["suit"] == "emu-like"
    assert "--force" in fails(capsys, *arguments)


def test_an_option_that_is_given_stays(capsys, bowl):
    pytest.importorskip("cma")
    main(
        ["benchmark", "tune", "--policy", "compensation:lead=0.05", "--evaluations", "20", "--json"]
    )
    assert json.loads(capsys.readouterr().out)["policy"]["lead"] == 0.05


def test_the_cost_is_effort_of_motions_that_no_evaluation_shows(monkeypatch):
    monkeypatch.setattr(tuning, "TASKS", ("ElbowFlexion",))
    right, wrong = (
        tuning.tuning_cost(policy_spec(text))
        for text in ("compensation", "compensation:suit=mock-suit")
    )
    assert 0.02 < right < wrong < 0.5


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        ("none", "policy 'none' has no option to tune"),
        ("compensation:lead=0.02,friction=0.8", "all options of policy 'compensation' are given"),
        ("copmensation", "unknown policy"),
        ("compensation:lead=nan", "lead is nan: use a number from 0 to 0.2 s"),
    ],
)
def test_mistakes(capsys, policy, message):
    assert message in fails(capsys, "benchmark", "tune", "--policy", policy)
