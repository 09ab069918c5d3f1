"""Training: learns, resumes, and keeps what was learned."""

import json
import re
import shutil
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs.making import make_arms
from activesuit.envs.policies import environment_of, make_policy
from activesuit.scripts.main import main
from activesuit.scripts.output import Bar
from helpers import fails, interrupt, panels_of, shorten_tasks

pytest.importorskip("stable_baselines3")
import torch
from activesuit.scripts.training import learn as learn_module
from activesuit.scripts.training import report
from activesuit.scripts.training.evaluations import BESIDE
from activesuit.scripts.training.hyperparameters import (
    ALGORITHMS,
    algorithm_class,
    arguments,
    hyperparameters,
)

ROLLOUT = 256  # steps of all environments together, after which PPO learns

SMALL = f"{{n_envs: 8, n_steps: {ROLLOUT // 8}, batch_size: 64, learning_rate: 7e-4}}"
QUICK = {
    "ppo": f"default: {SMALL}",
    "sac": "default: {n_envs: 1, learning_starts: 20, gradient_steps: 1, learning_rate: 3e-4}",
    "tqc": "default: {n_envs: 1, learning_starts: 20, gradient_steps: 1, learning_rate: 3e-4}",
    "recurrent-ppo": f"default: {SMALL}",
}


def few(out, *more, algo="ppo", steps=ROLLOUT):
    """Returns the arguments of a training with few steps between updates."""
    given = ["train", "--algo", algo, "--steps", str(steps), "--out", str(out), *more]
    if "--resume" not in more:
        given += [] if "--motions" in more else ["--motions", "0"]
        out.parent.joinpath("quick.yml").write_text(QUICK[algo])
        given += ["--hyperparameters", str(out.parent / "quick.yml")]
    return given


def train(*given, **options):
    main(few(*given, **options))


@pytest.fixture(scope="module", autouse=True)
def soon():
    """Motions last 2 s."""
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 2.0)
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("train") / "ppo"
    train(out, "--gravity", "moon", "--payload", "2", "--torch-threads", "2", steps=ROLLOUT - 9)
    return out


def steps_done(out, algo="ppo"):
    return algorithm_class(algo).load(out / "model.zip", device="cpu").num_timesteps


def test_a_run_is_a_policy_with_card_checkpoint_and_logs(run):
    found = json.loads((run / "policy.json").read_text())["training"]
    assert (found["algo"], found["seed"], found["steps"]) == ("ppo", 0, ROLLOUT - 9)
    assert found["done"] == steps_done(run) == ROLLOUT
    shown = {"arm/effort", "arm/tracking", "rollout/ep_rew_mean", "rollout/success_rate"}
    assert shown <= scalars(run)
    scene = environment_of(run)
    assert (scene["gravity"], scene["payload"]) == ("moon", {"mass": 2.0})
    arms = make_arms(scene.pop("env"), 2, **scene)
    assert np.abs(make_policy(str(run), arms).act(arms.reset(seed=1)[0])).min() > 0


def test_progress_ends_at_the_steps_of_whole_updates(tmp_path, capsys, monkeypatch):
    shown = []
    bar = Bar(lambda done, of: shown.append(done), 1)
    monkeypatch.setattr(learn_module, "progress", lambda what, total: nullcontext(bar))
    train(tmp_path / "run", "--torch-threads", "1", steps=10)
    said = capsys.readouterr()
    assert "note: 10 steps are rounded up to 256, in whole updates" in said.err
    assert NEGATIVE not in said.err  # for the shipped reward
    hint = f"activesuit evaluate --policies none {tmp_path / 'run'}"
    assert hint in said.out.replace("\n", " ")
    assert shown[-1] == ROLLOUT
    assert torch.get_num_threads() == 1


