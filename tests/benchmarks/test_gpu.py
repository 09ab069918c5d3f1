"""The benchmark of many worlds in MuJoCo Warp."""

import json

import pytest
from activesuit.benchmarks import gpu
from activesuit.benchmarks.__main__ import main
from helpers import assert_refused, fails

pytestmark = pytest.mark.slow


def test_it_steps_worlds_with_and_without_hysteresis(monkeypatch, capsys):
    pytest.importorskip("mujoco_warp", reason="needs the extra gpu: make test-all")
    monkeypatch.setattr(gpu, "WORLD_STEPS", 6)
    gpu.report(1, [2, 3], json=True)
    found = json.loads(capsys.readouterr().out)
    assert [row["what"][:8] for row in found["rows"]] == ["2 worlds", "3 worlds"]
    assert all(row["ours"] > 0 < row["reference"] for row in found["rows"])
    header, rows = gpu.columns([found])
    assert all(len(row) == len(header) for row in rows)
    assert rows[1][:2] == [found["device"], "3"]


def test_numbers_of_worlds_are_checked():
    wrong = [[0], [4, 4]]
    assert_refused(lambda worlds: gpu.rows(1, worlds), [(one, "worlds") for one in wrong])


def test_worlds_belong_to_gpu(capsys):
    message = fails(capsys, "engine", "--worlds", 4, program=main)
    assert "--worlds belongs to gpu, not to engine" in message
