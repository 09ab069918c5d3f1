"""Training: learns, resumes, and keeps what was learned."""

import json

import pytest
from activesuit.scripts.commands import train as train_module
from activesuit.scripts.main import main
from activesuit.scripts.output import Bar

pytest.importorskip("stable_baselines3")
pytestmark = pytest.mark.slow


def train(out, *more, algo="ppo", steps=2048):
    arguments = ["train", "--algo", algo, "--steps", str(steps), "--out", str(out), *more]
    main(arguments)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("train") / "ppo"
    train(out)
    return out


def steps_done(out, algo="ppo"):
    from activesuit.envs.policies.trained import algorithm_class

    return algorithm_class(algo).load(out / "model.zip", device="cpu").num_timesteps


def test_writes_config_checkpoint_and_logs(run):
    assert json.loads((run / "config.json").read_text())["algo"] == "ppo"
    assert steps_done(run) == 2048
    assert list((run / "tensorboard").rglob("events*"))


def test_trained_policy_is_evaluated_beside_the_others(run, capsys):
    main(["evaluate", "--episodes", "1", "--json", "--policies", "none", str(run)])
    result = json.loads(capsys.readouterr().out)
    assert result["env"] == "ActiveSuit/ElbowFlexion-v0"  # what it was trained on
    policies = result["policies"]
    assert [entry["policy"] for entry in policies] == ["none", str(run)]
    assert policies[1]["assist_energy"] > 0


def test_a_policy_of_another_coupling_says_where_its_options_are(run, capsys):
    with pytest.raises(SystemExit) as end:
        main(["evaluate", "--policies", str(run), "--coupling", "cuffs"])
    assert end.value.code == 2
    assert str(run / "config.json") in capsys.readouterr().err


def test_resume_goes_on(run):
    train(run, "--resume", steps=4096)
    assert steps_done(run) == 4096


def interrupt(*arguments, **options):
    raise KeyboardInterrupt


def interrupted(capsys, out, *more, **options) -> str:
    """Runs a training that must be interrupted; returns what it says at the end."""
    with pytest.raises(SystemExit) as stop:
        train(out, *more, **options)
    assert stop.value.code == 2
    return capsys.readouterr().err.strip().splitlines()[-1]


def test_interrupt_keeps_what_was_learned(tmp_path, monkeypatch, capsys):
    def interrupt_late(self, steps):
        if steps >= 1000:
            raise KeyboardInterrupt

    monkeypatch.setattr(Bar, "move_to", interrupt_late)
    said = interrupted(capsys, tmp_path)
    assert f"steps are kept in {tmp_path}; go on with --resume" in said
    assert 1000 <= steps_done(tmp_path) < 2048
    monkeypatch.undo()
    train(tmp_path, "--resume")
    assert steps_done(tmp_path) >= 2048


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("make_env", "activesuit: interrupted"),
        ("_environments", "nothing was learned yet; start the training again"),
        ("_callback", "0 steps are kept in {out}; go on with --resume"),
        ("_save", "nothing was learned yet; start the training again"),
    ],
)
def test_interrupt_before_or_after_learning(tmp_path, monkeypatch, capsys, part, message):
    monkeypatch.setattr(train_module, part, interrupt)
    assert message.format(out=tmp_path) in interrupted(capsys, tmp_path)


@pytest.mark.parametrize("part", ["load_network", "_save"])
def test_interrupt_of_a_resumed_run_keeps_its_checkpoint(run, monkeypatch, capsys, part):
    before = steps_done(run)
    monkeypatch.setattr(train_module, part, interrupt)
    monkeypatch.setattr(train_module, "CHECKPOINTS", 1)
    said = interrupted(capsys, run, "--resume", steps=before + 100)
    assert f"the last checkpoint is kept in {run}; go on with --resume" in said
    assert steps_done(run) == before


def test_sac_trains_and_resumes_with_its_experience(tmp_path):
    train(tmp_path, algo="sac", steps=1200)
    assert (tmp_path / "replay.pkl").exists()
    train(tmp_path, "--resume", algo="sac", steps=1300)
    assert steps_done(tmp_path, "sac") == 1300


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ([], "holds a trained run: add --resume"),
        (["--resume", "--seed", "5"], "has seed 0, not 5"),
        (["--resume", "--steps", "10"], "give --steps above that"),
        (["--steps", "0"], "steps is 0"),
        (["--seed", "-1"], "seed is -1"),
        (["--env", "ActiveSuit/Knee-v0"], "unknown environment"),
    ],
)
def test_mistakes(run, capsys, more, message):
    with pytest.raises(SystemExit) as stop:
        main(["train", "--out", str(run), *more])
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


def test_damaged_checkpoint(run, tmp_path, capsys):
    (tmp_path / "config.json").write_text((run / "config.json").read_text())
    (tmp_path / "model.zip").write_bytes(b"not a zip file")
    for command in (
        ["evaluate", "--policies", str(tmp_path)],
        ["train", "--resume", "--steps", "9999", "--out", str(tmp_path)],
    ):
        with pytest.raises(SystemExit) as stop:
            main(command)
        assert stop.value.code == 2
        assert "is not a readable policy" in capsys.readouterr().err


def test_nothing_to_resume(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["train", "--out", str(tmp_path / "new"), "--resume"])
    assert "no model.zip to resume" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
