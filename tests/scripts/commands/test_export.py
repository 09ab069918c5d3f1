"""`activesuit export`: ONNX models act as networks; C code of suits computes their torques."""

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.assets import Suit, SuitJoint, load_suit, suit_names
from activesuit.envs.model import ArmConfig, resisting_joints
from activesuit.envs.policies.network import Network, contract_of, files_of, read_card, read_network
from activesuit.hysteresis import BoucWen, Viscoelastic
from activesuit.scripts.commands import export as command
from activesuit.scripts.main import main
from c_programs import answers, compiled
from helpers import fails
from trained_runs import OBSERVATION, card, write_network

ROOT = Path(__file__).parents[3]
KINDS = {
    "tanh": {},
    "relu": {"activation": "relu", "squashed": True},
    "one layer": {"between": ()},
    "LSTM": {"hidden": 16},
    "LSTM, one layer": {"hidden": 16, "between": (), "squashed": True},
}


def network(inputs=12, outputs=2, between=(32, 32), hidden=0, activation="tanh", squashed=False):
    """Returns a network with random weights, as a training begins with."""
    rng, weights = np.random.default_rng(7), {}

    def add(name, *shape):
        size = hidden if name.startswith("lstm") else inputs
        weights[name] = rng.uniform(-1, 1, shape).astype(np.float32) / np.sqrt(np.float32(size))

    if hidden:
        add("lstm.input", 4 * hidden, inputs)
        add("lstm.hidden", 4 * hidden, hidden)
        add("lstm.bias", 4 * hidden)
        inputs = hidden
    for i, size in enumerate((*between, outputs)):
        add(f"layer.{i}.weight", size, inputs)
        add(f"layer.{i}.bias", size)
        inputs = size
    return Network(weights, activation, squashed)


@pytest.fixture
def run(tmp_path):
    """The folder of a policy without an LSTM."""
    return made(tmp_path / "run", network())


def made(folder, one):
    folder.mkdir()
    write_network(folder, one)
    return folder


def runs(content, runtime):
    """Returns the function that runs a model from a dict of its inputs."""
    module = pytest.importorskip({"onnx": "onnx.reference"}.get(runtime, runtime))
    if runtime == "onnx":
        return lambda given: module.ReferenceEvaluator(content).run(None, given)
    session = module.InferenceSession(content, providers=["CPUExecutionProvider"])
    return lambda given: session.run(None, given)


