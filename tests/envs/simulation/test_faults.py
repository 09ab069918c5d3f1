"""Faults of sensors and motors: what the controller receives, and what the arm does."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.model import ASSISTED

SUITES = ["encoders", "interaction", "cuffs"]
SHOULDER, ELBOW = (JOINTS.index(joint) for joint in ASSISTED)


def observed(faults, periods=150, rows=None, sensors=SUITES, **options):
    """Returns parts of the observations over time by name, and the torque of the motors [N·m]."""
    env = ArmEnv(coupling="cuffs", sensors=sensors, faults=faults, **options)
    seen, info = env.reset(seed=3)
    found, torque = [seen], [info["assist_torque"]]
    for k in range(periods):
        seen, *_, info = env.step(0.2 * np.sin(0.05 * k) * np.ones(2))
        found.append(seen)
        torque.append(info["assist_torque"])
    parts = {name: np.array(found)[:, part] for name, part in env.layout.items()}
    return parts, np.array(torque)


@pytest.fixture(scope="module")
def usual():
    return observed({})


def test_a_bias_is_added_and_a_drift_grows(usual):
    faults = {"torque_bias": 3, "torque_drift": -0.5, "force_bias": -20, "force_drift": 4}
    found, right = observed(faults)[0], usual[0]
    time = 0.01 * np.arange(151)[:, None]
    for name, bias, drift in (("interaction_torque", 3, -0.5), ("cuff_force", -20, 4)):
        error = found[name] - right[name] - (bias + drift * time)
        np.testing.assert_allclose(error, 0, atol=1e-4)
    np.testing.assert_array_equal(found["angle"], right["angle"])


def test_late_readings_are_those_of_the_period_before(usual):
    found, right = observed({"late": 1})[0], usual[0]
    for name in ("angle", "rate", "interaction_torque", "cuff_force", "motor_torque"):
        np.testing.assert_array_equal(found[name][1:], right[name][:-1])
    np.testing.assert_array_equal(found["previous_action"], right["previous_action"])


def test_lost_readings_leave_the_last_ones(usual):
    share = 0.3
    found, right = observed({"lost": share})[0], usual[0]
    same = np.isclose(found["interaction_torque"], right["interaction_torque"], atol=0).all(axis=1)
    held = np.append(False, (np.diff(found["interaction_torque"], axis=0) == 0).all(axis=1))
    assert (same | held).all()
    assert np.mean(held) == pytest.approx(share, abs=0.1)
    # The sensors filter their own readings: nothing of a loss remains in the next rate.
    np.testing.assert_array_equal(found["rate"][same], right["rate"][same])


def test_a_stuck_encoder_stays_and_shows_no_rate(usual):
    found, right = observed({"stuck": ["elbow_flexion"], "since": 0.5})[0], usual[0]
    np.testing.assert_array_equal(found["angle"][:50], right["angle"][:50])
    assert np.ptp(found["angle"][50:, ELBOW]) == 0 < np.ptp(right["angle"][50:, ELBOW])
    assert not found["rate"][50:, ELBOW].any()
    np.testing.assert_array_equal(found["angle"][:, SHOULDER], right["angle"][:, SHOULDER])


def test_a_motor_that_stops_gives_no_torque(usual):
    since = 0.5
    found, torque = observed({"stopped": ["elbow_flexion"], "since": since})
    stop = round(since / 0.01)
    np.testing.assert_array_equal(torque[:stop], usual[1][:stop])
    assert np.abs(torque[stop + 30 :, 1]).max() < 1e-3 < np.abs(torque[stop + 30 :, 0]).max()
    command, own = found["previous_action"], usual[0]["previous_action"]
    np.testing.assert_allclose(command, own, atol=1e-6)  # of the controller
