"""`activesuit suits`: lists, shows, checks, draws and exports suits."""

import json
import re
import stat

import numpy as np
import pytest
from activesuit.assets import JOINTS, Suit, SuitJoint, load_suit, save_suit, suit_names
from activesuit.hysteresis import JilesAtherton
from activesuit.scripts.main import main
from activesuit.scripts.reports.suit_figure import TURNS, first_order_loops, suit_figure
from helpers import sweep

RISKY = JilesAtherton(Ms=22.2316, a=319.55, alpha=6.3223, c=4.7447, k=168.582, angle_unit="deg")
SAFE = load_suit("mock-suit").joints["elbow_flexion"].model


def entry_of(model, **changes):
    given = {"range": (0.0, 1.5), "start_angle": 0.0, "grade": "assumed", "source": "a test"}
    return SuitJoint(model=model, **(given | changes))


def run(capsys, *arguments) -> str:
    main(["suits", *map(str, arguments)])
    return capsys.readouterr().out


def fails(capsys, *arguments) -> tuple[str, str]:
    """What a command prints that must end with exit code 2, and its sentence."""
    with pytest.raises(SystemExit) as stop:
        main(["suits", *map(str, arguments)])
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
    assert "a gas alone gives all of P dV/dtheta back, which is 0" in shown


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


def test_an_unsafe_suit_is_shown_and_ends_with_exit_code_2(capsys, tmp_path):
    shown, message = fails(capsys, "published-2022", "--out", tmp_path)
    assert "NO" in shown
    assert f"wrote {tmp_path}/loops.png" in shown
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
    axes = suit_figure(suit).axes[0]
    assert len(axes.lines) == 4 * TURNS + 1  # and the line at zero


def test_export_at_another_pressure(capsys, tmp_path):
    path = tmp_path / "mine.json"
    shown = run(capsys, "emu-like", "--pressure", 40, "--export", path)
    assert f"wrote {path}" in shown
    assert "extrapolated" in shown
    again = json.loads(run(capsys, "emu-like", "--pressure", 40, "--json"))
    assert again["pressure_kpa"] == 40
    path.chmod(0o600)
    _, message = fails(capsys, "mock-suit", "--export", path)
    assert "exists: give another name, or add --force to replace it" in message
    assert load_suit(path) == load_suit("emu-like").at_pressure(40)
    run(capsys, "mock-suit", "--export", path, "--force")
    assert load_suit(path) == load_suit("mock-suit")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_suit_without_pressure_resists_by_its_structure_or_not_at_all(capsys, tmp_path):
    run(capsys, "emu-like", "--pressure", 0, "--export", tmp_path / "s.json")
    empty = load_suit(tmp_path / "s.json").joints["elbow_flexion"]
    assert empty.volume_share == 0
    whole = load_suit("emu-like")
    joints = {n: one.model_copy(update={"volume_share": None}) for n, one in whole.joints.items()}
    save_suit(whole.model_copy(update={"joints": joints}), tmp_path / "whole.json")
    shown = run(capsys, tmp_path / "whole.json", "--pressure", 0, "--export", tmp_path / "n.json")
    assert "It resists no joint." in shown
    assert load_suit(tmp_path / "n.json").joints == {}
    _, message = fails(capsys, tmp_path / "whole.json", "--pressure", 0, "--out", tmp_path / "a")
    assert "resists no joint: leave --out away" in message


def test_loops_begin_at_the_lower_end_and_come_back():
    entry = entry_of(SAFE, start_angle=0.5)
    loops = first_order_loops(entry, SAFE)
    assert [*loops] == ["0.30", "0.60", "0.90", "1.20", "1.50"]
    for turn, (angle, torque) in loops.items():
        assert angle[[0, -1]] == pytest.approx([0, 0])
        assert angle.max() == pytest.approx(float(turn))
        assert torque.argmax() == angle.argmax()
        expected = SAFE.response(sweep(0.5, 0.0, angle.max(), 0.0))[-1]
        assert torque[-1] == pytest.approx(expected, abs=1e-5)
    angle, torque = loops["1.50"]
    assert np.trapezoid(torque, angle) > 0


def test_a_loop_that_meets_the_pole_is_left_out_and_reported():
    entry = entry_of(RISKY, range=(0.0, 2.5))
    loops = first_order_loops(entry, RISKY)
    assert 0 < len(loops) < TURNS
    figure = suit_figure(Suit(name="risky", description="", joints={"elbow_flexion": entry}))
    assert any("infinite torque" in text.get_text() for text in figure.axes[0].texts)
