"""Sensors on the person: their signals, delays and noise."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.model import bare_arm
from activesuit.envs.simulation.inverse_dynamics import Chain, arm_torques
from arms import state

EXACT = {"interaction_noise": 0.0, "interaction_delay": 0.0, "emg_noise": 0.0, "emg_cutoff": 1000.0}
PERIODS = 200
ACTIONS = 0.3 * np.random.default_rng(0).uniform(-1, 1, (PERIODS, 2))


def series(sensing, **options):
    """Returns interaction torque, EMG and info of a motion, by period."""
    env = ArmEnv(sensors=["interaction", "emg"], sensing=sensing, **options)
    env.reset(seed=3)
    shown, infos = [], []
    for action in ACTIONS[:, : env.action_space.shape[0]]:
        observation, *_, info = env.step(action)
        shown.append(observation)
        infos.append(info)
    parts = [np.array(shown)[:, env.layout[name]] for name in ("interaction_torque", "emg")]
    reported = {name: np.array([info[name] for info in infos]) for name in infos[0]}
    return *parts, reported, env


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
    resisted, sensed = -reported["suit_torque"][:, column], interaction[:, column]
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
    _, emg, reported, env = series(EXACT, control=calm)
    kept, chain = state(env), Chain.of(bare_arm(env.config))
    own = arm_torques(chain, kept.angle[0], kept.rate[0], kept.acceleration[0])
    ahead = own[np.arange(1, PERIODS + 1) + 5] + kept.correction[0]
    np.testing.assert_allclose(emg, ahead, rtol=1e-5, atol=1e-5)
    assert np.abs(series(EXACT)[1] - emg).max() > 0.5  # with feedback
    assert reported["time"][0] == pytest.approx(0.01)
