"""`--set`: any option of the environment on the command line."""

import json

import pytest
from activesuit.envs.model import ArmConfig
from activesuit.envs.policies.network import CARD
from activesuit.envs.randomization import Randomization
from activesuit.errors import InputError
from activesuit.scripts.arm_options import ArmOptions
from activesuit.scripts.main import main
from activesuit.scripts.runs import scene
from activesuit.scripts.settings import SETTABLE, settings
from helpers import fails, shorten_tasks

ELBOW = ["--env", "ActiveSuit/ElbowFlexion-v0"]


def set_(*given):
    return ArmOptions(set=(given,))


def test_values_are_json_lists_and_words():
    values = {
        "fatigue=true": True,
        "control_dt=5e-3": 0.005,
        "suit=emu-like": "emu-like",
        "pressure=null": None,
        "sensors=[encoders, preview]": ["encoders", "preview"],
        "tilt=[0.1,0]": [0.1, 0],
        'wearer={"mass": 70}': {"mass": 70},
        "normalize=True": True,
    }
    assert [*settings(values).values()] == [*values.values()]
    nested = settings(["exo.elbow.peak_torque=30", "exo.elbow.bandwidth=8", "exo.shoulder.a=b=c"])
    elbow = {"peak_torque": 30, "bandwidth": 8}
    assert nested == {"exo": {"elbow": elbow, "shoulder": {"a": "b=c"}}}
    assert {"fatigue", "sensing", "level", "max_episode_steps", "gravity"} < SETTABLE


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["fatgue=true"], "unknown option of --set 'fatgue': .* did you mean 'fatigue'"),
        (["threads=2"], "unknown option of --set 'threads'"),
        (["fatigue"], "--set has 'fatigue': give NAME=VALUE"),
        (["fatigue=true", "fatigue=true"], "'fatigue' twice"),
        (["wearer=3", "wearer.mass=70"], "'wearer' as a value and with fields"),
        (["wearer.mass=70", "wearer=3"], "'wearer' as a value and with fields"),
        (['wearer={"mass": 70, "mass": 80}'], "'mass' twice in one object"),
        (['wearer={"mass": 70'], "give JSON, or a list such as"),
        (["max_episode_steps=many"], "max_episode_steps"),
        (["max_episode_steps=0"], "max_episode_steps is 0"),
    ],
)
def test_mistakes_are_one_sentence(given, message):
    with pytest.raises(InputError, match=message):
        settings(given)


def test_a_flag_and_set_may_not_differ():
    assert ArmOptions(stature=1.7, set=(("wearer.stature=1.7",),)).given() == {"stature": 1.7}
    assert scene(set_("level=shift")) == scene(ArmOptions(), level="shift")
    assert scene(set_("gravity=moon"), gravity="moon") == scene(ArmOptions(), gravity="moon")
    for given in (
        lambda: scene(ArmOptions(stature=1.7, set=(("wearer.stature=1.8",),))),
        lambda: scene(set_("gravity=mars"), gravity="moon"),
        lambda: scene(set_("level=shift"), level="nominal"),
    ):
        with pytest.raises(InputError, match=r"a flag gives .*, and --set gives .*: leave one"):
            given()
    with pytest.raises(InputError, match="wearer is 5: give its fields"):
        scene(set_("wearer=5"))


def test_weightless_is_a_name_of_microgravity():
    moon = scene(ArmOptions(), gravity="moon")
    both = [scene(ArmOptions(), gravity=name) for name in ("weightless", "microgravity")]
    both += [scene(set_("gravity=weightless"), gravity=name) for name in ("microgravity", None)]
    assert all(one == both[0] != moon for one in both)
    assert ArmOptions().config(None, "weightless")["gravity"] == "microgravity"
    assert ArmConfig(gravity="weightless") == ArmConfig(gravity="microgravity")
    drawn = Randomization(gravity=("weightless", "moon"))
    assert drawn.gravity == ("microgravity", "moon")
    with pytest.raises(InputError, match=r"'weightles': .* did you mean 'weightless'"):
        ArmConfig(gravity="weightles")


def test_what_a_policy_observes_follows_from_it():
    sensors = set_("sensors=[encoders,preview]")
    with pytest.raises(InputError, match="--set gives sensors, and what a policy observes"):
        scene(sensors, policies=("compensation", "best-known-plan"))
    assert scene(sensors).options["sensors"] == ["encoders", "preview"]


def test_simulate_and_evaluate_keep_the_settings(tmp_path, capsys, undrawn):
    given = ["--set", "max_episode_steps=50", "--set", "fatigue=true", "sensing.rate_cutoff=10"]
    main(["simulate", *ELBOW, *given, "--stature", "1.6", "--out", str(tmp_path / "out")])
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    kept = {"max_episode_steps": 50, "fatigue": True, "sensing": {"rate_cutoff": 10}}
    assert {name: result[name] for name in kept} == kept
    assert result["wearer"]["stature"] == 1.6
    assert len((tmp_path / "out" / "trace.csv").read_text().splitlines()) == 51
    capsys.readouterr()
    short = ["--policies", "none", "--episodes", "8", "--unadapted", "--json"]
    efforts = []
    for cutoff in ("fatigue=false", "wearer.strength=5"):
        main(["evaluate", *ELBOW, *short, "--set", "max_episode_steps=50", cutoff])
        found = json.loads(capsys.readouterr().out)
        efforts.append(found["scores"]["none"]["effort"])
        assert found["max_episode_steps"] == 50
    assert efforts[0] != efforts[1]


def test_a_benchmark_with_settings_is_one_of_its_own():
    from activesuit.envs.benchmark import suite

    quick = suite("quick")
    other = suite("quick", options={"fatigue": True})
    assert suite("quick", options={}).contract == quick.contract != other.contract
    setting = quick.settings[0]
    assert other.environment(setting) == {**quick.environment(setting), "fatigue": True}
    assert other.protocol(other.policies["none"])["options"] == {"fatigue": True}


@pytest.mark.slow
def test_a_training_keeps_the_settings(tmp_path, monkeypatch, capsys):
    pytest.importorskip("stable_baselines3")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    shorten_tasks(monkeypatch, 0.5)
    quick = tmp_path / "quick.yml"
    quick.write_text("default: {n_envs: 8, n_steps: 32, batch_size: 64}")
    out = tmp_path / "run"
    given = ["fatigue=true", "sensing.rate_cutoff=10", "sensors=[encoders,emg]"]
    given += ["randomize.load=0.1"]
    usual = ["--steps", "256", "--motions", "0", "--hyperparameters", str(quick)]
    main(["train", "--out", str(out), *usual, "--set", *given])
    card = json.loads((out / CARD).read_text())
    assert card["environment"]["fatigue"] is True
    assert card["environment"]["sensing"] == {"rate_cutoff": 10}
    assert card["environment"]["sensors"] == ["encoders", "emg"]
    assert card["training"]["randomize"] == {"load": 0.1}
    found = scene(ArmOptions(), policies=(str(out),)).options
    assert found["fatigue"] and "randomize" not in found
    short = ["--policies", "none", str(out), "--episodes", "8", "--unadapted", "--json"]
    capsys.readouterr()
    main(["evaluate", *short, "--set", "fatigue=false"])
    assert json.loads(capsys.readouterr().out)["fatigue"] is False
    resume = ["train", "--out", out, "--resume", "--steps", 512, "--set", "fatigue=false"]
    assert "leave --set fatigue out" in fails(capsys, *resume)
