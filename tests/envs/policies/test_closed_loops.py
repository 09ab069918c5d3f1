"""Policies in closed loop, their evaluation, and policies that a network corrects."""

import gymnasium
import numpy as np
import pytest
from activesuit.assets import JOINTS, load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.belief import BelievedWeight
from activesuit.envs.belief.arm import without_exo
from activesuit.envs.evaluation import evaluate, rollout, score
from activesuit.envs.making import make_arms
from activesuit.envs.model import ASSISTED, bare_arm, compose
from activesuit.envs.model.cuffs import FORCE_LIMITS
from activesuit.envs.person import effort_metrics
from activesuit.envs.plant import Plant
from activesuit.envs.policies import POLICIES, make_policy, needed_options
from activesuit.envs.policies.network import Residual
from activesuit.envs.policies.registry import base_of, residual_of
from activesuit.envs.policies.residual import Cohorts, ResidualPolicy, corrected
from helpers import assert_refused, shorten_tasks
from shown import asked

INERTIAL = "inertial:share=0.5,bandwidth=20"
NAIVE = {"references": False, "adapted": False}


def test_gravity_compensation_carries_the_weight(monkeypatch):
    shorten_tasks(monkeypatch, 2.0)
    policies = ("none", "gravity", "transparent")
    env = "ActiveSuit/ArmTracking-v0"
    found = evaluate(env, policies, motions=2, **NAIVE).scores
    off, gravity, transparent = (found[name].human_rms for name in policies)
    for joint in ASSISTED:
        assert gravity[joint] < 0.6 * off[joint]
        assert gravity[joint] < transparent[joint] < 0.95 * off[joint]
    weightless = evaluate(env, ("gravity",), motions=1, gravity="microgravity", **NAIVE)
    assert weightless.scores["gravity"].assist_energy == pytest.approx((0,), abs=1e-9)


def test_policies_are_sums_of_weight_suit_and_friction():
    env, pose = ArmEnv(gravity="mars", payload={"mass": 1.0}), [0.0, 0.8, 1.1, 0.0]
    still, turning = np.zeros(4), np.array([0.0, 1.0, -1.0, 0.0])
    motors = [env.config.exo.motors[joint] for joint in ASSISTED]
    for rate in (still, turning):
        names = ("none", "transparent", "gravity", "feedforward", "complement", "compensation")
        parts = {name: asked(make_policy(name, env), env, angle=pose, rate=rate) for name in names}
        turned = rate[[1, 2]]
        coulomb = np.array([motor.coulomb for motor in motors])
        viscous = np.array([motor.viscous for motor in motors])
        friction = 0.8 * (coulomb * np.tanh(turned / 0.1) + viscous * turned)
        assert not parts["none"].any()
        whole = parts["gravity"] + parts["feedforward"] + friction
        np.testing.assert_allclose(parts["compensation"], whole, atol=1e-6)
        # The complement leaves the bare arm's weight to its wearer.
        bare = BelievedWeight(bare_arm(env.config))
        own = bare(np.array([pose]) + 0.02 * rate)[0]
        np.testing.assert_allclose(parts["complement"], whole - own, atol=1e-6)
        without = BelievedWeight(compose(without_exo(env.config), drawn=False))
        rest = parts["gravity"] - without(np.array([pose]) + 0.02 * rate)[0] + friction
        np.testing.assert_allclose(parts["transparent"], rest, atol=1e-6)


def surroundings(name):
    needed = needed_options(name)
    return {**needed, "coupling": "cuffs" if "cuffs" in needed["sensors"] else "rigid"}


@pytest.mark.parametrize("name", POLICIES)
def test_rows_are_acted_on_as_single_arms_are_and_again_after_a_reset(name):
    arm = ArmEnv(**surroundings(name))
    many, one = arm.rows(2, max_episode_steps=100), arm.rows(1, max_episode_steps=100)
    together = rollout(many, make_policy(name, many), [4, 5])
    policy = make_policy(name, one)
    for seed, trace in zip((4, 5, 4), (*together, together[0]), strict=True):
        (alone,) = rollout(one, policy, [seed])
        assert alone.time[-1] == pytest.approx(1.0)
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


