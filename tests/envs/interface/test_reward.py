"""The reward, the costs beside it, that nobody gains from ending early, and own rewards."""

from types import SimpleNamespace

import gymnasium
import numpy as np
import own_rewards
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate, rollout, score
from activesuit.envs.interface.reward import COSTS, JOINT, STRAIN, WIDTH, cost_terms, is_success
from activesuit.envs.model.cuffs import FORCE_LIMITS
from activesuit.envs.person import Person, VoluntaryControl, isometric_strength, strength_limits
from activesuit.envs.plant import Plant
from activesuit.envs.policies import NoAssist, make_policy
from activesuit.envs.simulation.wearer_control import COCONTRACTION
from activesuit.envs.tasks import ARM_TRACKING, RandomMoves
from activesuit.envs.vector_env import ArmVectorEnv
from arms import addresses, physics, reported
from helpers import assert_refused

ASSISTED = [1, 2]
STILL = RandomMoves(name="Still", hold={"elbow_flexion": (0.8, 0.9)}, duration=2.0)


@pytest.fixture(scope="module", params=["rigid", "cuffs"])
def motion(request):
    """A motion under random actions, with all that the environment returns."""
    env = ArmEnv(coupling=request.param, exo={"elbow": {"continuous_torque": 4.0}})
    env.reset(seed=2)
    rng = np.random.default_rng(1)
    actions = np.repeat(rng.uniform(-0.8, 0.8, (50, 2)), 2, axis=0)
    return SimpleNamespace(env=env, actions=actions, **reported(env, actions))


def test_rewards_by_hand(motion):
    env = motion.env
    change = np.diff(motion.actions, axis=0, prepend=motion.actions[:1])
    strength = isometric_strength(env.config.wearer)
    low, high = strength_limits(strength, motion.angle, np.zeros_like(motion.angle))
    torque = motion.human_torque
    usual = VoluntaryControl().impedance(env.config.wearer)[COCONTRACTION]
    pulls = (np.maximum(torque, 0) + usual) / high, (np.maximum(-torque, 0) + usual) / -low
    effort = np.maximum(*pulls)
    np.testing.assert_allclose(motion.effort, effort, rtol=1e-9)
    error = motion.angle - motion.target_angle
    x, e, d = (np.mean(part**2, axis=1) for part in (effort, error, change))
    scale = env.episodes.effort_scale
    expected = 1 / (1 + x / scale**2 + e / 0.1**2 + d / 0.25**2)
    np.testing.assert_allclose(motion.reward, expected, rtol=1e-9)
    assert 0 < motion.reward.min() <= motion.reward.max() < 1


def test_costs_by_hand(motion):
    costs = motion.cost_terms[-1]
    assert tuple(costs) == COSTS
    change = np.diff(motion.actions, axis=0)
    assert costs["chatter"] == pytest.approx(np.sum(change**2))
    error = motion.angle - motion.target_angle
    assert costs["tracking"] == pytest.approx(np.sqrt(np.mean(error**2)))
    power = motion.assist_torque * motion.rate[:, ASSISTED]
    assert costs["wrong_way_work"] == pytest.approx(0.01 * np.sum(np.maximum(0, -power)))
    assert costs["wrong_way_work"] > 0.05
    assert costs["heat"] == pytest.approx(motion.motor_load.max())
    if motion.env.config.coupling == "cuffs":
        force = np.linalg.norm(motion.cuff_force, axis=2) / list(FORCE_LIMITS.values())
        assert costs["cuff_force"] == pytest.approx(force.max())
        assert costs["cuff_force"] > 0.1
    else:
        assert costs["cuff_force"] == 0
    assert costs["range_stops"] == 0


def test_the_scale_is_the_suited_arms_effort():
    def scale(**options):
        return ArmEnv(**options).episodes.effort_scale

    free = {"gravity": "microgravity", "coupling": "none"}
    assert scale() > scale(suit="none") > 0.05
    assert scale(coupling="none") == pytest.approx(scale(), rel=1e-9)
    assert scale(suit="none", **free) == pytest.approx(0.031, abs=0.004)  # co-contraction alone
    relaxed = {"control": {"contraction": 0}, **free}
    assert scale(**relaxed) > 2 * scale(suit="none", **relaxed)
    given = ArmVectorEnv(1, effort_scale=0.2, threads=1).episodes.effort_scale
    assert given == 0.2


def test_joints_at_their_stops_are_counted():
    env = ArmEnv(STILL, control={"adaptation": 0.0}, gravity="microgravity", coupling="none")
    env.reset(seed=0)
    for period in range(40):
        # The wrist is bent to the end of its range for a while.
        physics(env, "qfrc_applied")[JOINTS.index("wrist_flexion")] = 40.0 * (5 <= period < 25)
        info = env.step(np.zeros(0))[-1]
    assert 0.1 < info["cost_terms"]["range_stops"] < 0.25


