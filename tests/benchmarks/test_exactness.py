"""Every way to the torque agrees, and whatever is wrong shows."""

import json
from dataclasses import replace

import numpy as np
import pytest
from activesuit.benchmarks import exactness
from activesuit.benchmarks.__main__ import main
from activesuit.benchmarks.references import integrate, reference_of, turn_indices
from activesuit.hysteresis import MODELS, TABLE_2, Viscoelastic

pytestmark = pytest.mark.slow

CASES = {case.name: case for case in exactness.examples()}
WRONG = {
    "J-A shoulder-sa-pso": {"k": 168.583},
    "J-A elbow-mpso": {"alpha": 5.5625},
    "bouc-wen, n = 1": {"beta": 4.0001},
    "bouc-wen, n = 1.7": {"n": 1.7001},
    "preisach": {"elastic": [1.0] * 8},
    "prandtl-ishlinskii stops": {"weights": [6, 4, 2.0001]},
    "prandtl-ishlinskii plays": {"thresholds": [0.05, 0.2001, 0.7]},
    "hinged stops": {"slopes": (0.4, 1, 0.3, 1.6001)},
    "dahl": {"friction": 1.5001},
    "duhem": {"friction_down": 0.6001},
    "elbow-sa-pso in a range": {"angle_range": (0.7001, 1.3)},
    "asymmetric, elbow-sa-pso": {"polynomial": [0.3, -0.5, 0.8001]},
}


def test_every_way_gives_the_same_torque(capsys):
    main(["exactness", "--json"])
    result = json.loads(capsys.readouterr().out)
    names = [row["model"] for row in result["rows"]]
    assert names == list(CASES)
    assert {f"J-A {name}" for name in TABLE_2} < set(names)
    assert {type(case.model) for case in CASES.values()} == set(MODELS.values()) - {Viscoelastic}
    for row in result["rows"]:
        assert row["within"] == {"reference": True, "dop853": True, "engine": True}
        assert row["passed"]
        assert row["turns"] > 30
        assert row["largest_torque"] > 1
        if not row["model"].startswith("asymmetric"):
            assert row["difference"]["engine"] == 0
    assert result["within"]
    assert result["largest"]["overall"] == max(
        value for row in result["rows"] for value in row["difference"].values()
    )


def test_the_table_says_what_failed(capsys, monkeypatch):
    names = ("preisach", "bouc-wen, n = 1")
    monkeypatch.setattr(exactness, "examples", lambda: [CASES[name] for name in names])
    monkeypatch.setattr(exactness, "TOLERANCE", 1e-11)
    exactness.report(json=False)
    lines = capsys.readouterr().out.splitlines()
    verdicts = {name: line.split()[-1] for line in lines for name in names if name in line}
    assert verdicts == {"preisach": "yes", "bouc-wen, n = 1": "NO"}
    assert any(line.split()[:1] == ["all"] and line.split()[-1] == "NO" for line in lines)
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_parameter_shows(name, monkeypatch):
    case = CASES[name]
    wrong = replace(case.model, **WRONG[name])
    monkeypatch.setattr(exactness, "reference_of", lambda _, *start: reference_of(wrong, *start))
    found = exactness.examine(case)
    assert found.within == {"reference": False, "dop853": False, "engine": True}
    assert not found.passed


@pytest.mark.parametrize("name", ["J-A elbow-sa-pso", "preisach", "asymmetric, elbow-sa-pso"])
def test_another_torque_in_the_engine_shows(name, monkeypatch):
    attach = exactness.attach

    def attach_other(spec, joint, model, **options):
        attach(spec, joint, model.scaled(torque=1 + 1e-9), **options)

    monkeypatch.setattr(exactness, "attach", attach_other)
    assert not exactness.examine(CASES[name]).within["engine"]


def test_turns_of_a_motion_that_rests():
    angle = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 3.0, 3.0])
    assert turn_indices(angle).tolist() == [4, 6, 9]


@pytest.mark.parametrize("name", ["J-A elbow-sa-pso", "preisach", "bouc-wen, n = 1"])
def test_motions_that_rest_are_solved_too(name):
    model, turns = CASES[name].model, [0.6, 1.2, 0.8, 1.0]
    once = integrate(reference_of(model, np.array(turns), 0.0), np.array(turns))
    angle = np.repeat(turns, 3)
    np.testing.assert_array_equal(integrate(reference_of(model, angle, 0.0), angle)[::3], once)
