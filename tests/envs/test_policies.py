"""Policies in closed loop, and their evaluation."""

import gymnasium
import numpy as np
import pytest
from activesuit.assets import CURVES, Suit, curves_path, load_suit, save_suit
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate, score
from activesuit.envs.making import make_arms
from activesuit.envs.model import ASSISTED
from activesuit.envs.policies import POLICIES, NoAssist, make_policy, needed_options
from activesuit.envs.evaluation import rollout
from activesuit.errors import InputError
from activesuit.identification import identify, load_curves

MOVING = {"ShoulderFlexion": "shoulder_flexion", "ElbowFlexion": "elbow_flexion"}


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """A suit file with certified fits of the shipped curves: what a user's controller believes."""
    fits = {
        joint: identify(load_curves(curves_path(name)), seed=1) for name, joint in CURVES.items()
    }
    path = tmp_path_factory.mktemp("suit") / "identified.json"
    Suit.from_fits(fits).save(path)
    return path


@pytest.mark.parametrize("gravity", ["earth", "microgravity"])
@pytest.mark.parametrize("task", MOVING)
def test_feedforward_reaches_60_percent_of_the_oracle(task, gravity, identified):
    scores = evaluate(
        f"ActiveSuit/{task}-v0",
        ("none", "feedforward", "oracle"),
        episodes=3,
        gravity=gravity,
        believed_suit=str(identified),
    )
    none, feedforward, oracle = scores
    joint = MOVING[task]
    assert none.reduction[joint] == 0
    assert oracle.reduction[joint] > 0.05
    assert feedforward.reduction[joint] >= 0.6 * oracle.reduction[joint]
    assert all(s.failures == 0 for s in scores)


def test_gravity_compensation_carries_the_weight():
    _, gravity = evaluate("ActiveSuit/ArmTracking-v0", ("none", "gravity"), episodes=2)
    for joint in ASSISTED:
        assert gravity.reduction[joint] > 0.6
    options = {"episodes": 1, "gravity": "microgravity"}
    (weightless,) = evaluate("ActiveSuit/ArmTracking-v0", ("gravity",), **options)
    assert weightless.assist_energy == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", POLICIES)
def test_policies_repeat_after_a_reset(name):
    arms = ArmEnv(**needed_options(name)).rows(2, max_episode_steps=200)
    policy = make_policy(name, arms)
    first, again = (rollout(arms, policy, [4, 5]) for _ in range(2))
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one.human_torque, other.human_torque)
        assert one.time[-1] == pytest.approx(2.0)


@pytest.mark.parametrize("name", POLICIES)
def test_rows_are_acted_on_as_single_arms_are(name):
    arm = ArmEnv(**needed_options(name))
    many, one = arm.rows(3, max_episode_steps=100), arm.rows(1, max_episode_steps=100)
    together = rollout(many, make_policy(name, many), [4, 5, 6])
    policy = make_policy(name, one)
    for seed, trace in zip((4, 5, 6), together, strict=True):
        (alone,) = rollout(one, policy, [seed])
        np.testing.assert_array_equal(trace.human_torque, alone.human_torque)
        np.testing.assert_array_equal(trace.rewards, alone.rewards)
    # The single environment shows the same, and the policy takes one observation as well.
    policy = make_policy(name, arm)
    observation, info = arm.reset(seed=4)
    policy.reset()
    for period in range(100):
        *_, info = step = arm.step(policy.act(observation))
        observation = step[0]
        np.testing.assert_array_equal(info["human_torque"], together[0].human_torque[period])


@pytest.mark.parametrize("name", POLICIES)
def test_a_policy_sees_nothing_but_the_observation(name):
    arm = ArmEnv(**needed_options(name))
    policy = make_policy(name, arm)
    policy.reset()
    observation = np.random.default_rng(0).uniform(0, 0.5, arm.observation_space.shape)
    first = policy.act(observation.astype(np.float32))
    arm.reset(seed=1)  # whatever happens in the environment
    arm.step(np.ones(2))
    policy.reset()
    np.testing.assert_array_equal(policy.act(observation.astype(np.float32)), first)


def test_feedforward_of_other_arms_than_at_its_reset():
    arm = ArmEnv()
    policy = make_policy("feedforward", arm)
    policy.act(np.zeros((2, 12), np.float32))
    with pytest.raises(InputError, match="the policy sees 3 arms, and 2 since its reset: reset it"):
        policy.act(np.zeros((3, 12), np.float32))


def test_a_policy_without_its_sensors():
    with pytest.raises(InputError, match=r"'oracle' needs the sensors encoders, privileged, and"):
        make_policy("oracle", ArmEnv())


def test_a_policy_of_your_own():
    class Push:
        def __init__(self, arms):
            self.action = np.full(arms.action_space.shape, 0.2)

        def reset(self):
            self.steps = 0

        def act(self, observation):
            self.steps += 1
            return self.action

    none, push = evaluate(
        "ActiveSuit/ElbowFlexion-v0",
        {"none": lambda arms: make_policy("none", arms), "push": Push},
        episodes=1,
    )
    assert push.policy == "push"
    assert push.reduction["elbow_flexion"] > none.reduction["elbow_flexion"] == 0


