"""The environment with other people, couplings, loads and motors."""

import json

import gymnasium
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.model import ASSISTED
from activesuit.envs.model.cuffs import FORCE_LIMITS
from activesuit.envs.person import Person, isometric_strength, strength_limits
from activesuit.envs.policies import make_policy
from arms import addresses, physics, state
from helpers import assert_refused

ENV = "ActiveSuit/ArmTracking-v0"
ACTIONS = np.random.default_rng(5).uniform(-1, 1, (200, 2))


def play(env, actions):
    return np.array([np.append(*env.step(action)[:2]) for action in actions])


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
        for _ in range(5):
            info = env.step(np.zeros(env.action_space.shape))[-1]
        assert np.abs(info["angle"] - before).max() < 0.01


def test_options_are_plain_data():
    options = {"wearer": {"stature": 1.6}, "payload": {"mass": 1.0}, "coupling": "cuffs"}
    options |= {"randomize": {"pressure": 0.1}, "render_quality": "fine", "picture_dt": 0.04}
    text = gymnasium.make(ENV, **options).spec.to_json()
    assert json.loads(text)["kwargs"] == {"task": "ArmTracking", **options}
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(text)).unwrapped
    assert again.config == ArmEnv(**{**options, "wearer": Person(stature=1.6)}).config
    assert again.episodes.setup.randomize == Randomization(pressure=0.1)


# --- Exoskeleton --------------------------------------------------------------------------------


def test_on_cuffs_the_exoskeleton_measures_itself():
    env = ArmEnv(coupling="cuffs", sensors=["encoders", "cuffs"], sensing={"cuff_noise": 0.0})
    env.reset(seed=0)
    for action in 0.3 * ACTIONS:
        env.step(action)
    for _ in range(30):  # rates then change slowly
        observation, *_, info = env.step(np.zeros(2))
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
    torque, load = [], []
    for _ in range(150):
        info = env.step(np.array([0.0, -0.5]))[-1]
        torque.append(info["assist_torque"][1])
        load.append(info["motor_load"])
    assert -12.5 <= min(torque) < -11  # a moving motor has less
    assert torque[-1] == pytest.approx(-5, abs=0.05)
    assert np.max(load) < 1.05  # the motors lag behind the limit
    assert load[-1][1] == pytest.approx(1, abs=0.01) and load[-1][0] < 0.01


# --- Wearer -------------------------------------------------------------------------------------


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
    fatigue = [tiring.reset(seed=0)[1]["fatigue"]]
    for _ in range(300):
        info = tiring.step(np.zeros(2))[-1]
        fatigue.append(info["fatigue"])
    assert not fatigue[0].any()
    flexor = np.array(fatigue)[:, 1, JOINTS.index("shoulder_flexion")]
    assert (np.diff(flexor) > 0).all() and 0.01 < flexor[-1] < 0.1
    assert fatigue[-1][0].max() < 2e-3  # extensors co-contract, but hardly work
    assert not tiring.reset(seed=0)[1]["fatigue"].any()


def test_the_left_arm_moves_as_the_right_one_and_noise_is_only_where_it_is_asked_for():
    left, right, noisy = ArmEnv(side="left"), ArmEnv(), ArmEnv(control={"noise": 1.0})
    np.testing.assert_allclose(left.reset(seed=0)[0], right.reset(seed=0)[0], atol=1e-6)
    usual = play(right, ACTIONS)
    np.testing.assert_allclose(play(left, ACTIONS), usual, atol=1e-4)
    noisy.reset(seed=0)
    assert np.abs(play(noisy, ACTIONS) - usual).max() > 1e-3
    for control_dt in (0.02, 0.004):  # the usual delay fits every control period
        env = ArmEnv(control_dt=control_dt)
        env.reset(seed=0)
        delay = env.episodes.simulation.control.delay
        assert abs(delay - 0.05) <= control_dt / 2 + 1e-12
        assert state(env).reflex_delay.shape[1] == round(delay / control_dt)
