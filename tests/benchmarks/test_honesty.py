"""The benchmark of honesty: truths by seed, cases that are kept, and tables."""

import json
import math

import numpy as np
import pytest
from activesuit.benchmarks import honesty
from activesuit.benchmarks.__main__ import main
from activesuit.benchmarks.honesty import bands, truths
from activesuit.hysteresis import BoucWen
from activesuit.hysteresis.loops import reversals
from helpers import sweep

pytestmark = pytest.mark.slow


def test_unlike_ways_become_a_duhem_model():
    """The crossing of both slopes becomes the zero of z, the torque stays the same."""
    up, high, down, low = 12.0, 0.4, 3.0, -0.9
    model = truths.semilinear(np.array([up, down]), np.array([high, low]), (0.2, 1.5))
    crossing = (up * high + down * low) / (up + down)
    assert model.stiffness == pytest.approx(up * (high - crossing))
    assert model.stiffness == pytest.approx(down * (crossing - low))
    assert model.friction_up == pytest.approx(high - crossing)
    assert model.friction_down == pytest.approx(crossing - low)
    angle, y = sweep(0.3, 1.5, 0.6, 1.1, 0.9, 1.4, samples=30), [0.1]
    for way in np.diff(angle):
        rate, limit = (up, high) if way > 0 else (down, low)
        y.append(limit + (y[-1] - limit) * math.exp(-rate * abs(way)))
    expected = 0.2 + 1.5 * angle + y
    np.testing.assert_allclose(model.response(angle, expected[0]), expected, atol=1e-13)


@pytest.mark.parametrize("kind", truths.KINDS)
def test_truths_are_drawn_by_seed(kind):
    draw = truths.KINDS[kind]
    one, same, other = (draw(np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert (one.low, one.high) == (same.low, same.high) != (other.low, other.high)
    angle = np.linspace(one.low, one.high, 50)
    np.testing.assert_array_equal(one.torque(angle), same.torque(angle))
    assert np.abs(one.torque(angle)).max() == pytest.approx(truths.PEAK, rel=0.02)


def test_cases_are_kept_and_not_run_again(tmp_path, monkeypatch):
    monkeypatch.setattr(honesty, "CELLS", {"starts": [("certified",), ("saturating",)]})
    first = honesty.honesty(2, 5, tmp_path, workers=1)
    assert [one["seed"] for one in first] == [5, 6, 5, 6]
    assert all(one["reached"] for one in first)
    (tmp_path / "starts.certified.6.json").write_text('{"reached": false, "evaluations": 7}')
    again = honesty.honesty(2, 5, tmp_path, workers=1)
    assert again[1] == {**first[1], "reached": False, "evaluations": 7}
    ((kind, reached, *_),) = honesty.tables(again)["searches at the noise floor"][1][:1]
    assert (kind, reached) == ("certified", "50.0 % of 2")


def test_each_part_has_its_case():
    found = honesty.interval_case("AR(1) 0.5", 3)
    assert 0 <= found["parameters"] <= 1
    assert 0 < found["width"] < 3
    assert honesty.fault_case("tare 0.2 N·m", 0) == {"found": "tare", "named": True}
    assert honesty.fault_case("none", 0) == {"found": "", "named": True}
    wrong = honesty.verdict_case("first-order curves", "white", "1 %", 1)  # Bouc-Wen truth
    assert wrong.pop("off") > 1.3
    assert wrong == {"verdict": "no", "causes": []}
    for seed in (0, 1):  # Jiles-Atherton and Bouc-Wen, each fitted by its own kind
        right = honesty.right_case("first-order curves", "white", "1 %", seed)
        assert right.pop("off") < 1
        assert right == {"verdict": "yes", "causes": []}
    band = honesty.band_case("Jiles-Atherton", 0)
    assert band["inside"] > 0.5
    assert band["error"] < band["width"]


@pytest.mark.parametrize("family", bands.FAMILIES)
def test_truths_of_bands_follow_from_angle_and_time(family):
    truth, same = (bands.FAMILIES[family](np.random.default_rng(1)) for _ in range(2))
    angle = np.concatenate([np.linspace(truth.low, truth.high, 90), np.linspace(1.3, 1.0, 30)])
    slow, fast = (np.arange(angle.size) / rate for rate in (10.0, 40.0))
    np.testing.assert_array_equal(truth.torque(angle, slow), same.torque(angle, slow))
    depends = not np.array_equal(truth.torque(angle, slow), truth.torque(angle, fast))
    assert depends == (family == "viscous")


def test_a_contact_that_only_pushes_dissipates_and_rests():
    model = BoucWen(elastic=2.0, hysteretic=8.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=0.5)
    up, down = np.linspace(0.5, 1.5, 400), np.linspace(1.5, 0.5, 400)
    angle = np.concatenate([up, down[1:], up[1:], down[1:]])
    torque = truths.behind_gap(model, angle, 0.05)
    np.testing.assert_allclose(torque[:400], model.response(up), atol=1e-12)
    free = np.flatnonzero(torque[400:799] == 0)
    assert angle[400 + free[0]] - angle[400 + free[-1]] == pytest.approx(0.05, abs=0.006)
    assert torque[798] < 0
    cycle = slice(798, None)  # up and down again
    work = np.trapezoid(torque[cycle], angle[cycle])
    assert work > 0


def test_options_of_honesty_are_refused_elsewhere(capsys):
    with pytest.raises(SystemExit):
        main(["engine", "--quick"])
    said = capsys.readouterr().err
    assert "--quick, --seed, --out and --force belong to honesty, not to engine" in said


def test_the_command_prints_all_tables(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(honesty, "CELLS", {name: [] for name in honesty.CELLS})
    main(["honesty", "--repeats", "1", "--out", str(tmp_path / "h"), "--json"])
    assert json.loads(capsys.readouterr().out)["cases"] == []


def test_multi_order_motion():
    def motion(turns, seed):
        rng = np.random.default_rng(seed)
        return truths.multi_order_motion(0.4, 1.4, turns=turns, angle_step=0.005, rng=rng)

    for turns in [2, 3, 12]:
        for seed in range(5):
            angle = motion(turns, seed)
            places = reversals(angle, 0.0)
            assert len(places) == turns
            assert angle[0] == 0.4 < angle[1]
            assert 0.4 <= angle.min()
            assert angle.max() <= 1.4
            travels = np.abs(np.diff(angle[[0, *places, -1]]))
            assert (travels >= 0.1 - 1e-12).all()
            assert np.abs(np.diff(angle)).max() <= 0.005 * 1.03
            # Second order: the second reversal comes before the first branch is wiped out.
            assert angle[places[1]] > angle[0]
            np.testing.assert_array_equal(angle, motion(turns, seed))
