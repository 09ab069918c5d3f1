"""Policies as data: names, options, beliefs, and classes from outside and of the docs."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.making import make_arms
from activesuit.envs.policies import Belief, make_policy, policy_spec
from helpers import assert_refused

ELBOW = "ActiveSuit/ElbowFlexion-v0"
ONCE = {"motions": 1, "references": False, "adapted": False}
OBSERVATION = np.zeros(12, np.float32)


def test_text_and_dict_are_the_same():
    options = {"suit": "emu-like", "load": 2.0, "wearer": {"mass": 65.0}, "lead": 0.03}
    text = "compensation:suit=emu-like,load=2,wearer.mass=65,lead=0.03"
    for given in (text, {"name": "compensation", **options, "load": 2}):
        spec = policy_spec(given)
        assert (spec.name, spec.options) == ("compensation", options)
        assert policy_spec(spec) == policy_spec(spec.to_dict()) == policy_spec(str(spec)) == spec


def test_a_file_is_one_too_and_may_name_the_folder_of_a_run(tmp_path):
    spec = policy_spec(f"compensation:suit={tmp_path}/mine.json")  # a suit's file is none
    assert spec.options == {"suit": f"{tmp_path}/mine.json"}
    path, run = tmp_path / "mine.json", tmp_path / "odd:name"
    path.write_text(json.dumps({"name": "feedforward", "lead": 0.01}))
    assert policy_spec(str(path)).options == {"lead": 0.01}
    run.mkdir()
    path.write_text(json.dumps({"name": str(run)}))
    assert policy_spec(str(path)).name == str(run)
    path.write_text("[1]")
    assert_refused(policy_spec, [(str(path), "is no policy: it must be an object with a name")])


@pytest.mark.parametrize("name", ["sneaky:Policy", "sys:exit", "a:b:c"])
def test_a_file_runs_no_code_unless_it_is_trusted(name, tmp_path, monkeypatch):
    imported = tmp_path / "imported"
    code = f"open({str(imported)!r}, 'w').close()\ndef Policy(env): pass\n"
    (tmp_path / "sneaky.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"name": name, "preload": ["http://evil.example/code.py"]}))
    for use in (policy_spec, lambda given: make_policy(given, ArmEnv())):
        assert_refused(use, [(str(path), "importing that would run its code")])
    assert not imported.exists()
    if name.startswith("sneaky"):
        path.write_text(json.dumps({"name": name}))
        assert policy_spec(str(path), trust=True).name == name
        assert imported.exists()
        sys.modules.pop("sneaky")


def test_a_belief_is_not_the_true_suit():
    env = ArmEnv()
    right = make_policy("gravity", env).act(OBSERVATION + 0.5)
    loaded = make_policy("gravity:load=3", env).act(OBSERVATION + 0.5)
    light = make_policy("gravity:wearer.mass=50", env).act(OBSERVATION + 0.5)
    assert (loaded > right + 0.01).all() and (light < right - 0.01).all()
    config = Belief(suit="emu-like", load=1.0).of(env.config)
    assert (config.suit, config.pressure, config.payload.mass) == ("emu-like", None, 1.0)
    assert env.config.suit == "mock-suit"


def test_a_belief_without_any_assisted_joint(tmp_path):
    suit = load_suit("emu-like")
    wrist = {"wrist_flexion": suit.joints["wrist_flexion"]}
    suit.model_copy(update={"joints": wrist}).save(tmp_path / "wrist.json")
    given = {"name": "feedforward", "suit": str(tmp_path / "wrist.json")}
    rows = [(given, ArmEnv(), "neither shoulder_flexion nor elbow_flexion, which have")]
    assert_refused(make_policy, rows)


OUTSIDE = """
import numpy as np

NUMBER = 3
wrong = lambda arms: object()


class Mine:
    'Pushes.'

    sensors = ("encoders", "interaction")

    def __init__(self, plant, belief=None, *, gain: float = 0.1, bad: str = ""):
        self.gain, self.bad = gain, bad

    def reset(self):
        pass

    def act(self, observation):
        assert observation.shape[-1] == 16
        if self.bad == "raise":
            return 1 / 0
        given = np.nan if self.bad == "nan" else self.gain
        return np.full(3 if self.bad == "shape" else (*observation.shape[:-1], 2), given)