@pytest.mark.parametrize("runtime", ["onnx", "onnxruntime"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_model_acts_as_the_network(capsys, tmp_path, kind, runtime):
    pytest.importorskip("onnx")
    one, out = network(**KINDS[kind]), tmp_path / "policy.onnx"
    main(["export", str(made(tmp_path / "run", one)), "--onnx", "--out", str(out)])
    assert f"wrote {out}" in capsys.readouterr().out
    act = runs(out.read_bytes(), runtime)
    rng, memory = np.random.default_rng(1), one.memory(50)
    given = {"memory": memory.astype(np.float32)} if one.hidden else {}
    for _ in range(20):  # 1,000 observations, and as many steps of 50 memories
        given["observation"] = rng.normal(size=(50, 12)).astype(np.float32)
        action, *moved = act(given)
        assert action.dtype == np.float32
        np.testing.assert_allclose(action, one.act(given["observation"], memory), atol=1e-6)
        if one.hidden:
            given["memory"] = moved[0]
            np.testing.assert_allclose(moved[0], memory, atol=1e-6)
    assert np.abs(action).max() <= 1


def test_inputs_outputs_and_metadata(tmp_path):
    onnx = pytest.importorskip("onnx")
    from activesuit.envs.policies.onnx_export import onnx_model

    folder = made(tmp_path / "run", network(hidden=16))
    found = read_card(folder)
    model = onnx_model(found, read_network(folder, found))
    onnx.checker.check_model(model, full_check=True)
    shapes = {}
    for one in (*model.graph.input, *model.graph.output):
        sides = one.type.tensor_type.shape.dim
        shapes[one.name] = [side.dim_param or side.dim_value for side in sides]
    ins = {"observation": ["batch", 12], "memory": [2, "batch", 16]}
    assert shapes == ins | {"action": ["batch", 2], "next_memory": [2, "batch", 16]}
    about = {one.key: one.value for one in model.metadata_props}
    observation = json.loads(about["observation"])
    assert observation == OBSERVATION
    assert about["contract"] == contract_of(observation) == found.contract
    assert json.loads(about["environment"]) == found.environment
    parts = json.loads(about["parts"])
    assert parts.keys() == observation["layout"].keys()
    assert parts["rate"] == {"shows": "their rates", "unit": "rad/s", "limit": 20.0, "scale": 4.0}


def test_a_difference_is_refused(capsys, tmp_path, monkeypatch, run):
    onnx_export = pytest.importorskip("activesuit.envs.policies.onnx_export")
    out = tmp_path / "policy.onnx"
    found = {"ONNX reference": 1e-7, "onnxruntime": 2e-5}
    monkeypatch.setattr(onnx_export, "differences", lambda model, network: found)
    message = fails(capsys, "export", run, "--onnx", "--out", out)
    assert "differs from its network by 2.0e-05 (onnxruntime), and at most 1e-05" in message
    assert not out.exists()


def test_the_check_notices_another_network():
    onnx_export = pytest.importorskip("activesuit.envs.policies.onnx_export")
    one, other = network(hidden=16), network(hidden=16)
    other.weights["lstm.bias"][20] += 0.001  # a gate that keeps the state
    found = onnx_export.differences(onnx_export.onnx_model(card(), one), other)
    assert min(found.values()) > 10 * command.TOLERANCE
    assert max(onnx_export.differences(onnx_export.onnx_model(card(), one), one).values()) < 1e-6


def test_numbers_that_32_bits_cannot_have(capsys, tmp_path):
    pytest.importorskip("onnx")
    one = network()
    weights = {**one.weights, "layer.0.weight": one.weights["layer.0.weight"] * np.float64(1e300)}
    folder = made(tmp_path / "run", Network(weights, "tanh", squashed=False))
    assert "too large for 32-bit" in fails(capsys, "export", folder, "--onnx")


def test_a_card_of_another_network(capsys, run):
    for name, content in files_of(card(), network(inputs=5)).items():
        (run / name).write_bytes(content)
    message = fails(capsys, "export", run, "--onnx")
    assert "has 5 inputs and 2 outputs, and its card says 12 and 2" in message


def test_an_lstm_without_a_layer(capsys, run):
    weights = {name: one for name, one in network(hidden=4).weights.items() if "lstm" in name}
    damaged = SimpleNamespace(weights=weights, activation="tanh", squashed=False)
    for name, content in files_of(card(), damaged).items():
        (run / name).write_bytes(content)
    message = fails(capsys, "export", run, "--onnx")
    assert "readable network (the network has no layer.0.weight" in message


@pytest.mark.parametrize("format", ["--onnx", "--c"])
def test_places_that_are_taken(capsys, tmp_path, run, format):
    pytest.importorskip("onnx")
    out, what = tmp_path / "new.out", run if format == "--onnx" else "mock-suit"
    out.write_text("mine")
    assert "exists: give another name" in fails(capsys, "export", what, format, "--out", out)
    assert out.read_text() == "mine"
    nowhere = tmp_path / "nosuch" / "new.out"
    assert "choose a folder that exists" in fails(capsys, "export", what, format, "--out", nowhere)
    main(["export", str(what), format, "--out", str(out), "--force"])
    assert out.read_bytes() != b"mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.out", "run"]


def test_without_the_extra(capsys, tmp_path, monkeypatch, run):
    monkeypatch.setitem(sys.modules, "onnx", None)
    monkeypatch.delitem(sys.modules, "activesuit.envs.policies.onnx_export", raising=False)
    message = fails(capsys, "export", run, "--onnx", "--out", tmp_path / "policy.onnx")
    assert "pip install -e '.[onnx]' -c constraints.txt" in message
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]


