"""The Gymnasium environments: reproducibility, observations, people, couplings and motors."""

import doctest
import json
from importlib import import_module

import gymnasium
import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.model import ASSISTED
from activesuit.envs.model.cuffs import FORCE_LIMITS
from activesuit.envs.person import Person, isometric_strength, strength_limits
from activesuit.envs.policies import make_policy
from activesuit.hysteresis import UncertifiedModelError
from arms import addresses, go_on, physics, reported, rewarded, state
from helpers import assert_refused


def play(env, seed):
    first = np.append(env.reset(seed=seed)[0], 0.0)
    return np.vstack([first, rewarded(env, ACTIONS[:100])])


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
    first = play(env, seed=3)
    assert (np.ptp(first[1:, :-1], axis=0) > 1e-4).all()  # no element is constant
    # Another episode came before, and another instance.
    np.testing.assert_array_equal(first, play(env, seed=3))
    np.testing.assert_array_equal(first, play(ArmEnv(), seed=3))
    assert not np.array_equal(first, play(env, seed=4))
    env.reset(seed=3)
    assert not np.array_equal(env.reset()[0], first[0, :-1])


def test_observation_is_fresh_and_means_what_the_layout_says():
    env = ArmEnv(sensors=["encoders", "preview", "privileged"])
    env.reset(seed=0)
    observation, *_, info = go_on(env, 50, [0.3, -0.2])
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
    greatest = reported(env, np.full((50, 2), 9.0))["assist_torque"].max(axis=0)
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
    assert_refused(stacked.step, [([np.nan, 0.0], "finite")])  # and leaves the history alone
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


ENV = "ActiveSuit/ArmTracking-v0"
ACTIONS = np.random.default_rng(5).uniform(-1, 1, (200, 2))


@pytest.mark.parametrize(
    "options",
    [
        {"coupling": "cuffs", "misalignment": (0.02, 0.0, -0.01)},
        {"coupling": "none", "suit": "none", "control": {"stiff": True}},
        {"side": "left", "tilt": (0.5, -0.3), "payload": {"mass": 2.0}},
        {"wearer": {"sex": "female", "stature": 1.5, "mass": 50.0}, "gravity": "moon"},
    ],
)
def test_begins_at_rest(options):
    env = ArmEnv(**options)
    for seed in range(3):
        before = env.reset(seed=seed)[1]["angle"]
        np.testing.assert_allclose(env.data.qfrc_smooth, 0, atol=1e-9)
        assert np.abs(go_on(env, 5)[-1]["angle"] - before).max() < 0.01


def test_options_are_plain_data():
    options = {"wearer": {"stature": 1.6}, "payload": {"mass": 1.0}, "coupling": "cuffs"}
    options |= {"randomize": {"pressure": 0.1}, "render_quality": "fine", "picture_dt": 0.04}
    text = gymnasium.make(ENV, **options).spec.to_json()
    assert json.loads(text)["kwargs"] == {"task": "ArmTracking", **options}
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(text)).unwrapped
    assert again.config == ArmEnv(**{**options, "wearer": Person(stature=1.6)}).config
    assert again.episodes.setup.randomize == Randomization(pressure=0.1)


def test_on_cuffs_the_exoskeleton_measures_itself():
    env = ArmEnv(coupling="cuffs", sensors=["encoders", "cuffs"], sensing={"cuff_noise": 0.0})
    env.reset(seed=0)
    for action in 0.3 * ACTIONS:
        env.step(action)
    observation, *_, info = go_on(env, 30)  # rates then change slowly
    layout, data = env.layout, env.data
    np.testing.assert_allclose(observation[layout["angle"]], data.qpos[4:], atol=2e-4)
    np.testing.assert_allclose(observation[layout["rate"]], data.qvel[4:], atol=0.05)
    np.testing.assert_array_equal(info["angle"], data.qpos[:4])
    assert np.abs(data.qpos[4:] - data.qpos[:4]).max() > 1e-3
    force = [data.sensor(f"cuff_{segment}_force").data for segment in FORCE_LIMITS]
    np.testing.assert_array_equal(info["cuff_force"], force)
    np.testing.assert_allclose(observation[layout["cuff_force"]], np.ravel(force), rtol=1e-6)


def test_on_cuffs_the_motors_work_on_the_joints_that_they_turn():
    env = ArmEnv(coupling="cuffs")
    env.reset(seed=0)
    work, on_arm = 0.0, 0.0
    for action in 0.3 * ACTIONS:
        info = env.step(action)[-1]
        rate = [env.data.joint(f"exo_{joint}").qvel[0] for joint in ASSISTED]
        work += 0.01 * np.abs(info["assist_torque"] * rate).sum()
        on_arm += 0.01 * np.abs(info["assist_torque"] * info["rate"][addresses(env).assisted]).sum()
    assert info["assist_energy"] == pytest.approx(work)
    assert abs(work - on_arm) > 0.1 * work


def test_without_an_exoskeleton_there_is_nothing_to_act_with():
    env = ArmEnv(coupling="none")
    observation, info = env.reset(seed=0)
    assert env.action_space.shape == (0,)
    assert {"motor_torque", "previous_action", "cuff_force"}.isdisjoint(env.layout)
    assert observation.shape == (8,)
    assert_refused(env.step, [(np.zeros(2), r"action has shape \(2,\): give \(0,\)")])
    info = env.step(np.zeros(0))[-1]
    assert info["assist_torque"].tolist() == [0, 0]
    assert "motor_load" not in info
    other = ArmEnv(coupling="none", sensors=["encoders", "privileged"])
    names = ("gravity", "feedforward", "oracle")
    rows = [(name, other, f"policy '{name}' needs motors, and coupling is") for name in names]
    assert_refused(make_policy, rows)


