"""Sensors on the person, and faults of sensors and motors."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.model import ASSISTED, bare_arm
from activesuit.envs.simulation.inverse_dynamics import Chain, arm_torques
from arms import state

EXACT = {"interaction_noise": 0.0, "interaction_delay": 0.0, "emg_noise": 0.0, "emg_cutoff": 1000.0}
PERIODS = 200
ACTIONS = 0.3 * np.random.default_rng(0).uniform(-1, 1, (PERIODS, 2))


def observed(actions, **options):
    """Returns what is observed and what `info` says over time, by name, and the arm."""
    env = ArmEnv(**options)
    answers = [env.reset(seed=3), *(env.step(one[: env.action_space.shape[0]]) for one in actions)]
    shown, infos = np.array([answer[0] for answer in answers]), [answer[-1] for answer in answers]
    parts = {name: shown[:, part] for name, part in env.layout.items()}
    return parts, {name: np.array([info[name] for info in infos]) for name in infos[0]}, env


def series(sensing, **options):
    """Returns interaction torque, EMG and info of a motion, by period."""
    parts, *rest = observed(ACTIONS, sensors=["interaction", "emg"], sensing=sensing, **options)
    return parts["interaction_torque"][1:], parts["emg"][1:], *rest


@pytest.mark.parametrize("coupling", ["rigid", "cuffs", "none"])
def test_without_suit_and_exoskeleton_there_is_nothing_between(coupling):
    suit = "none" if coupling == "none" else "mock-suit"
    interaction, *_ = series(EXACT, coupling=coupling, suit=suit)
    largest = np.abs(interaction).max(axis=0)
    if coupling == "none":
        # What is left: the armature that keeps the integration stable, and the physics step.
        assert largest.max() < 0.3
    else:
        assert largest[JOINTS.index("shoulder_flexion")] > 5


def test_interaction_is_what_the_suit_resists_without_weight():
    place = {"gravity": "microgravity", "coupling": "none", "suit": "emu-like"}
    interaction, _, reported, _ = series(EXACT, **place)
    column = JOINTS.index("elbow_flexion")
    resisted, sensed = -reported["suit_torque"][1:, column], interaction[:, column]
    # The suit's arm has mass, too: its inertia is between person and suit as well.
    assert np.abs(sensed - resisted).max() < 0.15 * np.abs(resisted).max()


def test_interaction_comes_late_emg_is_slow_and_both_are_noisy():
    exact, emg, *_ = series(EXACT)
    late, *_ = series({**EXACT, "interaction_delay": 0.03})
    np.testing.assert_array_equal(late[3:], exact[:-3])
    noisy = series({**EXACT, "interaction_noise": 0.1, "emg_noise": 0.2})
    for right, wrong, noise in ((exact, noisy[0], 0.1), (emg, noisy[1], 0.2)):
        error = (wrong - right)[np.abs(right) > 1] / right[np.abs(right) > 1]
        assert error.std() == pytest.approx(noise, rel=0.15)
    usual, *_ = series({})
    assert np.abs(usual[5:] - exact[:-5]).max() > 0.5
    slow = series({**EXACT, "emg_cutoff": 2.0})[1]
    assert np.abs(np.diff(slow, axis=0)).max() < np.abs(np.diff(emg, axis=0)).max()


def test_emg_is_the_voluntary_torque_ahead_of_time():
    calm = {"reflex": 0.0, "correction": 0.0, "adaptation": 0.0}
    _, emg, _, env = series(EXACT, control=calm)
    kept, chain = state(env), Chain.of(bare_arm(env.config))
    own = arm_torques(chain, kept.angle[0], kept.rate[0], kept.acceleration[0])
    ahead = own[np.arange(1, PERIODS + 1) + 5] + kept.correction[0]
    np.testing.assert_allclose(emg, ahead, rtol=1e-5, atol=1e-5)
    assert np.abs(series(EXACT)[1] - emg).max() > 0.5  # with feedback


SUITES = ["encoders", "interaction", "cuffs"]
SHOULDER, ELBOW = (JOINTS.index(joint) for joint in ASSISTED)


WAVES = 0.2 * np.sin(0.05 * np.arange(150))[:, None] * np.ones(2)


def faulty(faults):
    """Returns what is observed over time by name, and the torque of the motors [N·m]."""
    parts, infos, _ = observed(WAVES, coupling="cuffs", sensors=SUITES, faults=faults)
    return parts, infos["assist_torque"]


@pytest.fixture(scope="module")
def usual():
    return faulty({})


def test_a_bias_is_added_and_a_drift_grows(usual):
    faults = {"torque_bias": 3, "torque_drift": -0.5, "force_bias": -20, "force_drift": 4}
    found, right = faulty(faults)[0], usual[0]
    time = 0.01 * np.arange(151)[:, None]
    for name, bias, drift in (("interaction_torque", 3, -0.5), ("cuff_force", -20, 4)):
        error = found[name] - right[name] - (bias + drift * time)
        np.testing.assert_allclose(error, 0, atol=1e-4)
    np.testing.assert_array_equal(found["angle"], right["angle"])


def test_late_readings_are_those_of_the_period_before(usual):
    found, right = faulty({"late": 1})[0], usual[0]
    for name in ("angle", "rate", "interaction_torque", "cuff_force", "motor_torque"):
        np.testing.assert_array_equal(found[name][1:], right[name][:-1])
    np.testing.assert_array_equal(found["previous_action"], right["previous_action"])


def test_lost_readings_leave_the_last_ones(usual):
    share = 0.3
    found, right = faulty({"lost": share})[0], usual[0]
    same = np.isclose(found["interaction_torque"], right["interaction_torque"], atol=0).all(axis=1)
    held = np.append(False, (np.diff(found["interaction_torque"], axis=0) == 0).all(axis=1))
    assert (same | held).all()
    assert np.mean(held) == pytest.approx(share, abs=0.1)
    # The sensors filter their own readings: nothing of a loss remains in the next rate.
    np.testing.assert_array_equal(found["rate"][same], right["rate"][same])


def test_a_stuck_encoder_stays_and_shows_no_rate(usual):
    found, right = faulty({"stuck": ["elbow_flexion"], "since": 0.5})[0], usual[0]
    np.testing.assert_array_equal(found["angle"][:50], right["angle"][:50])
    assert np.ptp(found["angle"][50:, ELBOW]) == 0 < np.ptp(right["angle"][50:, ELBOW])
    assert not found["rate"][50:, ELBOW].any()
    np.testing.assert_array_equal(found["angle"][:, SHOULDER], right["angle"][:, SHOULDER])


def test_a_motor_that_stops_gives_no_torque(usual):
    since = 0.5
    found, torque = faulty({"stopped": ["elbow_flexion"], "since": since})
    stop = round(since / 0.01)
    np.testing.assert_array_equal(torque[:stop], usual[1][:stop])
    assert np.abs(torque[stop + 30 :, 1]).max() < 1e-3 < np.abs(torque[stop + 30 :, 0]).max()
    command, own = found["previous_action"], usual[0]["previous_action"]
    np.testing.assert_allclose(command, own, atol=1e-6)  # of the controller