def test_a_run_does_not_go_on_at_its_end_with_less_or_with_other_evaluations(run, tmp_path, capsys):
    shutil.copytree(run, tmp_path / "run")
    before = (run / "model.zip").read_bytes()
    resume = ["train", "--resume", "--out", str(tmp_path / "run")]
    main(resume)
    assert "is at its end: give more --steps to go on" in capsys.readouterr().out
    assert (tmp_path / "run" / "model.zip").read_bytes() == before
    assert "has --motions 8, and the run" in fails(capsys, *resume, "--motions", 8)
    assert f"has {ROLLOUT - 9}: give at least that" in fails(capsys, *resume, "--steps", 10)
    for content in ("[]", '{"references": {}, "results": [{}]}'):
        (tmp_path / "run" / "evaluations.json").write_text(content)
        assert "is no file of evaluations" in fails(capsys, *resume, "--steps", 999)


@pytest.mark.slow
def test_a_run_that_another_machine_trained(run, tmp_path, monkeypatch, capsys):
    here = tmp_path / "here"
    shutil.copytree(run, here)  # a copy is what this machine wrote too
    steps = steps_done(here) + ROLLOUT
    train(here, "--resume", steps=steps)
    assert steps_done(here) == steps
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    resume = ["train", "--resume", "--out", here, "--steps", steps + ROLLOUT]
    assert "add --trust if you trust whoever made it" in fails(capsys, *resume)
    main([*map(str, resume), "--trust"])
    train(here, "--resume", steps=steps + 2 * ROLLOUT)  # what was trusted is now ours


