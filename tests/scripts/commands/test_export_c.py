"""`activesuit export --c`: C code of suits computes what their joints do."""

import re

import numpy as np
import pytest
from activesuit.assets import Suit, SuitJoint, load_suit, suit_names
from activesuit.envs.model import ArmConfig, resisting_joints
from activesuit.hysteresis import BoucWen, HysteresisModel, Viscoelastic
from activesuit.scripts.main import main
from c_programs import answers, compiled
from helpers import fails

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


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def saved(name="own.json", **joints):
    """Writes a suit file with a model for each joint."""
    about = {"range": (-1, 1), "start_angle": 0.0, "grade": "assumed", "source": "a test */ here"}
    made = {joint: SuitJoint.from_model(model, **about) for joint, model in joints.items()}
    Suit(name="own", description="For a test.", joints=made).save(name)
    return name


def yields() -> HysteresisModel:
    return BoucWen(elastic=2, hysteretic=5, beta=4, gamma=1, n=1.7)


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
    (table,) = golden((folder / "mock-suit.h").read_text())
    np.testing.assert_allclose(joint.response(table[:, 0]), table[:, 1], atol=1e-11)


def test_a_viscoelastic_joint_takes_the_time(folder):
    model = Viscoelastic(model=yields(), damping=0.3, relaxation_stiffness=2.0, relaxation_time=0.2)
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


def test_one_joint(folder):
    main(["export", "mock-suit", "--c", "--joint", "wrist_flexion", "--out", "wrist.h"])
    text = (folder / "wrist.h").read_text()
    assert "wrist_wrist_flexion_step" in text
    assert "elbow_flexion" not in text


def test_policies(folder, capsys):
    main(["export", "compensation:lead=0.03", "--c", "--gravity", "moon", "--payload", "2"])
    text = " ".join((folder / "compensation.h").read_text().replace("\n *", " ").split())
    assert "Policy compensation:lead=0.03: the torques of the motors" in text
    assert "a load of 2 kg, the right arm, moon (1.62 m/s2), coupling rigid" in text
    assert "the motors answer after 0.03 s" in text
    assert re.search(r"Compensation +72 +144 +832 +1664", capsys.readouterr().out)
    saved("elbow.json", elbow_flexion=yields())
    (folder / "tuned.json").write_text('{"name": "feedforward", "suit": "elbow.json"}')
    main(["export", "tuned.json", "--c", "--gravity", "microgravity"])
    text = (folder / "tuned.h").read_text()
    assert "tuned_bouc_wen_commit" in text
    assert "static const tuned_real tuned_weight[" not in text


def test_a_file_that_is_there_stays(folder, capsys):
    (folder / "mock-suit.h").write_text("mine")
    assert "exists: give another name, or add --force" in fails(
        capsys, "export", "mock-suit", "--c"
    )
    assert (folder / "mock-suit.h").read_text() == "mine"
    main(["export", "mock-suit", "--c", "--force"])
    assert (folder / "mock-suit.h").read_text() != "mine"


def test_no_compiler_is_needed(folder, monkeypatch):
    monkeypatch.setenv("PATH", "")
    main(["export", "mock-suit", "--c"])
    assert (folder / "mock-suit.h").exists()
