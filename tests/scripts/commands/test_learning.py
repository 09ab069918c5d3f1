"""`activesuit benchmark learning`: ways of training beside each other."""

import json
import shutil

import pytest
from activesuit.envs.evaluation.wearers import ArmLost
from activesuit.scripts.commands import learning as command
from activesuit.scripts.main import main
from activesuit.scripts.training.evaluations import Evaluations
from helpers import shorten_tasks

pytest.importorskip("stable_baselines3")
pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    """Short motions, in this process, with notes of its own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(command, "run_all", lambda work, calls, *_: (work(*call) for call in calls))
    shorten_tasks(monkeypatch, 2.0)
    usual = "best-known-plan"
    monkeypatch.setattr(command, "BESIDE", tuple(one for one in command.BESIDE if one != usual))


GIVEN = ["benchmark", "learning", "--tasks", "ArmTracking", "--levels", "shift", "--steps", "9000"]


def test_ways_beside_policies(tmp_path, capsys):
    out = tmp_path / "out"
    ways = ["--ways", "residual", "student", "--seeds", "0,4", "--out", str(out)]
    main([*GIVEN, *ways])
    said = capsys.readouterr().out
    assert "relief at the end" in said
    found = json.loads((out / "result.json").read_text())
    assert [(one["way"], one["trainings"]) for one in found["ends"]] == [
        ("residual", 2),
        ("student", 2),
    ]
    assert {one["policy"] for one in found["beside"]} == {*command.BESIDE}
    assert {one["way"] for one in found["curves"]} == {"residual", "student"}
    assert (out / "learning.png").exists()
    card = json.loads((out / "ArmTracking-shift-residual" / "seed-4" / "policy.json").read_text())
    assert (card["training"]["seed"], card["environment"]["level"]) == (4, "shift")
    assert card["residual"]["policy"] == {"name": "compensation", "suit": "mock-suit"}
    left = out / "ArmTracking-shift-student" / "seed-0"
    before = (out / "ArmTracking-shift-residual" / "seed-0" / "model.zip").stat().st_mtime_ns
    shutil.rmtree(left)
    main([*GIVEN, *ways])
    assert (left / "score.json").exists()
    again = json.loads((out / "result.json").read_text())
    assert again["ends"] == found["ends"]
    after = (out / "ArmTracking-shift-residual" / "seed-0" / "model.zip").stat().st_mtime_ns
    assert after == before


def test_an_interrupted_student_goes_on(tmp_path, monkeypatch, capsys):
    """The same command does the rounds that are left."""
    from activesuit.scripts.training.distillation import Lesson
    from activesuit.scripts.training.learners import training_seeds

    call, begun = Lesson.round, []

    def counted(self, student, seeds):
        begun.append(seeds)
        if len(begun) == 2:
            raise KeyboardInterrupt
        return call(self, student, seeds)

    monkeypatch.setattr(Lesson, "round", counted)
    steps = ["--steps", str(2 * 64 * 200), "--ways", "student", "--seeds", "0"]
    out = ["--out", str(tmp_path / "out")]
    with pytest.raises(SystemExit):
        main([*GIVEN[:-2], *steps, *out])
    capsys.readouterr()
    main([*GIVEN[:-2], *steps, *out])
    assert begun == [training_seeds(0, 64, part=i) for i in (0, 1, 1)]
    assert "student" in capsys.readouterr().out


def test_other_steps_are_no_longer_training(tmp_path, capsys):
    """What has learned with a falling rate is not what a longer training would have given."""
    out, longer = tmp_path / "out", ["--steps", "12000"]
    given = [*GIVEN[:-2], "--ways", "ppo", "--seeds", "0", "--out", str(out)]
    main([*given, "--steps", "9000"])
    with pytest.raises(SystemExit) as stop:
        main([*given, *longer])
    assert stop.value.code == 2
    assert "a training has 12000 steps, and the one in" in capsys.readouterr().err
    main([*given, *longer, "--force"])
    run = out / "ArmTracking-shift-ppo" / "seed-0"
    assert json.loads((run / "score.json").read_text())["steps"] == 12000
    card = json.loads((run / "policy.json").read_text())
    assert card["training"]["steps"] == 12000
    main([*given[:-2], *longer, "--out", str(tmp_path / "new")])
    new = tmp_path / "new" / "ArmTracking-shift-ppo" / "seed-0" / "policy.safetensors"
    assert new.read_bytes() == (run / "policy.safetensors").read_bytes()


def test_a_policy_that_loses_arms_ends_nothing(tmp_path, monkeypatch, capsys):
    """It has no relief, and others in the study have theirs."""
    call = command.run

    def lost(name, *given, **options):
        if "seed-0" in name or name.startswith("adaptive"):
            raise ArmLost("the arm is lost")
        return call(name, *given, **options)

    monkeypatch.setattr(command, "run", lost)
    monkeypatch.setattr(Evaluations, "add", lose_arms)
    out = tmp_path / "out"
    given = ["--ways", "ppo", "--seeds", "0,1", "--out", str(out)]
    main([*GIVEN, *given])
    found = json.loads((out / "result.json").read_text())
    assert (found["curves"], found["ends"][0]["value"]) == ([], None)
    beside = {one["policy"].partition(":")[0]: one for one in found["beside"]}
    assert beside["adaptive"]["value"] is beside["adaptive"]["in_training"] is None
    assert beside["compensation"]["value"] > 0
    assert (out / "learning.png").exists()


def lose_arms(evaluations, steps, network):
    """Adds the result of a policy that loses arms in a training."""
    result = {"steps": steps, "relief": None, "success": 0.0}
    evaluations.results.append(result)
    return result


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--ways", "prayer"], "unknown way of training 'prayer'"),
        (["--tasks", "mine.csv"], "unknown task 'mine.csv'"),
        (["--workers", "0"], "workers is 0"),
        (["--seeds", "x"], "give whole numbers, as 0-9 or 0,3,5"),
        (["--steps", "0"], "steps is 0"),
    ],
)
def test_mistakes(tmp_path, capsys, given, message):
    with pytest.raises(SystemExit) as stop:
        main(["benchmark", "learning", "--out", str(tmp_path / "out"), *given])
    assert stop.value.code == 2
    assert message in capsys.readouterr().err