def test_policies_that_do_not_fit_the_arms():
    needs = "'oracle' needs the sensors encoders, privileged, and"
    assert_refused(make_policy, [("oracle", ArmEnv(), needs)])
    policy = make_policy("feedforward", ArmEnv())
    policy.act(np.zeros((2, 12), np.float32))
    others = "the policy sees 3 arms, and 2 since its reset: reset it"
    assert_refused(policy.act, [(np.zeros((3, 12), np.float32), others)])


def test_scores_are_what_they_say():
    arms = make_arms("ActiveSuit/ArmTracking-v0", 1, coupling="cuffs", max_episode_steps=300)
    (trace,) = rollout(arms, make_policy("none", arms), [0])
    result = score("none", [trace, trace])
    error = trace.angle - trace.target_angle
    wanted = effort_metrics(trace.human_torque, trace.rate, 0.01)
    for column, joint in enumerate(JOINTS):
        human = trace.human_torque[:, column]
        assert result.human_rms[joint] == pytest.approx(np.sqrt(np.mean(human**2)))
        assert result.torque[joint] == (result.human_rms[joint],) * 2
        assert result.peak[joint] == pytest.approx(np.abs(human).max())
        assert result.load[joint]["impulse"] == pytest.approx(wanted.impulse[column])
        assert result.load[joint]["work_cost"] == pytest.approx(wanted.work_cost[column])
        rmse = np.sqrt(np.mean(error[:, column] ** 2))
        assert result.tracking_rmse[joint] == pytest.approx(rmse)
    assert result.effort == (pytest.approx(np.sqrt(np.mean(trace.effort**2))),) * 2
    assert result.tracking == (pytest.approx(np.sqrt(np.mean(error**2))),) * 2
    assert result.tracking[0] == pytest.approx(result.costs["tracking"][0])
    assert result.reward == (pytest.approx(trace.rewards.mean()),) * 2
    assert result.unadapted_effort == ()
    force = np.linalg.norm(trace.cuff_force, axis=2).max(axis=0)
    assert result.cuff_peak == pytest.approx(dict(zip(FORCE_LIMITS, force, strict=True)))
    worst = max(force / list(FORCE_LIMITS.values()))
    assert result.costs["cuff_force"][0] == pytest.approx(worst)


def test_feedforward_leaves_alone_what_it_does_not_know(tmp_path):
    suit = load_suit("mock-suit")
    elbow = {"elbow_flexion": suit.joints["elbow_flexion"]}
    suit.model_copy(update={"joints": elbow}).save(tmp_path / "half.json")
    arms = ArmEnv("ElbowFlexion").rows(1, max_episode_steps=100)
    half = make_policy({"name": "feedforward", "suit": tmp_path / "half.json"}, arms)
    (trace,) = rollout(arms, half, [0])
    greatest = np.abs(trace.assist_torque).max(axis=0)
    assert greatest[0] < 1e-9 and greatest[1] > 0.1


def test_rows_refuse_what_a_class_of_your_own_does_anew():
    class Slow(ArmEnv):
        duration = 0.5

        def step(self, action):
            return super().step(0.5 * action)

    gymnasium.register("Mine/Slow-v0", entry_point=Slow)
    try:
        message = "'Mine/Slow-v0' overrides duration, step of ArmEnv, which the vector"
        assert_refused(make_arms, [("Mine/Slow-v0", 2, message)])
    finally:
        del gymnasium.registry["Mine/Slow-v0"]


SCENE = {"gravity": "microgravity", "sensors": ("encoders", "interaction")}


class Constant:
    def __init__(self, action):
        self.action, self.seen, self.resets = np.array(action), [], 0

    def reset(self):
        self.resets += 1

    def act(self, observation):
        self.seen.append(observation)
        return np.broadcast_to(self.action, (*observation.shape[:-1], 2))


def test_the_correction_observes_what_it_corrects():
    given = np.array([[0.5, -0.9]])  # a correction is scaled, and the sum clipped
    np.testing.assert_allclose(corrected(given, np.array([[1.0, -3.0]]), 0.3), [[0.8, -1.0]])
    base, correction = Constant([0.2, 0.4]), Constant([1.0, 0.0])
    policy = ResidualPolicy(base, correction, 0.5)
    policy.reset()
    action = policy.act(np.zeros((3, 5), np.float32))
    np.testing.assert_allclose(action, np.tile([0.7, 0.4], (3, 1)))
    np.testing.assert_allclose(correction.seen[0][:, 5:], np.tile([0.2, 0.4], (3, 1)), rtol=1e-6)
    assert (base.resets, correction.resets) == (1, 1)