def test_encoders_are_as_fine_and_as_late_as_they_are_said_to_be():
    env, late = ArmEnv(exo={"encoder_bits": 6}), ArmEnv(exo={"encoder_delay": 0.02})
    env.reset(seed=0)
    first = late.reset(seed=0)[0][late.layout["angle"]]
    angle = [physics(late, "qpos").copy()]
    np.testing.assert_allclose(first, angle[0], atol=2e-4)
    for action in ACTIONS[:30]:
        coarse = env.step(action)[0][env.layout["angle"]] / (2 * np.pi / 64)
        np.testing.assert_allclose(coarse, np.round(coarse), atol=1e-5)
        reported = late.step(action)[0]
        angle.append(physics(late, "qpos").copy())
    np.testing.assert_allclose(reported[late.layout["angle"]], angle[-3], atol=2e-4)
    assert np.abs(angle[-3] - angle[-1]).max() > 0.005


def test_a_motor_that_is_driven_hard_ends_at_its_continuous_torque():
    exo = {"elbow": {"thermal_time_constant": 0.2, "continuous_torque": 5.0}}
    env = ArmEnv(exo=exo, gravity="microgravity")
    env.reset(seed=0)
    found = reported(env, np.tile([0.0, -0.5], (150, 1)))
    torque, load = found["assist_torque"][:, 1], found["motor_load"]
    assert -12.5 <= min(torque) < -11  # a moving motor has less
    assert torque[-1] == pytest.approx(-5, abs=0.05)
    assert np.max(load) < 1.05  # the motors lag behind the limit
    assert load[-1][1] == pytest.approx(1, abs=0.01) and load[-1][0] < 0.01


@pytest.mark.parametrize("wearer", [{}, {"sex": "female", "mass": 50.0, "strength": 5.0}])
def test_nobody_asks_for_more_than_their_strength(wearer):
    env = ArmEnv(wearer=wearer, payload={"mass": 3.0}, control={"adaptation": 0.0})
    info = env.reset(seed=1)[1]
    strength, at = isometric_strength(Person(**wearer)), addresses(env)
    gains, least = env.episodes.simulation.batch.expand("actuator_biasprm")[0], []
    for _ in range(100):
        low, high = strength_limits(strength, info["angle"], info["rate"])
        angle, rate = info["angle"], info["rate"]
        info = env.step(np.zeros(2))[-1]
        intended, ahead, torque = physics(env, "ctrl")[at.intention]
        stiffness, damping = -gains[at.human, 1:3].T
        torque = torque + stiffness * (intended - angle) + damping * (ahead - rate)
        least.append(np.minimum(torque - low, high - torque).min())
    error = np.abs(info["angle"] - info["target_angle"])[1]
    assert min(least) > -1e-9
    if wearer:  # she is too weak for this
        assert min(least) < 1e-9 and error > 0.2
    else:
        assert error < 0.15


def test_an_effort_tires_only_who_can_tire():
    tiring, tireless = ArmEnv(fatigue=True, payload={"mass": 4.0}), ArmEnv(payload={"mass": 4.0})
    assert "fatigue" not in tireless.reset(seed=0)[1]
    assert not tiring.reset(seed=0)[1]["fatigue"].any()
    fatigue = reported(tiring, np.zeros((300, 2)))["fatigue"]
    flexor = fatigue[:, 1, JOINTS.index("shoulder_flexion")]
    assert (np.diff(flexor) > 0).all() and 0.01 < flexor[-1] < 0.1
    assert fatigue[-1][0].max() < 2e-3  # extensors co-contract, but hardly work
    assert not tiring.reset(seed=0)[1]["fatigue"].any()


def test_the_left_arm_moves_as_the_right_one_and_noise_is_only_where_it_is_asked_for():
    left, right, noisy = ArmEnv(side="left"), ArmEnv(), ArmEnv(control={"noise": 1.0})
    np.testing.assert_allclose(left.reset(seed=0)[0], right.reset(seed=0)[0], atol=1e-6)
    usual = rewarded(right, ACTIONS)
    np.testing.assert_allclose(rewarded(left, ACTIONS), usual, atol=1e-4)
    noisy.reset(seed=0)
    assert np.abs(rewarded(noisy, ACTIONS) - usual).max() > 1e-3
    for control_dt in (0.02, 0.004):  # the usual delay fits every control period
        env = ArmEnv(control_dt=control_dt)
        env.reset(seed=0)
        delay = env.episodes.simulation.control.delay
        assert abs(delay - 0.05) <= control_dt / 2 + 1e-12
        assert state(env).reflex_delay.shape[1] == round(delay / control_dt)


MODULES = (
    *("", ".arm_env", ".vector_env", ".episodes", ".setup", ".simulation.simulation"),
    ".simulation.bound_kernels",
)


@pytest.mark.parametrize("name", MODULES)
def test_the_example_of_a_module(name):
    found = doctest.testmod(import_module(f"activesuit.envs{name}"))
    assert found.attempted > 3 and not found.failed
