"""`activesuit list suits`: lists, shows and checks suits."""

import json
import re

import pytest
from activesuit.assets import JOINTS, Suit, SuitJoint, load_suit, save_suit, suit_names
from activesuit.hysteresis import JilesAtherton
from activesuit.scripts.main import main

RISKY = JilesAtherton(Ms=22.2316, a=319.55, alpha=6.3223, c=4.7447, k=168.582, angle_unit="deg")
SAFE = load_suit("mock-suit").joints["elbow_flexion"].model


def entry_of(model, **changes):
    given = {"range": (0.0, 1.5), "start_angle": 0.0, "grade": "assumed", "source": "a test"}
    return SuitJoint(model=model, **(given | changes))


def run(capsys, *arguments) -> str:
    main(["list", "suits", *map(str, arguments)])
    return capsys.readouterr().out


def fails(capsys, *arguments) -> tuple[str, str]:
    """What a command prints that must end with exit code 2, and its sentence."""
    with pytest.raises(SystemExit) as stop:
        main(["list", "suits", *map(str, arguments)])
    assert stop.value.code == 2
    shown, message = capsys.readouterr()
    assert message.startswith("activesuit: error: ")
    assert message.count("\n") == 1
    return shown, message


def test_the_list_tells_label_pressure_and_joints(capsys):
    listed = json.loads(run(capsys, "--json"))
    assert [*listed] == suit_names()
    shown = run(capsys)
    for name, reported in listed.items():
        suit = load_suit(name)
        assert reported == {
            "label": suit.label,
            "pressure_kpa": suit.pressure_kpa,
            "description": suit.description,
            "joints": [*suit.joints],
            "loss_factor": {j: e.steady_cycle().loss_factor for j, e in suit.joints.items()},
        }
        assert name in shown
        assert suit.label in shown
        assert suit.description in shown
    assert "29.6 kPa" in shown


def test_loss_factors_are_those_of_the_docs(capsys):
    """The table in docs/model.md."""
    listed = json.loads(run(capsys, "--json"))
    expected = {
        "emu-like": (0.836, 0.876, 0.796, 0.770),
        "exploration-56kpa": (0.658, 0.716, 0.605, 0.582),
        "mock-suit": (0.836, 0.753, 0.643, 0.770),
        "published-2022": (0.842, 0.751, 0.642, 0.770),
    }
    for name, reported in listed.items():
        factors = [reported["loss_factor"][joint] for joint in JOINTS]
        assert factors == pytest.approx(expected[name], abs=6e-4)
    content = json.loads(run(capsys, "mock-suit", "--json"))
    assert content["joints"]["elbow_flexion"]["loss_factor"] == pytest.approx(0.643, abs=6e-4)
    assert re.search(r"loss factor +0\.75 +0\.64 +0\.84 +0\.77", run(capsys, "mock-suit"))


def test_a_joint_without_a_steady_cycle_has_no_loss_factor(capsys, tmp_path):
    joint = entry_of(RISKY, range=(0.0, 2.5))
    save_suit(Suit(name="r", description="", joints={"elbow_flexion": joint}), tmp_path / "s.json")
    shown, _ = fails(capsys, tmp_path / "s.json", "--json")
    assert json.loads(shown)["joints"]["elbow_flexion"]["loss_factor"] is None
    shown, _ = fails(capsys, tmp_path / "s.json")
    assert re.search(r"loss factor +-", shown)


@pytest.mark.parametrize("name", ["mock-suit", "emu-like", "exploration-56kpa"])
def test_a_safe_suit_is_shown(capsys, name):
    shown = run(capsys, name)
    assert "Safe to simulate" in shown
    assert "NO" not in shown.replace("NRMSE", "").split()
    content = json.loads(run(capsys, name, "--json"))
    assert content["safe"]
    for joint in JOINTS:
        assert content["joints"][joint]["certificate"]["margin"] > 0


def test_an_unsafe_suit_is_shown_and_ends_with_exit_code_2(capsys):
    shown, message = fails(capsys, "published-2022")
    assert "NO" in shown
    assert "Safe to simulate" not in shown
    assert "shoulder_flexion has certificate margin -0.245" in message
    assert "elbow" not in message
    shown, _ = fails(capsys, "published-2022", "--json")
    content = json.loads(shown)
    assert not content["safe"]
    margin = content["joints"]["shoulder_flexion"]["certificate"]["margin"]
    assert margin == pytest.approx(-0.2447, abs=1e-4)


def test_a_start_outside_the_certificate_is_found(capsys, tmp_path):
    joint = entry_of(SAFE, start_torque=12.0)
    suit = Suit(name="far", description="", joints={"elbow_flexion": joint})
    save_suit(suit, tmp_path / "s.json")
    _, message = fails(capsys, tmp_path / "s.json")
    assert "elbow_flexion begins at 0 rad with 12 N·m, outside its certificate" in message


def test_samples_are_shown(capsys, tmp_path):
    joint = entry_of(SAFE, samples=[SAFE.scaled(torque=factor) for factor in (0.8, 1.2, 1.1)])
    suit = Suit(name="many", description="", joints={"elbow_flexion": joint})
    save_suit(suit, tmp_path / "s.json")
    torque = SAFE.response([0, 1.5])[-1]
    assert f"{0.8 * torque:.2f} .. {1.2 * torque:.2f}" in run(capsys, tmp_path / "s.json")