def test_the_example_of_the_page_runs(tmp_path, monkeypatch, run):
    pytest.importorskip("onnxruntime")
    monkeypatch.chdir(tmp_path)
    main(["export", str(run), "--onnx", "--out", "my-policy.onnx"])
    page = (ROOT / "docs" / "training.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```py\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    names = {}
    exec(compile(example, "training.md", "exec"), names)
    assert names["action"].shape == (1, 2)


STEPS = """#include <stdio.h>
#include "suit.h"
int main(void)
{{
    double angle;
    suit_{joint}_state state;
    suit_{joint}_init(&state);
    while (fread(&angle, sizeof angle, 1, stdin) == 1) {{
        double torque = suit_{joint}_step(&state, {angle});
        fwrite(&torque, sizeof torque, 1, stdout);
    }}
    return 0;
}}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def saved(name="own.json", **joints):
    """Writes a suit file with a model for each joint."""
    about = {"range": (-1, 1), "start_angle": 0.0, "grade": "assumed", "source": "a test */ here"}
    made = {joint: SuitJoint.from_model(model, **about) for joint, model in joints.items()}
    Suit(name="own", description="For a test.", joints=made).save(name)
    return name


YIELDING = BoucWen(elastic=2, hysteretic=5, beta=4, gamma=1, n=1.7)


def golden(text):
    """The golden values of the comments: rows of angle and torque, for each joint."""
    blocks = re.findall(r"Golden values.*?:\n \*\n(.*?)\*/", text, re.DOTALL)
    return [np.array(re.findall(r"-?\d+\.\d+", block), float).reshape(-1, 2) for block in blocks]


@pytest.mark.parametrize("suit", suit_names())
def test_golden_values_of_a_shipped_suit(folder, suit):
    main(["export", suit, "--c", "--out", "suit.h", "--allow-uncertified"])
    text = (folder / "suit.h").read_text()
    joints = resisting_joints(ArmConfig(suit=suit, allow_uncertified=True, coupling="none"))
    for (joint, entry), table in zip(joints.items(), golden(text), strict=True):
        np.testing.assert_allclose(entry.response(table[:, 0]), table[:, 1], atol=1e-11)
        program = compiled(folder, STEPS.format(joint=joint, angle="angle"), name=joint)
        np.testing.assert_allclose(answers(program, table[:, 0]), table[:, 1], atol=1e-11)


def test_a_preconditioned_suit_begins_in_its_cycle(folder):
    main(["export", "mock-suit", "--c", "--preconditioned", "--joint", "elbow_flexion"])
    joint = load_suit("mock-suit").joints["elbow_flexion"].preconditioned()
    text = (folder / "mock-suit.h").read_text()
    assert "mock_suit_elbow_flexion_step" in text and "wrist_flexion" not in text
    (table,) = golden(text)
    np.testing.assert_allclose(joint.response(table[:, 0]), table[:, 1], atol=1e-11)


def test_a_viscoelastic_joint_takes_the_time(folder):
    model = Viscoelastic(model=YIELDING, damping=0.3, relaxation_stiffness=2.0, relaxation_time=0.2)
    main(["export", saved(elbow_flexion=model), "--c", "--out", "suit.h"])
    text = (folder / "suit.h").read_text()
    assert "suit_elbow_flexion_step(&state, angle, dt);" in text
    (table,) = golden(text)
    program = compiled(folder, STEPS.format(joint="elbow_flexion", angle="angle, 0.1"))
    np.testing.assert_allclose(answers(program, table[:, 0]), table[:, 1], atol=1e-11)


def test_what_a_header_says(folder, capsys):
    main(["export", "mock-suit", "--c"])
    text, printed = (folder / "mock-suit.h").read_text(), capsys.readouterr().out
    assert text.isascii()
    for said in (
        *("Resistance of the suit mock-suit", "Certificate: the stiffness stays finite"),
        *("Ms = 23.05610416641338  [N m]", "mock_suit_wrist_flexion_step", "#ifndef MOCK_SUIT_H"),
    ):
        assert said in text
    assert re.search(r"shoulder_flexion +clipped jiles-atherton +32 +64 +\d+ +\d+", printed)
    assert "wrote mock-suit.h" in printed


def test_policies(folder, capsys):
    main(["export", "compensation:lead=0.03", "--c", "--gravity", "moon", "--payload", "2"])
    text = " ".join((folder / "compensation.h").read_text().replace("\n *", " ").split())
    assert "Policy compensation:lead=0.03: the torques of the motors" in text
    assert "a load of 2 kg, the right arm, moon (1.62 m/s2), coupling rigid" in text
    assert "the motors answer after 0.03 s" in text
    assert re.search(r"Compensation +72 +144 +832 +1664", capsys.readouterr().out)
    saved("elbow.json", elbow_flexion=YIELDING)
    (folder / "tuned.json").write_text('{"name": "feedforward", "suit": "elbow.json"}')
    main(["export", "tuned.json", "--c", "--gravity", "microgravity"])
    text = (folder / "tuned.h").read_text()
    assert "tuned_bouc_wen_commit" in text
    assert "static const tuned_real tuned_weight[" not in text


def test_no_compiler_is_needed(folder, monkeypatch):
    monkeypatch.setenv("PATH", "")
    main(["export", "mock-suit", "--c"])
    assert (folder / "mock-suit.h").exists()
