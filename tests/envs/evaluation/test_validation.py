"""Validation of believed suits: six beliefs that are wrong in known ways, and the arithmetic."""

import numpy as np
import pytest
from activesuit.assets import CURVES, Suit, curves_path, load_suit
from activesuit.envs.evaluation import FIRST_SEED, rollout, suit_validation, validate
from activesuit.envs.evaluation.verdict import (
    LIMITS,
    curve_errors,
    lag_of,
    noise_of,
    torque_error,
    torque_errors,
    verdict,
)
from activesuit.envs.making import make_arms
from activesuit.envs.model import ASSISTED
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from activesuit.hysteresis import TABLE_2, PrandtlIshlinskii
from activesuit.identification import load_curves
from helpers import assert_refused, shorten_tasks

ENV = "ActiveSuit/ArmTracking-v0"
WEIGHTLESS = {"gravity": "microgravity", "threads": 1}
DT = 0.01


def with_models(suit: Suit, models: dict) -> Suit:
    """Returns the suit with other models of the assisted joints, and nothing else changed."""
    joints = dict(suit.joints)
    for joint, model in models.items():
        joints[joint] = joints[joint].model_copy(update={"model": model})
    return suit.model_copy(update={"joints": joints})


def springs(suit: Suit) -> Suit:
    """Returns the suit with straight lines through the middles of steady cycles."""
    joints = dict(suit.joints)
    for joint in ASSISTED:
        entry = joints[joint]
        offset, stiffness = entry.steady_cycle().spring()
        one = {"stiffness": stiffness, "rest_angle": -offset / stiffness}
        line = PrandtlIshlinskii(**one, thresholds=(1.0,), weights=(0.0,))
        start = stiffness * (entry.start_angle - line.rest_angle)  # the memory begins on the line
        joints[joint] = entry.model_copy(update={"model": line, "start_torque": start})
    return suit.model_copy(update={"joints": joints})


def cases() -> dict[str, dict[str, Suit]]:
    """Returns the six beliefs by the worn suit: "emu-like", at 40 kPa, or "mock-suit"."""
    emu, mock = load_suit("emu-like"), load_suit("mock-suit")
    models = {joint: emu.joints[joint].model for joint in ASSISTED}
    mpso = {joint: TABLE_2[f"{name}-mpso"] for name, joint in CURVES.items()}
    return {
        "emu-like": {
            "exact": emu,
            "20 % more": with_models(emu, {j: m.scaled(torque=1.2) for j, m in models.items()}),
            "spring": springs(emu),
            "other suit": mock,
        },
        "emu-like at 40 kPa": {"29.6 kPa": emu},
        "mock-suit": {"exact": mock, "MPSO": with_models(mock, mpso)},
    }


@pytest.fixture(scope="module")
def six():
    """The torque errors of each belief, by the worn suit and its own name, of naive wearers."""
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 7.0)
        for name, believed in cases().items():
            worn = load_suit("emu-like").at_pressure(40) if "40" in name else name
            arms = make_arms(ENV, 8, suit=worn, **WEIGHTLESS)
            for one, suit in believed.items():
                policy = make_policy({"name": "feedforward", "suit": suit}, arms)
                traces = rollout(arms, policy, range(FIRST_SEED, FIRST_SEED + 8))
                joints = {joint: suit.joints[joint] for joint in ASSISTED}
                found[name, one] = torque_errors(joints, traces)
            arms.close()
    return found


EXACT = [("emu-like", "exact"), ("mock-suit", "exact")]
SMALL = [("emu-like", "20 % more"), ("emu-like at 40 kPa", "29.6 kPa"), ("mock-suit", "MPSO")]
LARGE = [("emu-like", "spring"), ("emu-like", "other suit")]


def test_the_torque_error_separates_six_beliefs(six):
    error = {case: found.nrmse for case, found in six.items()}
    for case in EXACT:
        assert error[case].high < 1e-5
    for case in SMALL:  # their intervals lie between those of the exact and the large errors
        assert 0.05 < error[case].low
        assert error[case].high < min(error[large].low for large in LARGE)
    spring, other = (error[case].value for case in LARGE)
    assert spring < other
    assert {six[case].verdict for case in EXACT} == {"valid"}
    assert {six[case].verdict for case in LARGE} == {"not valid"}
    assert "valid" not in {six[case].verdict for case in SMALL}
    for found in six.values():
        assert set(found.joints) == set(ASSISTED)
        for one in (*found.joints.values(), found.together):
            for interval in (one.rms, one.peak, one.bias, one.lag, one.nrmse):
                assert interval.low <= interval.value <= interval.high
    # A spring comes late and a factor does not.
    assert six["emu-like", "spring"].together.lag.low > 20  # ms
    for case in ("exact", "20 % more"):
        assert six["emu-like", case].together.lag.value == pytest.approx(0, abs=1)