def test_chatter_shows_and_costs():
    env, periods, found = ArmEnv(gravity="microgravity"), 300, []
    chatter = 2.0 / addresses(env).peak_torque * (-1.0) ** np.arange(periods)[:, None]  # 50 Hz
    for actions in (0 * chatter, chatter):
        env.reset(seed=0)
        rewards = [env.step(action)[1] for action in actions]
        found.append((np.sum(rewards), env.episodes.info(0)["cost_terms"]["chatter"]))
    (smooth, none), (noisy, much) = found
    expected = (periods - 1) * np.sum((4.0 / addresses(env).peak_torque) ** 2)
    assert (none, much) == (0, pytest.approx(expected))
    assert noisy < 0.95 * smooth


class Down(NoAssist):
    def torque(self, seen):
        return super().torque(seen) - self.peak


def test_who_ends_early_scores_below_who_goes_on():
    weak = Person.percentile("female", 5)
    arms = ArmVectorEnv(4, wearer=weak, payload={"mass": 5.0}, threads=1)
    policies = make_policy("none", arms), Down(Plant.of(arms.episodes))
    none, down = (score("it", rollout(arms, policy, range(4))) for policy in policies)
    assert down.failures == 4
    assert (np.array(down.reward) < np.array(none.reward)).all()
    assert max(down.reward) < 0.1


def test_success():
    rows = [
        ({}, True),
        ({"worst_joint": 0.031}, False),
        ({"effort": 0.31}, False),
        ({"cuff_force": 1.01}, False),
        ({"heat": 1.01}, False),
        ({"chatter": 1e6, "wrong_way_work": 1e6, "range_stops": 9.0}, True),
    ]
    for changed, well in rows:
        terms = {name: 0.5 for name in COSTS} | {"effort": 0.16, "worst_joint": 0.029} | changed
        terms["tracking"] = terms["worst_joint"] / 2  # of four joints only one moves
        costs = np.array([*(terms[name] for name in COSTS[:JOINT]), *np.zeros(WIDTH - JOINT)])
        costs[[JOINT + 2, STRAIN]] = 100 * terms["worst_joint"] ** 2, 100 * terms["effort"] ** 2
        assert cost_terms(costs, 100) == pytest.approx(terms)
        assert is_success(costs, 100, ARM_TRACKING, ended=False) is well, changed
        assert not is_success(costs, 100, ARM_TRACKING, ended=True)


def shipped(terms, measured):
    return 1 / (1 + terms["effort"] + terms["tracking"] + terms["smoothness"])


def steps(env, count, motors):
    env.reset(seed=3)
    return np.array([env.step(np.full(motors, 0.3))[1] for _ in range(count)])


def test_terms_for_an_own_reward_are_those_of_the_shipped_reward():
    one = steps(ArmVectorEnv(3, "ArmTracking"), 20, (3, 2))
    other = steps(ArmVectorEnv(3, "ArmTracking", reward=shipped), 20, (3, 2))
    np.testing.assert_allclose(other, one, rtol=1e-12)


def test_an_own_reward_in_a_single_arm_is_that_of_a_row():
    named = {"reward": "own_rewards:gentle"}
    one = steps(gymnasium.make("ActiveSuit/ArmTracking-v0", **named), 10, 2)
    rows = steps(ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle), 10, (2, 2))
    np.testing.assert_array_equal(rows[:, 0], one)


def test_measurements_for_an_own_reward_have_their_shapes():
    seen = {}

    def looking(terms, measured):
        seen.update({name: values.shape for name, values in measured.items()})
        return np.zeros(2)

    steps(ArmVectorEnv(2, "ArmTracking", coupling="cuffs", reward=looking), 1, (2, 2))
    assert seen["human_torque"] == (2, 4) and seen["assist_torque"] == (2, 2)
    assert seen["cuff_force"] == (2, 9) and seen["lost"] == (2,)
    assert "encoder_angle" not in seen  # what sensors read is no measurement of the arm


def test_rows_that_begin_anew_have_no_reward():
    env = ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle, max_episode_steps=2)
    rewards = steps(env, 3, (2, 2))
    assert (rewards[1] > 0).all() and (rewards[2] == 0).all()


def test_an_own_reward_of_the_period_in_which_the_arm_is_lost():
    env = ArmVectorEnv(2, "ArmTracking", reward=own_rewards.gentle, autoreset_mode="SameStep")
    env.reset(seed=0)
    env.step(np.zeros((2, 2)))
    env.episodes.simulation.batch.bind("qpos")[1, 1] = 2.5
    _, reward, terminated, _, _ = env.step(np.zeros((2, 2)))
    assert terminated.tolist() == [False, True]
    assert reward[1] == -1.0 < reward[0]


def test_own_rewards_that_cannot_be():
    rows = [
        ("own_rewards:nan", "is nan in row 0 of 1"),
        ("own_rewards:scalar", r"has the shape \(\): return \(1,\)"),
        ("own_rewards:failing", "fails .KeyError"),
        ("no_module:reward", "cannot be imported .ModuleNotFoundError"),
        (5, "the reward is 5: give a function"),
    ]
    assert_refused(lambda given: steps(ArmEnv("ArmTracking", reward=given), 1, 2), rows)
    message = "scores need the shipped reward"
    given = {"motions": 8, "reward": shipped}
    assert_refused(lambda: evaluate("ActiveSuit/ArmTracking-v0", ["none"], **given), [(message,)])
