"""The Gymnasium environments: reproducibility and honest observations."""

import mujoco
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.hysteresis import UncertifiedModelError
from arms import addresses, state


def play(env, steps, seed):
    rng = np.random.default_rng(5)
    results = [np.append(env.reset(seed=seed)[0], 0.0)]
    for _ in range(steps):
        observation, reward, *_ = env.step(rng.uniform(-1, 1, 2).astype(np.float32))
        results.append(np.append(observation, reward))
    return np.array(results)


@pytest.mark.parametrize(
    ("options", "steps"),
    [({}, 1000), ({"gravity": "microgravity", "control_dt": 0.02, "sim_dt": 0.001}, 500)],
)
def test_an_episode_lasts_ten_seconds(options, steps):
    env = ArmEnv(**options)
    env.reset(seed=0)
    assert env.metadata["render_fps"] == steps / 10
    for step in range(1, steps + 1):
        observation, _, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        assert not terminated and observation in env.observation_space
        assert truncated == (step == steps)
    assert info["time"] == pytest.approx(10.0)


def test_same_seed_same_everything():
    env = ArmEnv()
    first = play(env, 100, seed=3)
    assert (np.ptp(first[1:, :-1], axis=0) > 1e-4).all()  # no element is constant
    # Another episode came before, and another instance.
    np.testing.assert_array_equal(first, play(env, 100, seed=3))
    np.testing.assert_array_equal(first, play(ArmEnv(), 100, seed=3))
    assert not np.array_equal(first, play(env, 100, seed=4))
    env.reset(seed=3)
    assert not np.array_equal(env.reset()[0], first[0, :-1])


def test_observation_is_fresh_and_means_what_the_layout_says():
    env = ArmEnv(sensors=["encoders", "preview", "privileged"])
    env.reset(seed=0)
    for _ in range(50):
        observation, *_, info = env.step(np.array([0.3, -0.2], np.float32))
    layout = env.layout
    count = 2 * np.pi / 2**14  # encoder count [rad]
    assert np.abs(observation[layout["angle"]] - env.data.qpos).max() <= 0.501 * count
    # A rate of whole counts in a control period, smoothed over some.
    np.testing.assert_allclose(observation[layout["rate"]], env.data.qvel, atol=count / 0.01)
    motor_torque = observation[layout["motor_torque"]] * addresses(env).peak_torque
    np.testing.assert_allclose(motor_torque, info["assist_torque"], rtol=1e-5)
    np.testing.assert_allclose(observation[layout["previous_action"]], [0.3, -0.2], rtol=1e-6)
    np.testing.assert_allclose(observation[layout["suit_torque"]], info["suit_torque"], rtol=1e-5)
    ahead = state(env).angle[0, [52, 60, 74]][:, [1, 2]]
    np.testing.assert_allclose(observation[layout["target"]].reshape(3, 2), ahead, rtol=1e-6)
    data, at = env.data, addresses(env)
    hand = data.site("hand_grip").xpos.copy()
    mujoco.mj_forward(env.model, data)  # a stale state would move now
    np.testing.assert_array_equal(data.site("hand_grip").xpos, hand)
    suit = info["suit_torque"][at.suited]
    np.testing.assert_allclose(data.sensordata[at.suit_torque], suit, atol=1e-12)


def test_actions_are_clipped():
    env = ArmEnv()
    env.reset(seed=0)
    for action in ([5.0, -0.5], [1.0, -1.0]):
        assert env.step(np.array(action))[-1]["clipped_actions"] == 1
    np.testing.assert_allclose(state(env).command[0], [1, -1])
    # The first command was clipped to 1: the motors never exceed their peak.
    greatest = np.zeros(2)
    for _ in range(50):
        info = env.step(np.array([9.0, 9.0]))[-1]
        greatest = np.maximum(greatest, info["assist_torque"])
    assert (greatest <= addresses(env).peak_torque * (1 + 1e-12)).all()
    # A moving motor has less, and the elbow moves at once.
    assert (greatest > (0.999, 0.9) * addresses(env).peak_torque).all()


def test_uncertified_suit_needs_consent():
    with pytest.raises(UncertifiedModelError, match=r"shoulder_flexion.*margin is -0"):
        ArmEnv(suit="published-2022")
    env = ArmEnv(suit="published-2022", allow_uncertified=True)
    env.reset(seed=0)
    env.step(np.zeros(2))


def test_a_history_contains_the_last_observations():
    plain, stacked = ArmEnv(), ArmEnv(history=3)
    assert stacked.observation_space.shape == (36,)
    first, shown = plain.reset(seed=2)[0], stacked.reset(seed=2)[0]
    np.testing.assert_array_equal(shown, np.tile(first, 3))
    seen, action = [first, first, first], np.empty(2)
    for value in (0.1, -0.2, 0.3, 0.4):
        action[:] = value  # the same array again
        seen.append(plain.step(action)[0])
        shown = stacked.step(action)[0]
        np.testing.assert_array_equal(shown, np.concatenate(seen[:-4:-1]))
    state = stacked.get_state()
    stacked.reset(seed=5)
    np.testing.assert_array_equal(stacked.set_state(state)[0], shown)


def test_normalized_observations_are_of_the_size_of_one():
    seen, sensors = [], ["encoders", "cuffs", "preview", "privileged"]
    for normalize in (False, True):
        env = ArmEnv(normalize=normalize, coupling="cuffs", sensors=sensors)
        env.reset(seed=1)
        rng = np.random.default_rng(0)
        seen.append(np.array([env.step(rng.uniform(-0.5, 0.5, 2))[0] for _ in range(200)]))
    plain, scaled = seen
    assert np.abs(plain).max() > 10 and np.abs(scaled).max() < 4
    force = env.layout["cuff_force"]
    np.testing.assert_allclose(plain[:, force], 100 * scaled[:, force], rtol=1e-5)