def test_relief_is_compared_motion_by_motion(monkeypatch):
    shorten_tasks(monkeypatch, 1.0)
    believed = {"exact": "emu-like", "other": "mock-suit"}
    validation = validate(ENV, believed, ["emu-like"], motions=8, threads=1)
    exact, other = (validation.cells[name, "emu-like"] for name in believed)
    for one in (other.relief, other.difference, other.share_of_true, other.share_of_bound):
        assert one.low <= one.value <= one.high
    assert exact.difference.low == exact.difference.high == 0
    assert exact.share_of_true.value == 1 and other.difference.high < 0
    found = validation.evaluations["emu-like"]
    apart = found.relief("by other").value - found.relief("true model").value
    assert other.difference.value == pytest.approx(apart)
    assert other.to_dict()["verdict"] == other.torque.verdict == "not valid"


def test_the_motions_that_are_finished_are_counted_in_batches_of_any_size(monkeypatch):
    counted = []

    def evaluated(env_id, policies, on_policy, **options):
        for size in (2, 8, 1):
            on_policy("none", [None] * size)
        raise InputError("enough")

    monkeypatch.setattr(suit_validation, "evaluate", evaluated)
    options = {"motions": 8, "on_step": lambda done, total: counted.append((done, total))}
    rows = [(["emu-like"], ["mock-suit"], "enough")]
    assert_refused(lambda *suits: validate(ENV, *suits, **options), rows)
    assert counted == [(2, 40), (10, 40), (11, 40)]


def test_the_noise_is_reported_where_a_fit_left_some(six):
    assert set(six["emu-like", "exact"].noise.values()) == {None}
    noise = six["mock-suit", "exact"].noise
    joint = load_suit("mock-suit").joints["elbow_flexion"]
    assert noise["elbow_flexion"] == noise_of(joint)
    assert noise_of(joint) == pytest.approx(joint.fit_nrmse * 6, rel=0.3)


def test_errors_of_known_records():
    time = DT * np.arange(600)
    true = [np.stack([10 * np.sin(time + i), np.cos(2 * time + i)], axis=1) for i in range(8)]
    apart = torque_error([one + 0.5 for one in true], true, DT)
    for error in (apart.rms, apart.peak, apart.bias):
        assert error.value == pytest.approx(0.5)
    largest = np.max([np.abs(one).max(axis=0) for one in true], axis=0)
    assert apart.nrmse.value == pytest.approx(np.sqrt(np.mean((0.5 / largest) ** 2)))
    assert apart.lag.value == 0


@pytest.mark.parametrize("lag", [-0.05, 0.0, 0.034, 0.15])
def test_a_lag_is_found(lag):
    time = DT * np.arange(600)
    early, late = (np.sin(time - shift)[:, None] + 0.3 for shift in (0, lag))
    assert lag_of(2 * late, early, DT) == pytest.approx(lag, abs=0.0011)
    assert lag_of(np.ones_like(early), early, DT) == 0


def test_verdicts_at_the_limits():
    valid, usable = LIMITS["valid"], LIMITS["usable"]
    assert [verdict(error) for error in (0, valid, usable)] == ["valid", "valid", "usable"]
    assert verdict(np.nextafter(usable, 1)) == "not valid"


def test_held_out_curves_are_predicted():
    curves = load_curves(curves_path("elbow")).held_out()
    series = {curve.name: (curve.angle, curve.torque) for curve in curves}
    joint = load_suit("mock-suit").joints["elbow_flexion"]
    good = curve_errors(joint, series)
    assert [error.curve for error in good] == curves.names
    assert max(error.nrmse for error in good) < 0.02
    mpso = curve_errors(joint.model_copy(update={"model": TABLE_2["elbow-mpso"]}), series)
    assert min(error.nrmse for error in mpso) > 0.05


def test_beliefs_that_cannot_be_validated():
    wrist = {"wrist_flexion": load_suit("emu-like").joints["wrist_flexion"]}
    rows = [
        (wrist, {}, "and neither shoulder_flexion nor elbow_flexion"),
        (load_suit("mock-suit"), {"motions": 7}, "motions is 7: use at least 8"),
    ]
    assert_refused(
        lambda mine, given: validate(ENV, {"mine": mine}, ["mock-suit"], threads=1, **given), rows
    )