"""


@pytest.fixture
def outside(tmp_path, monkeypatch):
    (tmp_path / "outside.py").write_text(OUTSIDE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield
    sys.modules.pop("outside", None)


def test_a_class_from_outside_has_options_and_sensors(outside):
    policies = {"mine": "outside:Mine:gain=0.05", "more": {"name": "outside:Mine", "gain": 0.2}}
    scores = evaluate(ELBOW, policies, **ONCE).scores
    assert scores["mine"].assist_energy != scores["more"].assist_energy


def test_mistakes_in_what_names_a_policy(outside):
    rows = [
        ("copmensation", "unknown policy 'copmensation': .*did you mean 'compensation'"),
        ("compensation:leed=1", "unknown option of policy 'compensation' 'leed'.*mean 'lead'"),
        ("compensation:lead=fast", "option lead of policy 'compensation' is 'fast': .*number"),
        ("compensation:lead=1,lead=2", "has the option 'lead' twice: give it once"),
        ("compensation:guard=maybe", "option guard .* is 'maybe': use true or false"),
        ("os:getcwd", "makes no policy .* whose first argument is the plant"),
        ("compensation:lead", "has 'lead': give options as option=value"),
        ("nowhere:Class", "the policy 'nowhere:Class' cannot be imported"),
        ("outside:NUMBER", "the policy 'outside:NUMBER' is 3: name a class or a function"),
        ("outside:Mine:gain=big", "option gain of policy 'outside:Mine' is 'big'"),
        ({"nam": "none"}, "the policy is .*: give a name"),
        (3, "the policy is 3: give a name"),
        ("feedforward:wearer=1,wearer.mass=2", "wearer"),
    ]
    assert_refused(policy_spec, rows)


def test_mistakes_in_what_makes_one(outside):
    rows = [
        ("compensation:gain=0", "gain is 0.0: use a number from 0.05 to 20"),
        ("compensation:load=90", "the believed load is 90.0: use a number from 0 to 60 kg"),
        ("compensation:suit=nosuit", "unknown suit 'nosuit'"),
        ("adaptive", r"policy 'adaptive' needs the sensors encoders, interaction"),
        ("sys:exit", r"'sys:exit' cannot be made \(SystemExit"),
        ("outside:wrong", r"policy 'outside:wrong' makes .*, which has no reset\(\)"),
    ]
    assert_refused(lambda given: make_policy(given, ArmEnv()), rows)
    rows = [
        # A wrong belief is told even where a class never asks for it.
        ("outside:Mine:suit=nosuch", "nosuch"),
        ("outside:Mine:pressure=900", "900"),
        ("adaptive:forgetting=0.1", "forgetting is 0.1: use a number from 1 to 1000 s"),
        ("disturbance-observer:bandwidth=9", "bandwidth is 9.0: use a number from 0.1 to 5 Hz"),
        ("impedance:damping_ratio=-1", "damping_ratio is -1.0: use a number from 0 to 3"),
        ("iterative:gain=2", "gain is 2.0: use a number from 0 to 1"),
        ("observer:bandwidth=30", "bandwidth is 30.0: use a number from 0.1 to 20 rad/s"),
        ("predictive:samples=100", "samples is 100: use a number from 4 to 64"),
        ("predictive:samples=2.5", "option samples of policy 'predictive' is '2.5'"),
    ]
    env = ArmEnv(sensors=["encoders", "preview", "interaction", "emg"])
    assert_refused(lambda given: make_policy(given, env), rows)


def test_what_it_returns_is_checked(outside):
    rows = [
        ("nan", "policy 'outside:Mine' returns nan: return finite numbers from -1 to 1"),
        ("shape", r"returns an action of shape \(3,\): return finite numbers .* shape \(1, 2\)"),
        ("raise", r"fails in act\(\) \(ZeroDivisionError: division by zero\): repair it"),
    ]
    assert_refused(lambda bad: evaluate(ELBOW, [f"outside:Mine:bad={bad}"], **ONCE), rows)


PAGE = Path(__file__).parents[3] / "docs" / "controllers.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
(CLASSES,) = (block for block in BLOCKS if "(TorquePolicy)" in block)
SENSORS = ["encoders", "preview", "interaction"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "my_policies.py").write_text(CLASSES, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def actions(policy, rows=3, steps=40):
    """The actions of a policy in rows of arms that another one moves."""
    arms = make_arms("ActiveSuit/ArmTracking-v0", rows, sensors=SENSORS, gravity="microgravity")
    made, mover = make_policy(policy, arms), make_policy("compensation", arms)
    observation, _ = arms.reset(seed=3)
    found = []
    for _ in range(steps):
        found.append(made.act(observation))
        observation, *_ = arms.step(mover.act(observation))
    return np.array(found)


@pytest.mark.parametrize(
    ("own", "shipped"),
    [
        ("my_policies:PDPlusSuit:kp=0,kd=0", "feedforward"),
        ("my_policies:PDPlusSuit:kp=0,kd=0,suit=emu-like", "feedforward:suit=emu-like"),
        ("my_policies:Damped:damping=0", "compensation"),
    ],
)
def test_without_their_own_part_they_are_the_shipped_ones(folder, own, shipped):
    found = actions(own)
    np.testing.assert_array_equal(found, actions(shipped))
    assert np.abs(found).max() > 0.01


def test_their_own_part_acts(folder):
    for own in ("my_policies:PDPlusSuit:kp=5", "my_policies:Damped"):
        base = "feedforward" if "PD" in own else "compensation"
        assert np.abs(actions(own) - actions(base)).max() > 1e-3


def test_the_observer_finds_what_the_shipped_one_finds(folder):
    difference = actions("my_policies:Observed") - actions("observer")
    assert np.abs(difference).max() < 0.15  # the friction, which the shipped one knows
    assert np.abs(actions("my_policies:Observed") - actions("gravity")).max() > 0.05