def test_a_wrong_belief_helps_less(tmp_path):
    suit = load_suit("mock-suit")
    content = suit.model_dump()
    for joint in ASSISTED:
        content["joints"][joint]["model"] = suit.joints[joint].model.scaled(torque=0.3)
    save_suit(Suit.model_validate(content), tmp_path / "weak.json")
    options = {"episodes": 1, "gravity": "microgravity"}
    policies = ("none", "feedforward")
    right = evaluate("ActiveSuit/ElbowFlexion-v0", policies, **options)[1]
    wrong = evaluate(
        "ActiveSuit/ElbowFlexion-v0", policies, believed_suit=str(tmp_path / "weak.json"), **options
    )[1]
    assert 0.1 < wrong.reduction["elbow_flexion"] < right.reduction["elbow_flexion"] - 0.2


def test_scores_are_what_they_say():
    arms = make_arms("ActiveSuit/ArmTracking-v0", 1)
    (trace,) = rollout(arms, make_policy("none", arms), [0])
    result = score("none", [trace, trace])
    late = trace.time > 0.5
    for column, joint in ((1, "shoulder_flexion"), (2, "elbow_flexion")):
        human = trace.human_torque[late, column]
        assert result.human_rms[joint] == pytest.approx(np.sqrt(np.mean(human**2)))
        assert result.human_peak[joint] == pytest.approx(np.abs(human).max())
        error = (trace.angle - trace.target_angle)[late, column]
        assert result.tracking_rmse[joint] == pytest.approx(np.sqrt(np.mean(error**2)))
    assert result.mean_return == pytest.approx(trace.rewards.sum())
    assert result.reduction is None


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (("ActiveSuit/Knee-v0", ["none"]), {}, "unknown environment 'ActiveSuit/Knee-v0'"),
        (("CartPole-v1", ["none"]), {}, "'CartPole-v1' is no arm of ActiveSuit"),
        (("ActiveSuit/ElbowFlexion-v0", ["nune"]), {}, "unknown policy 'nune'.*'none'"),
        (("ActiveSuit/ElbowFlexion-v0", ["none"]), {"episodes": 0}, "episodes is 0"),
        (("ActiveSuit/ElbowFlexion-v0", []), {}, "no policy given"),
        (("ActiveSuit/ElbowFlexion-v0", {}), {}, "no policy given"),
        (("ActiveSuit/ElbowFlexion-v0", "none"), {}, r"policies is 'none': give a list"),
        (("ActiveSuit/ElbowFlexion-v0", [NoAssist]), {}, "policies has .*NoAssist.*: give names"),
        (
            ("ActiveSuit/ElbowFlexion-v0", {"mine": NoAssist, "push": 0.2}),
            {},
            r"policy 'push' is 0\.2: give a function from the environment to a policy",
        ),
        (
            ("ActiveSuit/ElbowFlexion-v0", {"mine": NoAssist}),
            {"believed_suit": "mock-suit"},
            "believed_suit is 'mock-suit' and policies are your own",
        ),
    ],
)
def test_bad_input(arguments, options, message):
    with pytest.raises(InputError, match=message):
        evaluate(*arguments, **options)


def test_feedforward_leaves_alone_what_it_does_not_know(tmp_path):
    suit = load_suit("mock-suit")
    elbow = {"elbow_flexion": suit.joints["elbow_flexion"]}
    save_suit(suit.model_copy(update={"joints": elbow}), tmp_path / "half.json")
    arms = ArmEnv("ElbowFlexion").rows(1, max_episode_steps=100)
    half = make_policy("feedforward", arms, believed_suit=str(tmp_path / "half.json"))
    (trace,) = rollout(arms, half, [0])
    greatest = np.abs(trace.assist_torque).max(axis=0)
    assert greatest[0] < 1e-9
    assert greatest[1] > 0.1


def test_folder_that_is_no_training_run(tmp_path):
    env = gymnasium.make("ActiveSuit/ElbowFlexion-v0").unwrapped
    with pytest.raises(InputError, match=r"has no readable config\.json"):
        make_policy(str(tmp_path), env)
    (tmp_path / "config.json").write_text('{"algo": "ppo", "env": "e"}')
    with pytest.raises(InputError, match=r"has no model\.zip"):
        make_policy(str(tmp_path), env)


def test_rows_refuse_what_a_class_of_your_own_does_anew():
    class Slow(ArmEnv):
        duration = 0.5

        def step(self, action):
            return super().step(0.5 * action)

    gymnasium.register("Mine/Slow-v0", entry_point=Slow)
    try:
        with pytest.raises(
            InputError, match="'Mine/Slow-v0' has its own duration, step, which rows"
        ):
            make_arms("Mine/Slow-v0", 2)
    finally:
        del gymnasium.registry["Mine/Slow-v0"]
