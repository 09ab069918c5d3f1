"""The configuration of the model, and models from files: plain values and clear refusals."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import activesuit
import mujoco
import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.model import ArmConfig, Exo, Payload, compose, load_model, resisting_joints
from activesuit.envs.model.config import PROVENANCE
from activesuit.envs.person import Person
from activesuit.envs.policies import make_policy
from activesuit.hysteresis.engine import attach
from arms import posed
from helpers import assert_refused

RICH = ArmConfig(
    suit="published-2022",
    pressure=40.0,
    preconditioned=True,
    gravity="moon",
    wearer=Person(stature=1.6, mass=55.0, sex="female", strength=80.0),
    exo=Exo(elbow=replace(Exo().elbow, peak_torque=30.0), encoder_delay=0.004),
    coupling="cuffs",
    payload=Payload(mass=2.0, inertia=(0.01, 0.02, 0.02)),
    side="left",
    tilt=(0.3, -0.1),
    misalignment=(0.01, 0.0, -0.02),
    sim_dt=0.0005,
    allow_uncertified=True,
)


@pytest.mark.parametrize("config", [ArmConfig(), RICH], ids=["default", "rich"])
def test_json_gives_the_config_back(config):
    assert ArmConfig.from_dict(json.loads(json.dumps(config.to_dict()))) == config
    assert hash(ArmConfig.from_dict(config.to_dict())) == hash(config)


def test_nested_dicts_replace_single_fields():
    config = ArmConfig(wearer={"stature": 1.6}, exo={"elbow": {"peak_torque": 30.0}})
    assert config.wearer == Person(stature=1.6)
    assert config.exo == Exo(elbow=replace(Exo().elbow, peak_torque=30.0))
    assert ArmConfig.from_dict({"tilt": [0.1, 0]}).tilt == (0.1, 0.0)


def test_a_path_is_a_suit_and_the_step_follows_the_coupling():
    assert ArmConfig(suit=Path("folder") / "mine.json").suit == str(Path("folder") / "mine.json")
    steps = ({}, {"coupling": "cuffs"}, {"coupling": "cuffs", "sim_dt": 5e-4})
    assert [ArmConfig(**fields).timestep for fields in steps] == [0.002, 0.001, 5e-4]


def test_what_cannot_be_is_refused_in_one_sentence():
    rows = [
        ({"gravity": "moonn"}, "unknown gravity 'moonn': .* did you mean 'moon'?"),
        ({"side": "lef"}, "unknown side 'lef': .* did you mean 'left'?"),
        ({"payload": {"mass": -1}}, "payload.mass is -1: use a number from 0 to 60 kg"),
        ({"payload": {"inertia": (1, 1, 1)}}, r"inertia is \(1.0, 1.0, 1.0\), but its mass"),
        ({"payload": {"mass": 1, "inertia": (1, 1, 3)}}, "inertia is .*none of them greater"),
        ({"payload": {"mass": 1, "inertia": (1, 1)}}, r"inertia is \(1, 1\): give 3 finite"),
        ({"misalignment": (0.01, 0, 0)}, "misalignment is .*, but coupling is 'rigid'"),
        ({"misalignment": (0, 0.06, 0), "coupling": "cuffs"}, "0.06: use a number from -0.05 to"),
        ({"pressure": -1}, "pressure is -1: use a number from 0 to 110 kPa"),
        ({"pressure": 30, "suit": "none"}, "pressure is 30 kPa, but suit is 'none'"),
        ({"coupling": "none", "exo": {"cuff": 0.2}}, "exo is given, but coupling is 'none'"),
        ({"tilt": (2, 0)}, "tilt is 2.0: use a number from -1.57"),
        ({"sim_dt": 0.1}, "sim_dt is 0.1: use a number from 1e-05 to 0.01 s"),
        ({"wearer": {"statur": 1.7}}, "unknown field of wearer 'statur': .* mean 'stature'?"),
        ({"wearer": 1.7}, r"wearer is 1.7: give Person\(...\) or a dict of its fields"),
        ({"exo": {"elbow": {"peak": 3}}}, "unknown field of exo.elbow 'peak': "),
        ({"exo": {"elbow": {"peak_torque": 5}}}, "motor's continuous_torque is 10.0: use at most"),
        ({"exo": {"elbow": {"viscous": 6}}}, "a motor's viscous friction is 6: .* less than 5"),
        ({"exo": {"encoder_bits": 64}}, "exo.encoder_bits is 64: use at most 32"),
        ({"exo": {"ring": "0.4"}}, "exo.ring is '0.4': use a number"),
        ({"preconditioned": 1}, "preconditioned is 1: use True or False"),
    ]
    assert_refused(lambda fields: ArmConfig(**fields), rows)
    row = ({"sides": "left"}, r"unknown field of config 'sides': .*mean 'side'")
    assert_refused(ArmConfig.from_dict, [row])


def test_a_payload_without_moments_is_a_ball_of_aluminum():
    ball = Payload(mass=2.0)
    density = next(q.value for q in PROVENANCE if q.name == "payload.density")
    assert ball.mass == pytest.approx(density * 4 / 3 * 3.141592653589793 * ball.radius**3)
    assert ball.moments == pytest.approx((0.4 * 2.0 * ball.radius**2,) * 3)


def test_a_suit_as_an_object():
    suit = load_suit("mock-suit")
    named, given = ArmConfig(), ArmConfig(suit=suit)
    assert ArmConfig.from_dict(json.loads(json.dumps(given.to_dict()))) == given
    angles = np.linspace(0, 1, 5)
    for config in (given, ArmConfig(suit=dict(suit.joints))):
        joints = resisting_joints(config)
        assert joints == resisting_joints(named)
        assert hash(config) == hash(ArmConfig(suit=config.suit))
        torque = joints["elbow_flexion"].model.response(angles)
        assert torque.any()
    assert compose(given).nplugin == compose(named).nplugin
    row = (suit.joints["elbow_flexion"], "^.{,200}give it by the name of its joint.{,100}$")
    assert_refused(lambda joint: ArmConfig(suit=joint), [row])
    envs, steps = [ArmEnv("ElbowFlexion", suit=one) for one in ("mock-suit", suit)], []
    for env in envs:
        env.reset(seed=3)
        steps.append(env.step(np.array([0.2, -0.1]))[0])
    np.testing.assert_array_equal(*steps)
    again = envs[1].set_state(envs[1].get_state())[0]
    np.testing.assert_array_equal(again, steps[1])
    make_policy({"name": "feedforward", "suit": suit}, envs[0])


JOINT = """<mujoco><worldbody><body><joint name="j" axis="0 1 0"/><geom size=".1"/></body>
  </worldbody></mujoco>"""
ROOT = Path(activesuit.__file__).parent.parent


def spec():
    made = mujoco.MjSpec.from_string(JOINT)
    attach(made, "j", load_suit("mock-suit").joints["elbow_flexion"].model)
    return made


@pytest.fixture
def files(tmp_path):
    (made := spec()).compile()
    (tmp_path / "one.xml").write_text(made.to_xml())
    mujoco.mj_saveModel(made.compile(), str(tmp_path / "one.MJB"), None)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("name", ["one.xml", "one.MJB"])
def test_a_process_that_imports_nothing_else_loads_a_model(files, name):
    program = (
        "import mujoco, sys; from activesuit.envs.model import load_model; "
        "data = mujoco.MjData(load_model(sys.argv[1])); "
        "data.qpos[0] = 0.4; mujoco.mj_forward(data.model, data); print(data.qfrc_passive[0])"
    )
    found = subprocess.run(
        [sys.executable, "-c", program, str(files / name)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=False,
        text=True,
        cwd=files,
    )
    assert found.returncode == 0, found.stderr
    data = posed(spec().compile(), 0.4)
    assert float(found.stdout) == data.qfrc_passive[0] < 0


def test_an_arm_on_cuffs_loads(tmp_path):
    model = compose(ArmConfig(coupling="cuffs"), drawn=False)
    mujoco.mj_saveModel(model, str(tmp_path / "arm.mjb"), None)
    loaded = load_model(tmp_path / "arm.mjb")
    np.testing.assert_array_equal(loaded.plugin, model.plugin)
    assert mujoco.MjData(loaded).plugin_state.size == model.npluginstate > 0


def test_files_that_are_no_model_get_one_sentence(files):
    (files / "bad.xml").write_text("<mujoco><worldbody><body></mujoco>")
    (files / "text.mjb").write_text("<mujoco/>" * 500)
    (files / "folder.xml").mkdir()
    content = (files / "one.MJB").read_bytes()
    cut = r"cannot load '.*cut.mjb' \(.*\): repair the file, or"
    for end in (0, 21, len(content) // 2, -1):
        (files / "cut.mjb").write_bytes(content[:end])
        assert_refused(load_model, [(files / "cut.mjb", cut)])
    rows = [
        (files / "bad.xml", "MuJoCo .* cannot load .*bad.xml.*XML"),
        (files / "text.mjb", "MuJoCo .* cannot load .*text.mjb"),
        (files / "folder.xml", "there is no file .*folder.xml': give the path of a model"),
        (files / "none.mjb", "there is no file .*none.mjb': give the path of a model"),
        (files / "arm.urdf", r"arm.urdf' is no .xml and no .mjb file: give one of these"),
        (3, r"the model is 3: give the path of a .xml or .mjb file"),
    ]
    assert_refused(load_model, rows)
