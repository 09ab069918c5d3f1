"""`activesuit evaluate envelope`: the table, the files, and mistakes."""

import csv
import json

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.envelope import SUSTAINED, Holding, work_envelope
from activesuit.envs.model import ArmConfig
from activesuit.scripts.main import main


def test_files_hold_what_the_table_says(capsys, tmp_path, undrawn):
    arguments = ["--gravity", "moon", "--suit", "emu-like", "--spacing", "0.08", "--payload", "1"]
    main(["evaluate", "envelope", *arguments, "--out", str(tmp_path)])
    shown = capsys.readouterr().out
    result = json.loads((tmp_path / "result.json").read_text())
    config = ArmConfig(suit="emu-like", gravity="moon", payload={"mass": 1})
    assert len(result["envelopes"]) == 7
    assert result["share_of_strength"] == SUSTAINED
    with (tmp_path / "points.csv").open() as file:
        rows = list(csv.DictReader(file))
    for reported in result["envelopes"]:
        assert f"{reported['held_litres']:.1f} ± {reported['standard_error_litres']:.1f}" in shown
        branch = reported["branch"]
        own = [one for one in rows if (one["condition"], one["branch"] or None) ==
               (reported["condition"], branch)]  # fmt: skip
        assert reported["held_litres"] == pytest.approx(len(own) * 1e3 * 0.08**3)
        place = np.array([[float(one[f"{axis}_m"]) for axis in ("forward", "left", "up")]
                          for one in own])  # fmt: skip
        posture = np.array([[float(one[joint]) for joint in JOINTS] for one in own])
        holding = Holding.of(config, reported["condition"], branch or "loading")
        assert holding.positions(posture) == pytest.approx(place, abs=2e-4)
        assert max(float(one["share_of_strength"]) for one in own) <= SUSTAINED
    again = work_envelope(config, "assisted", "unloading", spacing=0.08)
    assert result["envelopes"][4]["held_litres"] == again.volume() > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--spacing", "1"], "spacing is 1.0: use a number from 0.004 to 0.1 m"),
        (["--coupling", "none"], "coupling is 'none': leave it 'rigid'"),
        (["--suit", "emu"], "emu"),
        (["--payload", "-1"], "payload.mass is -1.0: use a number from 0 to 60 kg"),
    ],
)
def test_a_mistake_is_one_sentence_and_leaves_nothing(capsys, tmp_path, arguments, message):
    with pytest.raises(SystemExit) as stop:
        main(["evaluate", "envelope", *arguments, "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    reported = capsys.readouterr().err
    assert reported.startswith("activesuit: error: ")
    assert reported.count("\n") == 1
    assert message in reported
    assert not any(tmp_path.iterdir())