@pytest.mark.parametrize("name", ["compensation", "adaptive"])
def test_rows_that_begin_anew_have_a_memory_of_their_own(name):
    arms = make_arms("ActiveSuit/ArmTracking-v0", 3, autoreset_mode="Disabled", **SCENE)
    one = make_arms("ActiveSuit/ArmTracking-v0", 1, **SCENE)
    plant = Plant.of(arms.episodes)
    cohorts = Cohorts(lambda: make_policy(name, plant), 3, 2)
    alone = make_policy(name, plant)
    observation, _ = arms.reset(seed=[0, 1, 2])
    action = cohorts.begin(np.arange(3), observation)
    for period in range(30):
        if period in (7, 12):  # row 1 begins anew, at the second time as the single arm does
            mask = np.array([False, True, False])
            seeds = [None, 40 if period == 12 else 30, None]
            observation, _ = arms.reset(seed=seeds, options={"reset_mask": mask})
            action[1] = cohorts.begin(np.array([1]), observation)[0]
        if period == 12:
            single, _ = one.reset(seed=40)
            alone.reset()
            expected = alone.act(single)
        if period >= 12:
            np.testing.assert_allclose(action[1], expected[0], atol=1e-12)
            single, *_ = one.step(expected)
            expected = alone.act(single)
        observation, *_ = arms.step(action)
        action = cohorts.act(observation)


def test_a_suit_file_is_part_of_the_plain_data(tmp_path):
    load_suit("emu-like").save(tmp_path / "mine.json")
    residual = residual_of(f"compensation:suit={tmp_path / 'mine.json'}", 0.3)
    (tmp_path / "mine.json").unlink()
    again = Residual.model_validate_json(residual.model_dump_json())
    arms = make_arms("ActiveSuit/ArmTracking-v0", 2, **SCENE)
    make_policy(base_of(again), arms)


def test_policies_that_no_network_can_correct_and_cards_with_code_or_files():
    rows = [
        ("compensator", "unknown policy 'compensator'"),
        ("activesuit.envs.policies:NoAssist", "unknown policy that a network corrects"),
        ("compensation:power=2", "unknown option of policy 'compensation'"),
    ]
    assert_refused(lambda given: residual_of(given, 0.3), rows)
    rows = [
        ({"name": "os:system"}, "unknown policy that a network corrects 'os:system'"),
        ({"name": "compensation", "suit": "/tmp/x.json"}, "a card names shipped suits"),
    ]
    assert_refused(lambda policy: base_of(Residual(policy=policy, scale=0.3)), rows)


def test_the_inertial_policy_carries_its_share_of_the_inertia():
    """In slow sines the torque beside compensation is the share of M q'', some 16 ms late."""
    plant = Plant.of(ArmEnv(gravity="microgravity").episodes)
    base, more = map(lambda name: make_policy(name, plant), ("compensation", INERTIAL))
    w, rest, size = np.pi, np.array([[0.0, 0.8, 1.1, 0.0]]), np.array([[0.0, 0.1, 0.15, 0.0]])
    carried, given, wanted = plant.believed().carried_inertia(), [], []
    for i in range(600):
        time = plant.dt * i
        seen = {
            "angle": rest + size * (1 - np.cos(w * time)),
            "rate": size * w * np.sin(w * time),
        }
        if i == 0:
            base.begin(seen)
            more.begin(seen)
        given.append((more.torque(seen) - base.torque(seen))[0])
        bend = size[0] * w**2 * np.cos(w * (time - 0.016))
        wanted.append(0.5 * (carried(seen["angle"])[0] @ bend)[[1, 2]])
    error = np.sqrt(np.mean(np.square(np.array(given) - wanted)[50:], axis=0))
    assert (error < 0.2 * np.sqrt(np.mean(np.square(wanted), axis=0))).all()