@pytest.mark.slow
def test_without_a_place_for_notes_a_run_needs_trust(run, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    train(tmp_path / "run", steps=2 * ROLLOUT)
    said = " ".join(capsys.readouterr().err.split())
    assert said.count("--resume will need --trust") == 1


@pytest.mark.slow
def test_a_suit_file_comes_with_the_run(tmp_path, monkeypatch):
    load_suit("emu-like").save(tmp_path / "mine.json")
    monkeypatch.chdir(tmp_path)
    train(Path("run"), "--suit", "mine.json")
    Path("mine.json").unlink()
    assert environment_of("run")["suit"] == "run/suit.json"
    assert load_suit("run/suit.json") == load_suit("emu-like")
    train(Path("run"), "--resume", steps=2 * ROLLOUT)


def interrupted(capsys, out, *more) -> str:
    """Runs a training that must be interrupted; returns its last sentence."""
    return fails(capsys, *few(out, *more), shown=True)


@pytest.mark.slow
def test_force_forgets_the_evaluations_before(tmp_path, monkeypatch, capsys):
    """Their references are of another scene, and a training that has not begun has no end."""
    given = ["--motions", "8"]
    train(tmp_path / "run", *WEIGHTLESS, *given)
    (tmp_path / "run" / "policy.json").write_text("{")  # which a new training does not read
    train(tmp_path / "run", *WEIGHTLESS, *given, "--force")
    for part, left in (("new_learner", True), ("update_length", False)):
        with monkeypatch.context() as patch:
            patch.setattr(learn_module, part, interrupt)
            interrupted(capsys, tmp_path / "run", *given, "--force")
        assert (tmp_path / "run" / "evaluations.json").exists() == left


@pytest.mark.slow
def test_interrupt_keeps_what_was_learned(tmp_path, monkeypatch, capsys):
    def interrupt_late(self, steps):
        if steps >= 100:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(learn_module, "training_environments", interrupt)
        said = interrupted(capsys, tmp_path / "run")
    assert "nothing was learned yet; start the training again" in said
    with monkeypatch.context() as patch:
        patch.setattr(Bar, "move_to", interrupt_late)
        said = interrupted(capsys, tmp_path / "run")
    assert f"what was learned is kept in {tmp_path / 'run'}; go on with --resume" in said
    assert 100 <= steps_done(tmp_path / "run") < ROLLOUT
    train(tmp_path / "run", "--resume")
    assert steps_done(tmp_path / "run") >= ROLLOUT


HYPERPARAMETERS = {  # content of a file below "default:", and its mistake
    "ppo": {
        "{learning_rat: 1}": "unknown hyperparameter of ppo .* 'learning_rat'.*learning_rate",
        "{n_envs: 1000000}": "rows is 1000000",
        "{n_envs: 0.5}": "n_envs in .* is 0.5: input should be a valid integer",
        "{n_envs: 0}": "n_envs in .* is 0: input should be greater than 0",
        "{gamma: lin_0.9}": "gamma in .* is 'lin_0.9': input should be a valid number",
        "{gamma: .nan}": "gamma in .* is nan: input should be a finite number",
        "{gamma: -3}": "gamma in .* is -3: input should be greater than or equal to 0",
        "[" * 3000: "is no YAML file of hyperparameters",
        "!!python/object/apply:os.system [exit]": "is no YAML file of hyperparameters",
        "{learning_rate: lin_x}": "the schedule is 'lin_x': write it as lin_3e-4",
        "{policy_kwargs: 5}": "policy_kwargs in .* is 5: input should be a valid dictionary",
        "{policy_kwargs: {n: 5}}": "ppo refuses its hyperparameters",
        "{learning_rate: 1e9}": "the training diverged within",
    },
    "sac": {
        "{train_freq: [4, episode]}": "train_freq in .* is .4, 'episode'.: input should be",
        "{use_sde: true}": "of this SAC: use_sde clips its mean actions",
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("algo", HYPERPARAMETERS)
def test_mistakes_in_hyperparameters(tmp_path, capsys, algo):
    file = tmp_path / "mine.yml"
    given = ["--hyperparameters", file, "--out", tmp_path / "run"]
    for content, message in HYPERPARAMETERS[algo].items():
        file.write_text(f"default: {content}")
        assert re.search(message, fails(capsys, "train", "--algo", algo, *given)), content
        assert (tmp_path / "run" / "policy.json").exists() == ("diverged" in message)
    file.write_text("CartPole-v1: {gamma: 0.9}")
    assert "nor 'default': name one of them" in fails(capsys, "train", "--algo", algo, *given)


def test_hyperparameters_of_a_file_are_added_to_the_shipped_ones(tmp_path):
    def found(text, env="x"):
        (tmp_path / "mine.yml").write_text(text)
        return hyperparameters("ppo", env, tmp_path / "mine.yml")

    both = "default: {gamma: 0.5}\nMine-v0: {learning_rate: lin_3e-4, n_envs: 2, vf_coef: 3e-1}"
    assert found(both, "Other-v0")["gamma"] == 0.5
    mine = found(both, "Mine-v0")
    assert (mine["n_envs"], mine["gamma"]) == (2, 0.98)
    assert mine["vf_coef"] == 0.3  # a text in YAML 1.1
    assert arguments(mine)["learning_rate"](0.5) == pytest.approx(1.5e-4)
    shipped = hyperparameters("ppo", "x")["policy_kwargs"]
    networks = found("default: {policy_kwargs: {optimizer_kwargs: {eps: 1e-5}}}")["policy_kwargs"]
    assert networks == {**shipped, "optimizer_kwargs": {"eps": 1e-5}}  # explores as shipped
    names = {hyperparameters(algo, "x")["policy"] for algo in ALGORITHMS}
    assert names == {"MlpPolicy", "MlpLstmPolicy"}


def scalars(out):
    """Names of what TensorBoard shows of a run."""
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    (folder,) = {path.parent for path in (out / "tensorboard").rglob("events*")}
    return {*EventAccumulator(str(folder)).Reload().Tags()["scalars"]}


WEIGHTLESS = ["--task", "ArmTracking", "--gravity", "microgravity"]
RANDOMIZED = ["--task", "ArmTracking", "--level", "randomized"]


@pytest.mark.slow
@pytest.mark.parametrize(  # ppo, sac and a student are in test_train_stops
    ("algo", "scene"),
    [
        ("tqc", [*RANDOMIZED, "--history", "2"]),
        ("recurrent-ppo", RANDOMIZED),
        ("ppo", [*WEIGHTLESS, "--residual", "adaptive"]),
    ],
)
def test_two_halves_are_the_whole_to_the_last_bit(tmp_path, algo, scene):
    steps = ROLLOUT if "ppo" in algo else 40
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    train(whole, *scene, algo=algo, steps=2 * steps)
    train(halves, *scene, algo=algo, steps=steps)
    train(halves, "--resume", algo=algo, steps=2 * steps)
    policy = "policy.safetensors"
    assert (whole / policy).read_bytes() == (halves / policy).read_bytes()
    options = environment_of(whole)
    arms = make_arms(options.pop("env"), 2, **options)
    assert make_policy(str(whole), arms).act(arms.reset(seed=1)[0]).shape == (2, 2)


@pytest.fixture(scope="module")
def corrected(tmp_path_factory):
    """A run that corrects compensation, with a reward of its own, evaluated on the way."""
    out = tmp_path_factory.mktemp("train") / "corrected"
    own = ["--residual", "compensation:lead=0.01", "--reward", "own_rewards:gentle"]
    train(out, *WEIGHTLESS, *own, "--motions", "8", steps=4 * ROLLOUT)
    return out


@pytest.mark.slow
def test_evaluations_on_the_way(corrected):
    """They choose the policy that is kept, and are on the page and in TensorBoard."""
    found = json.loads((corrected / "evaluations.json").read_text())
    results = found["results"]
    steps = [one["steps"] for one in results]
    assert steps == sorted(set(steps))
    assert steps[-1] == 4 * ROLLOUT
    assert found["seeds"] == list(range(20_000, 20_008))
    last = results[-1]
    assert last["relief"]["low"] <= last["relief"]["value"] <= last["relief"]["high"]
    assert len(last["reliefs"]) == 8
    assert last["wearer_elbow_flexion"] > 0 and last["motor_elbow_flexion"] > 0
    assert (corrected / "learning_curve.png").exists()
    assert [*found["beside"]] == [*BESIDE]
    assert all(one["low"] <= one["value"] <= one["high"] for one in found["beside"].values())
    card = json.loads((corrected / "policy.json").read_text())
    best = max(results, key=lambda one: one["relief"]["value"])
    assert card["scores"] == best
    assert card["training"]["done"] == best["steps"]
    assert card["training"]["reward"] == "own_rewards:gentle"
    (panel,) = panels_of(corrected)
    curve = panel["data"][-1]
    assert curve["x"] == steps
    assert curve["y"] == pytest.approx([one["relief"]["value"] for one in results], rel=1e-4)
    page = (corrected / "report.html").read_text()
    assert "The best policy, after" in page
    assert "training.hyperparameters.learning_rate" in page
    parts = ("relief_low", "success", "tracking", "motor_elbow_flexion", "saturated")
    assert {f"adapted/{part}" for part in parts} <= scalars(corrected)


def test_policies_beside_are_lines_in_the_learning_curve():
    relief = {"value": 0.5, "low": 0.4, "high": 0.7}
    found = [{"steps": 1, "relief": relief}, {"steps": 2, "relief": None}]
    plot = report.learning_plot({"ppo": found}, {"none": None, "compensation": relief})
    assert list(plot.styles()) == ["compensation", "ppo"]


@pytest.mark.slow
def test_a_correction_begins_as_its_policy(tmp_path, monkeypatch):
    """The last layer is zero, so that before the first update nothing is added."""
    monkeypatch.setitem(QUICK, "ppo", QUICK["ppo"].replace("7e-4", "0.0"))
    train(tmp_path / "run", *WEIGHTLESS, "--residual", "compensation", steps=1)
    folder = tmp_path / "run"
    arms = make_arms("ActiveSuit/ArmTracking-v0", 3, gravity="microgravity")
    one, other = make_policy(str(folder), arms), make_policy("compensation", arms)
    observation, _ = arms.reset(seed=1)
    for _ in range(5):
        given = other.act(observation)
        np.testing.assert_array_equal(one.act(observation), given)
        observation, *_ = arms.step(given)


@pytest.mark.slow
def test_training_ends_on_a_plateau(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("activesuit.scripts.training.evaluations.BETTER", 10.0)
    tmp_path /= "run"
    train(tmp_path, *WEIGHTLESS, "--motions", "8", "--patience", "1", steps=20 * ROLLOUT)
    results = json.loads((tmp_path / "evaluations.json").read_text())["results"]
    assert len(results) == 2
    assert steps_done(tmp_path) == results[-1]["steps"]
    assert max(one["relief"]["value"] for one in results) < 0  # after so few steps
    assert "This policy costs the wearer more" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_several_seeds(tmp_path, capsys):
    given = [*WEIGHTLESS, "--seeds", "3,5", "--motions", "8"]
    given += ["--belief.suit", "mock-suit", "--sensors", "encoders", "preview"]
    train(tmp_path / "all", *given, steps=ROLLOUT)
    assert "interquartile mean of the relief" in capsys.readouterr().out
    found = json.loads((tmp_path / "all" / "result.json").read_text())
    assert list(found["best"]) == ["3", "5"]
    (panel,) = panels_of(tmp_path / "all")
    assert {"seed 3", "seed 5"} < {one["name"] for one in panel["data"]}
    before = (tmp_path / "all" / "seed-3" / "model.zip").stat().st_mtime_ns
    shutil.rmtree(tmp_path / "all" / "seed-5")
    train(tmp_path / "all", *given, "--resume", steps=ROLLOUT)
    assert (tmp_path / "all" / "seed-3" / "model.zip").stat().st_mtime_ns == before
    assert (tmp_path / "all" / "seed-5" / "policy.safetensors").exists()
    resume = ["train", "--resume", "--seeds", "3,5", "--out", tmp_path / "all"]
    assert "has --algo 'sac', and the run" in fails(capsys, *resume, "--algo", "sac")
    assert "was trained with 'microgravity'" in fails(capsys, *resume, "--gravity", "moon")
    (tmp_path / "mine.yml").write_text("default: {gamma: 0.5}")
    other = fails(capsys, *resume, "--hyperparameters", tmp_path / "mine.yml")
    assert "mine.yml' has other hyperparameters than the run in" in other


@pytest.mark.slow
def test_trainings_of_different_seeds_meet_different_motions(tmp_path):
    seen = {}
    for seed in (0, 1):
        train(tmp_path / str(seed), "--seed", str(seed), algo="sac", steps=10)
        learner = algorithm_class("sac").load(tmp_path / str(seed) / "model.zip", device="cpu")
        seen[seed] = {*learner.memory["arms"]["seed"].tolist()}
    assert not seen[0] & seen[1]
    assert min(seen[0] | seen[1]) > 10**6  # far from those of evaluations


@pytest.mark.slow
def test_what_is_believed_and_drawn(tmp_path, capsys):
    """The believed suit is in the card; the drawn ones are of the training alone."""
    given = ["--suit", "emu-like", "--belief.suit", "mock-suit"]
    train(tmp_path / "run", *given)
    card = json.loads((tmp_path / "run" / "policy.json").read_text())
    assert card["environment"]["belief"] == {"suit": "mock-suit"}
    assert card["environment"]["sensors"] == ["encoders", "belief"]
    assert card["environment"]["suit"] == "emu-like"
    other = ["--teacher", tmp_path / "run", "--out", tmp_path / "student"]
    message = fails(capsys, "train", *given[:2], "--belief.suit", "emu-like", *other)
    assert "student and teacher observe different beliefs: leave --belief.suit out" in message
    train_student(tmp_path / "student", 1, *STUDENT[:-1], "0", "--belief.suit", "mock-suit")
    card = json.loads((tmp_path / "student" / "policy.json").read_text())
    assert card["environment"]["sensors"] == ["encoders", "belief"]


@pytest.mark.slow
def test_a_student_learns_from_its_teacher(tmp_path, capsys):
    """Compensation needs the sensors that the student has, so that it can be repeated."""
    out = tmp_path / "student"
    given = ["--teacher", "compensation", "--rows", "16", "--steps", str(16 * 200 * 12)]
    main(["train", *WEIGHTLESS, *given, "--motions", "0", "--history", "2", "--out", str(out)])
    arms = make_arms("ActiveSuit/ArmTracking-v0", 4, gravity="microgravity", history=2)
    student, teacher = make_policy(str(out), arms), make_policy("compensation", arms)
    observation, _ = arms.reset(seed=99)
    wanted, given = [], []
    for _ in range(150):
        wanted.append(teacher.act(observation))
        given.append(student.act(observation))
        observation, *_ = arms.step(given[-1])
    wanted, given = np.array(wanted), np.array(given)
    assert np.mean((given - wanted) ** 2) < 0.3 * np.var(wanted)
    assert "add --resume to go on" in fails(capsys, "train", *WEIGHTLESS, "--out", out)


ROUND = 4 * 200  # steps of a round of a student with four rows
STUDENT = [*WEIGHTLESS, "--teacher", "adaptive", "--rows", "4", "--history", "2", "--motions", "8"]


def train_student(out, rounds, *more):
    main(["train", "--steps", str(int(rounds * ROUND)), "--out", str(out), *map(str, more)])


@pytest.mark.slow
def test_a_damaged_checkpoint_of_a_student(tmp_path, capsys):
    damages = (
        lambda found: found["layers"].popitem(),
        lambda found: found.pop("optimizer"),
        lambda found: found.update(kept=[1]),
        lambda found: found.update(rounds=Path),
    )
    out = tmp_path / "student"
    train_student(out, 1, *STUDENT[:-1], "0")
    whole = (out / "model.zip").read_bytes()
    for damage in damages:
        (out / "model.zip").write_bytes(whole)
        damage(found := torch.load(out / "model.zip"))
        torch.save(found, out / "model.zip")
        resume = ["train", "--resume", "--steps", 9 * ROUND, "--out", out]
        assert "was not written by you on this machine" in fails(capsys, *resume)
        assert "is not a readable checkpoint" in fails(capsys, *resume, "--trust")


@pytest.mark.slow
def test_a_resumed_run_finds_its_reward_in_the_working_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("calm_here.py").write_text("def calm(terms, measured):\n    return -terms['effort']\n")
    before = [*sys.path]
    for more in (["--reward", "calm_here:calm"], ["--resume"]):
        monkeypatch.setattr("sys.path", [*before])
        sys.modules.pop("calm_here", None)  # as in another process
        train(Path("run"), *more, steps=ROLLOUT * (1 + ("--resume" in more)))
    assert steps_done(tmp_path / "run") == 2 * ROLLOUT
    monkeypatch.setattr("sys.path", [*before])
    sys.modules.pop("calm_here")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    assert "add --trust" in fails(capsys, "train", "--resume", "--steps", "9999", "--out", "run")
    assert "calm_here" not in sys.modules and sys.path == before


NEGATIVE = "note: the mean reward begins at -"


@pytest.mark.slow
@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_a_negative_reward_is_noted_once(tmp_path, capsys, algo):
    train(tmp_path / "run", "--reward", "own_rewards:costly", algo=algo, steps=ROLLOUT)
    said = " ".join(capsys.readouterr().err.split())
    assert said.count(NEGATIVE) == 1
    train(tmp_path / "run", "--resume", algo=algo, steps=2 * ROLLOUT)
    assert NEGATIVE not in capsys.readouterr().err
