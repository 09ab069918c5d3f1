"""What a command simulates: given options, those of training runs, and the usual ones."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.benchmark import suite
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import Network, save_policy
from activesuit.envs.policies.network import CARD
from activesuit.errors import InputError
from activesuit.scripts.main import main
from activesuit.scripts.scene import scene
from helpers import assert_refused, fails, run, without_volume_shares
from trained_runs import ENVIRONMENT, write_card

OWN = '''
from dataclasses import replace

import gymnasium
from activesuit.envs import TASKS, ArmEnv

QUICK = replace(TASKS["ElbowFlexion"], name="Quick", duration=0.5)


class Quick(ArmEnv):
    """The elbow, for half a second."""

    def __init__(self, **options):
        super().__init__(QUICK, **options)


class Gentle(gymnasium.RewardWrapper):
    def reward(self, reward):
        return reward / 2


class NoArm(gymnasium.Env):
    def __init__(self, **options):
        pass


def gentle(**options):
    return Gentle(Quick(**options))


ARM = "activesuit.envs:ArmEnv"
gymnasium.register("Mine/Quick-v0", entry_point=Quick)
gymnasium.register("Mine/Lazy-v0", entry_point=f"{__name__}:Quick")
gymnasium.register("Mine/Made-v0", entry_point=lambda **options: Quick(**options))
gymnasium.register("Mine/Task-v0", entry_point=ARM, kwargs={"task": QUICK})
gymnasium.register(
    "Mine/Limited-v0", entry_point=ARM, kwargs={"task": "ElbowFlexion"}, max_episode_steps=50
)
gymnasium.register("Mine/Gentle-v0", entry_point=gentle)
gymnasium.register("Mine/NoArm-v0", entry_point=NoArm)
gymnasium.register("Mine/NoneMade-v0", entry_point=lambda **options: NoArm())
'''


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A working folder with a module of the user's, which is not on the path yet."""
    import gymnasium

    (tmp_path / "mine_quick.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    yield "mine_quick:Mine/Quick-v0"
    for name in [name for name in gymnasium.registry if name.startswith("Mine/")]:
        del gymnasium.registry[name]
    sys.modules.pop("mine_quick", None)


def run_folder(path, **config):
    path.mkdir()
    write_card(path, **config)
    return str(path)


def test_without_a_run_the_usual_holds():
    assert scene({}).place.endswith(", earth, mock-suit, level nominal")
    chosen = scene({"payload": {"mass": 3}, "gravity": "moon"}, policies=("none",))
    assert chosen.env == "ActiveSuit/ArmTracking-v0"
    given = {"payload": {"mass": 3}, "gravity": "moon", "suit": "mock-suit"}
    assert {name: chosen.options[name] for name in given} == given
    assert chosen.options["wearer"]["stature"] == 1.78
    usual = {"env": "ActiveSuit/ElbowFlexion-v0", "gravity": "mars"}
    assert scene({}, usual=usual).env == usual["env"]
    assert scene({"task": "ElbowFlexion"}).env == usual["env"]
    assert scene({"level": "shift"}) == scene({}, level="shift")


def test_a_woman_has_the_size_of_women_where_none_is_given():
    woman = {"stature": 1.629, "mass": 67.8, "sex": "female", "strength": 20}
    found = scene({"wearer": {"sex": "female", "strength": 20}})
    assert found.options["wearer"] == pytest.approx(woman)
    tall = scene({"wearer": {"sex": "female", "stature": 1.7}})
    assert tall.options["wearer"]["stature"] == 1.7


def test_the_options_of_a_run_hold(tmp_path):
    run = run_folder(tmp_path / "run", side="left", tilt=[0.1, 0.0], allow_uncertified=True)
    chosen = scene({}, policies=("none", run), usual={"gravity": "mars"})
    assert chosen.env == ENVIRONMENT["env"]
    expected = {name: value for name, value in ENVIRONMENT.items() if name != "env"}
    expected |= {"side": "left", "tilt": [0.1, 0.0], "allow_uncertified": True}
    expected |= {"preconditioned": False, "level": "nominal"}  # which runs of before do not tell
    assert chosen.options == expected
    plant = run_folder(tmp_path / "worn", preconditioned=True)
    assert scene({}, policies=(plant,)).options["preconditioned"]


def test_the_same_option_may_be_given_again(tmp_path):
    run = run_folder(tmp_path / "run")
    given = {"payload": {"mass": 2}, "tilt": (0.0, 0.0), "wearer": {"stature": 1.78}}
    given |= {"gravity": "moon", "env": f"activesuit:{ENVIRONMENT['env']}"}
    assert scene(given, policies=(run,)) == scene({}, policies=(run,))


def test_another_option_is_one_sentence(tmp_path):
    run = run_folder(tmp_path / "run")
    rows = [
        ({"gravity": "earth"}, "--gravity 'earth', .* with 'moon': leave --gravity out"),
        ({"env": "ActiveSuit/ArmTracking-v0"}, "--env 'ActiveSuit/ArmTracking-v0'"),
        ({"suit": "none"}, "--suit 'none'"),
        ({"payload": {"mass": 0.0}}, "--payload.mass 0.0"),
        ({"pressure": 29.6}, "--pressure 29.6, .* trained with None"),
        ({"tilt": (0.0, 0.1)}, r"--tilt \[0.0, 0.1\]"),
        ({"wearer": {"sex": "female"}}, "--wearer.sex 'female'"),
        ({"allow_uncertified": True}, "--allow-uncertified True"),
    ]
    assert_refused(lambda given: scene(given, policies=(run,)), rows)


def test_runs_of_different_options_are_not_compared(tmp_path):
    one, other = run_folder(tmp_path / "one"), run_folder(tmp_path / "other", gravity="mars")
    same = run_folder(tmp_path / "same", algo="sac", seed=7)
    both, alone = (scene({}, policies=given) for given in ((one, same), (one,)))
    assert (both.env, both.options) == (alone.env, alone.options)
    with pytest.raises(InputError, match=r"same' has --gravity 'moon', .*'mars': give runs"):
        scene({}, policies=(one, same, other))


def test_the_level_of_a_run_holds_unless_one_is_given(tmp_path):
    own = {"suit": "mock-suit", "gravity": "mars", "pressure": None}
    run = run_folder(tmp_path / "run", level="shift", **own)
    found = scene({}, policies=(run,))
    assert {name: found.options[name] for name in own} == own  # not those of the level
    assert found == scene({"level": "shift"}, policies=(run,))
    assert found.place == "ActiveSuit/ElbowFlexion-v0, mars, mock-suit, level shift"
    nominal = scene({"level": "nominal"}, policies=(run,))
    assert nominal.options == {**found.options, "level": "nominal"}
    other = run_folder(tmp_path / "other", **own)
    with pytest.raises(InputError, match=r"--level 'shift', .* with 'nominal': add --level"):
        scene({}, policies=(run, other))
    both = scene({"level": "randomized"}, policies=(run, other))
    assert both.options == {**found.options, "level": "randomized"}
    shifted = scene({"level": "shift"}, policies=(other,)).options
    assert (shifted["suit"], shifted["pressure"]) == ("emu-like", 40)


def test_nested_options_of_a_run_hold(tmp_path):
    load = {"mass": 2.0, "inertia": [0.1, 0.1, 0.1]}
    more = {"payload": load, "exo": {"elbow": {"peak_torque": 30.0}}, "fatigue": True}
    run = run_folder(tmp_path / "run", **more, sensing={"rate_cutoff": 10.0, "emg_noise": 0.0})
    found = scene({}, policies=(run,)).options
    assert {name: found[name] for name in more} == more
    with pytest.raises(InputError, match=r"--exo.elbow.peak-torque 20, .*: leave --exo.elbow"):
        scene({"exo": {"elbow": {"peak_torque": 20}}}, policies=(run,))
    other = {"fatigue": False, "sensing": {"rate_cutoff": 5}, "max_episode_steps": 50}
    found = scene(other, policies=(run,)).options  # may differ, as the level may
    assert not found["fatigue"] and found["max_episode_steps"] == 50
    assert found["sensing"] == {"rate_cutoff": 5, "emg_noise": 0.0}
    with pytest.raises(InputError, match=r"--fatigue False, .*: leave --fatigue out"):
        scene({"fatigue": False}, run=Path(run))  # a run that goes on stays as it is
    plain = run_folder(tmp_path / "plain", payload=load)
    with pytest.raises(InputError, match=r"run' has --exo\S+ .* the usual one: give runs"):
        scene({}, policies=(run, plain))


def test_what_a_policy_observes_follows_from_it():
    sensors = {"sensors": ("encoders", "preview")}
    with pytest.raises(InputError, match="--sensors is given, and what a policy observes"):
        scene(sensors, policies=("compensation", "best-known-plan"))
    assert scene(sensors).options["sensors"] == ["encoders", "preview"]


def test_simulate_and_evaluate_keep_the_options(tmp_path, capsys, undrawn):
    short = ["--task", "ElbowFlexion", "--max-episode-steps", "50"]
    given = ["--fatigue", "true", "--sensing.rate-cutoff=10", "--wearer.stature", "1.6"]
    main(["simulate", *short, *given, "--payload", "0", "--out", str(tmp_path / "out")])
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    kept = {"max_episode_steps": 50, "fatigue": True, "sensing": {"rate_cutoff": 10}}
    assert {name: result[name] for name in kept} == kept
    assert result["wearer"]["stature"] == 1.6
    assert len((tmp_path / "out" / "trace.csv").read_text().splitlines()) == 51
    capsys.readouterr()
    few = ["--policies", "none", "--motions", "8", "--unadapted", "--json"]
    one, other = (
        json.loads(run(capsys, "evaluate", *short, *few, *more))["scores"]["none"]["effort"]
        for more in (["--fatigue", "false"], ["--wearer.strength", "5"])
    )
    assert one != other


def test_a_benchmark_with_options_is_one_of_its_own():
    quick = suite("quick")
    other = suite("quick", options={"fatigue": True})
    assert suite("quick", options={}).contract == quick.contract != other.contract
    setting = quick.settings[0]
    assert other.environment(setting) == {**quick.environment(setting), "fatigue": True}
    assert other.protocol(other.policies["none"])["options"] == {"fatigue": True}


@pytest.mark.slow
def test_a_training_keeps_the_options(tmp_path, short, capsys):
    pytest.importorskip("stable_baselines3")
    quick = tmp_path / "quick.yml"
    quick.write_text("default: {n_envs: 8, n_steps: 32, batch_size: 64}")
    out = tmp_path / "run"
    given = ["--fatigue", "true", "--sensing.rate-cutoff", "10", "--sensors", "encoders", "emg"]
    given += ["--randomize.load", "0.1"]
    usual = ["--steps", "256", "--motions", "0", "--hyperparameters", str(quick)]
    main(["train", "--out", str(out), *usual, *given])
    card = json.loads((out / CARD).read_text())
    kept = {"fatigue": True, "sensing": {"rate_cutoff": 10}, "sensors": ["encoders", "emg"]}
    assert {name: card["environment"][name] for name in kept} == kept
    assert card["training"]["randomize"] == {"load": 0.1}
    found = scene({}, policies=(str(out),)).options
    assert found["fatigue"] and "randomize" not in found
    few = ["--policies", "none", out, "--motions", 8, "--unadapted", "--json"]
    capsys.readouterr()
    assert json.loads(run(capsys, "evaluate", *few, "--fatigue", "false"))["fatigue"] is False
    resume = ["train", "--out", out, "--resume", "--steps", 512, "--fatigue", "false"]
    assert "leave --fatigue out" in fails(capsys, *resume)


def test_a_policy_of_save_policy_is_a_run(tmp_path):
    weights = {"layer.0.weight": np.zeros((2, 12)), "layer.0.bias": np.zeros(2)}
    env = ArmEnv("ElbowFlexion", gravity="moon", payload={"mass": 2.0})
    save_policy(Network(weights), tmp_path / "saved", env)
    trained, saved = run_folder(tmp_path / "run"), str(tmp_path / "saved")
    both, alone = (scene({}, policies=given) for given in ((trained, saved), (trained,)))
    assert (both.env, both.options) == (alone.env, alone.options)


@pytest.mark.parametrize("name", ["Quick", "Lazy", "Made", "Task", "Limited"])
def test_an_environment_of_your_own(own, capsys, undrawn, name):
    env = own.replace("Quick", name)
    run(capsys, "simulate", "--env", env, "--out", "one")
    result = json.loads((Path("one") / "result.json").read_text())
    assert result["env"] == env
    with open("one/trace.csv") as trace:
        assert len(trace.readlines()) == 51
    score = ["evaluate", "--env", env, "--motions", "8", "--unadapted", "--policies", "none"]
    assert json.loads(run(capsys, *score, "--json"))["env"] == env


def test_your_own_environment_in_the_library(own, monkeypatch):
    monkeypatch.syspath_prepend(".")
    for name in (own, "Mine/Quick-v0"):  # registered by now
        found = evaluate(name, ["none"], motions=1, references=False, adapted=False)
        assert found.scores["none"].failures == 0


@pytest.mark.parametrize(
    ("env", "message"),
    [
        ("mine_quick:Mine/Slow-v0", "unknown environment 'mine_quick:Mine/Slow-v0'"),
        ("mine_quick:Mine/NoArm-v0", "'mine_quick:Mine/NoArm-v0' is no arm of ActiveSuit"),
        ("mine_quick:Mine/Gentle-v0", "has the wrapper Gentle, which rows of arms cannot have"),
        ("mine_quick:Mine/NoneMade-v0", "cannot be made (AttributeError"),
        ("nowhere:Mine/Quick-v0", "cannot be made (ModuleNotFoundError"),
        (":Mine/Quick-v0", "unknown environment"),
        ("..:Mine/Quick-v0", "cannot be made"),
    ],
)
@pytest.mark.parametrize("command", [["evaluate"], ["simulate", "--out", "out"], ["train"]])
def test_environments_that_cannot_be(own, capsys, command, env, message):
    if command == ["train"]:
        pytest.importorskip("stable_baselines3")
    assert message in fails(capsys, *command, "--env", env)


@pytest.mark.slow
def test_a_run_in_your_own_environment(own, capsys, monkeypatch):
    """Its module is found in the working folder, although only the card names it."""
    pytest.importorskip("stable_baselines3")
    before = [*sys.path]

    def in_another_process():
        monkeypatch.setattr("sys.path", [*before])
        sys.modules.pop("mine_quick")

    quick = ["--rows", "8", "--hyperparameters", "quick.yml"]
    Path("quick.yml").write_text("default: {n_steps: 32}")
    main(["train", "--env", own, "--steps", "256", "--out", "run", *quick])
    in_another_process()
    main(["train", "--resume", "--steps", "512", "--out", "run"])
    in_another_process()
    capsys.readouterr()
    score = ["evaluate", "--policies", "none", "run", "--motions", "8", "--unadapted", "--json"]
    assert json.loads(run(capsys, *score))["env"] == own


@pytest.mark.slow
def test_a_joint_that_the_believed_suit_lacks(capsys, tmp_path, short):
    suit = load_suit("mock-suit")
    elbow = {"elbow_flexion": suit.joints["elbow_flexion"]}
    half = tmp_path / "half.json"
    suit.model_copy(update={"joints": elbow}).save(half)
    few = ["--motions", "8", "--env", "ActiveSuit/ElbowFlexion-v0"]
    out = run(capsys, "validate", half, "--plant", "mock-suit", *few)
    assert f"shoulder_flexion: not assisted, because {half} has no such joint" in out
    out = run(capsys, "validate", "mock-suit", "--plant", half, *few, "--out", tmp_path / "out")
    assert "shoulder_flexion: nothing to assist" in out
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert set(result["cells"][0]["torque"]["joints"]) == {"elbow_flexion"}


@pytest.mark.slow
def test_a_suit_without_pressure_has_no_relief(capsys, short, tmp_path):
    suit = str(tmp_path / "suit.json")
    without_volume_shares(load_suit("emu-like")).save(suit)
    few = ["--motions", "8", "--env", "ActiveSuit/ElbowFlexion-v0", "--pressure", "0"]
    out = run(capsys, "validate", suit, "--plant", suit, *few, "--out", tmp_path / "out")
    assert "so that relief has no meaning" in out
    assert json.loads((tmp_path / "out" / "result.json").read_text())["cells"][0]["relief"] is None
