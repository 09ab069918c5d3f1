"""Controllers that plan, learn, adapt or observe, and the guard, by textbook properties."""

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import TASKS, ArmEnv
from activesuit.envs.evaluation import evaluate, rollout
from activesuit.envs.evaluation.scores import root_mean_square as rms
from activesuit.envs.plant import Plant
from activesuit.envs.policies import NoAssist, make_policy, needed_options
from activesuit.envs.policies.adaptive import SCALES, learned
from activesuit.envs.policies.guard import RESERVE, lessen, updated_ledger
from activesuit.envs.policies.observers import CorrectedCompensation, MomentumObserver
from activesuit.envs.simulation.state import PREVIEW
from activesuit.envs.vector_env import ArmVectorEnv
from shown import asked, made


def test_impedance_is_a_pull_of_springs_and_dampers():
    policy, env = made("impedance", gravity="microgravity", suit="none")
    pull = asked(policy, env, target=[0.1, -0.05] * 3)
    np.testing.assert_allclose(pull, policy.stiffness * [0.1, -0.05], rtol=1e-5)
    # Preview of a motion at 0.2 rad/s that is at 0 at the nearest time.
    moving = np.outer(np.array(PREVIEW) - PREVIEW[0], [0.2, 0.2]).ravel()
    pull = asked(policy, env, target=moving)
    np.testing.assert_allclose(pull, 0.2 * policy.damping, rtol=1e-4)


def test_impedance_gives_the_believed_arm_its_bandwidth():
    policy, env = made("impedance:bandwidth=1.5,damping_ratio=0.7")
    inertia = Plant.of(env.episodes).believed().inertia().nominal()
    pole = 2 * np.pi * 1.5
    np.testing.assert_allclose(policy.stiffness / inertia, pole**2)
    np.testing.assert_allclose(policy.damping / inertia, 2 * 0.7 * pole)


def effort(traces):
    return rms([trace.effort for trace in traces])


def test_predictive_sampling_is_no_worse_than_compensation():
    arms = ArmEnv("ElbowFlexion", gravity="microgravity").rows(2, max_episode_steps=300)
    plain = rollout(arms, make_policy("compensation", arms), [1, 2])
    policy = make_policy("predictive:samples=8", arms)
    first, again = rollout(arms, policy, [1, 2]), rollout(arms, policy, [1, 2])
    assert effort(first) < 1.1 * effort(plain)
    assert effort(first) != effort(plain)
    for one, other in zip(first, again, strict=True):  # its samples have a seed
        np.testing.assert_array_equal(one.human_torque, other.human_torque)


def test_predictive_sampling_plans_on_what_it_believes():
    env = ArmEnv("ElbowFlexion", suit="emu-like", gravity="microgravity")
    arms = env.rows(1, max_episode_steps=200)
    right = rollout(arms, make_policy("predictive:samples=4", arms), [1])
    wrong = rollout(arms, make_policy("predictive:samples=4,suit=mock-suit", arms), [1])
    assert effort(right) < 0.8 * effort(wrong)


DT = 0.01


@pytest.mark.parametrize("gain", [0.3, 0.8])
def test_iterative_learning_contracts(gain):
    """A person who gives what the motors leave: the error shrinks by 1 - gain a cycle.

    It ends at what the filter takes from a cycle, a few hundredths of it.
    """
    phase = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    wanted = np.stack([3 * np.sin(phase), 2 + np.cos(phase)], axis=-1)[:, None]
    known, errors = np.zeros_like(wanted), []
    for _ in range(8):
        missing = wanted - known
        errors.append(np.abs(missing).max())
        known = learned(known, missing, gain, ahead=0, dt=DT)
    # What the filter takes from a cycle stays missing, the more the smaller the gain.
    left = [errors[0] * (1 - gain) ** cycle for cycle in range(8)]
    np.testing.assert_allclose(errors, left, atol=0.02 * errors[0])
    for _ in range(20):
        known = learned(known, wanted - known, gain, ahead=0, dt=DT)
    assert np.abs(wanted - known).max() < 0.04 * np.abs(wanted).max()


def test_iterative_learning_comes_earlier_by_the_lag_of_the_motors():
    missing = np.zeros((100, 1, 2))
    missing[50] = 1.0
    found = learned(np.zeros_like(missing), missing, 1.0, ahead=3, dt=DT)
    assert found[:, 0, 0].argmax() == 47


def test_iterative_learning_helps_from_cycle_to_cycle():
    given = {}
    for name in ("compensation", "iterative"):
        env = ArmEnv("Ratchet", **needed_options(name))
        policy = make_policy(name, env)
        observation, info = env.reset(seed=0)
        policy.reset()
        torques = []
        for _ in range(800):
            observation, *_, info = env.step(policy.act(observation))
            torques.append(info["human_torque"][2])
        given[name] = rms(torques[600:])
    assert given["iterative"] < 0.8 * given["compensation"]


def test_iterative_learning_without_a_cycle_is_compensation():
    env = ArmEnv(**needed_options("iterative"))
    observation, _ = env.reset(seed=0)
    policies = [make_policy(name, env) for name in ("compensation", "iterative")]
    for _ in range(20):
        first, second = (policy.act(observation) for policy in policies)
        np.testing.assert_array_equal(first, second)
        observation, *_ = env.step(first)


def test_springs_tell_how_the_arm_is_turned():
    policy, _ = made("corrected", coupling="cuffs", suit="none")
    rng = np.random.default_rng(5)
    angle, turn = rng.uniform(0.2, 1.2, (6, 4)), rng.uniform(-0.1, 0.1, (6, 4))
    spring = policy._stiffness[:, None] * policy._levers(angle)
    seen = {"angle": angle, "cuff_force": -np.einsum("nfj,nj->nf", spring, turn)}
    policy._elastic.begin(seen["cuff_force"])
    np.testing.assert_allclose(policy.turn(seen), turn, atol=2e-3)
    seen["cuff_force"] *= 0  # the dampers tell of it at once, the springs later
    assert 0.5 < np.abs(policy.turn(seen)).sum() / np.abs(turn).sum() < 1


def test_corrected_angles_are_those_of_the_arm():
    angles = []

    class Watched(CorrectedCompensation):
        def turn(self, seen):
            found = super().turn(seen)
            angles.append([seen["angle"], seen["angle"] + found])
            return found

    needed = needed_options("corrected")
    env = ArmEnv(coupling="cuffs", suit="emu-like", gravity="microgravity", **needed)
    arms = env.rows(2)
    policy = Watched(Plant.of(arms.episodes))
    true = np.array([trace.angle for trace in rollout(arms, policy, [3, 4])]).swapaxes(0, 1)
    # The first one begins the memory; what is seen in a period is of the end of the one before.
    seen = np.array(angles)[2:].swapaxes(0, 1)
    encoders, corrected = np.sqrt(np.mean((seen - true[:-1]) ** 2, axis=(1, 2)))[:, 1:3]
    assert (encoders > 0.04).all() and (corrected < encoders / 4).all()


def test_with_the_guard_no_cycle_gains_energy():
    """3,000 random policies in random cycles, against a belief that stores and dissipates."""
    rng, n, periods, cycles = np.random.default_rng(0), 3_000, 100, 6
    phase = 2 * np.pi * np.arange(periods) / periods
    size, shift = rng.uniform(0.2, 1, (n, 2)), rng.uniform(0, 2 * np.pi, (n, 2))
    stiffness, friction = rng.uniform(0, 10, (n, 2)), rng.uniform(0, 5, (n, 2))
    push = rng.normal(0, 20, (n, 2))
    ledger, gained = np.full(n, RESERVE), []
    for _ in range(cycles):
        given, lost = np.zeros(n), np.zeros(n)
        for now in phase:
            angle = size * np.sin(now + shift)
            rate = size * 2 * np.pi * np.cos(now + shift)
            needed = stiffness * angle + friction * np.sign(rate)
            wanted = push * rng.standard_normal((n, 2)) + push * np.sign(rate)
            torque, _ = lessen(wanted, needed, rate, ledger, DT)
            ledger = updated_ledger(ledger, needed, torque, rate, DT)
            given += (torque * rate).sum(axis=1) * DT
            lost += (friction * np.abs(rate)).sum(axis=1) * DT
        gained.append(given - lost)
    stored = (stiffness * size**2 / 2).sum(axis=1)
    assert (np.sum(gained, axis=0) <= RESERVE + stored + 1e-6).all()


def test_the_guard_leaves_the_right_compensation_alone():
    arms = ArmEnv("ArmTracking").rows(2, max_episode_steps=400)
    bare, guarded = make_policy("compensation", arms), make_policy("compensation:guard=true", arms)
    without, with_it = (rollout(arms, policy, [3, 4]) for policy in (bare, guarded))
    for one, other in zip(without, with_it, strict=True):
        np.testing.assert_array_equal(one.human_torque, other.human_torque)
    assert guarded.acted.tolist() == [0, 0]


class Drive(NoAssist):
    def torque(self, seen):
        return 2.0 * self.peak * seen["rate"][:, [1, 2]]


def test_the_guard_stops_a_policy_that_drives(monkeypatch):
    monkeypatch.setitem(sys.modules, "drives", SimpleNamespace(Drive=Drive))
    arms = ArmEnv("ElbowFlexion", gravity="microgravity").rows(2, max_episode_steps=400)
    wild = rollout(arms, make_policy("drives:Drive", arms), [1, 2])
    policy = make_policy("drives:Drive:guard=true", arms)
    tame = rollout(arms, policy, [1, 2])
    assert policy.acted.min() > 20

    def work(traces):
        return sum(np.sum(t.assist_torque * t.rate[:, [1, 2]]) * DT for t in traces)

    assert work(tame) < 0.5 * work(wild)


@pytest.mark.parametrize("factor", [0.7, pytest.param(1.4, marks=pytest.mark.slow)])
def test_it_recovers_a_scaled_suit(factor):
    """Within 10 % in 30 s of motion, by what it says the suit needs along that motion."""
    suit = load_suit("emu-like")
    joints = {name: entry.scaled(torque=factor) for name, entry in suit.joints.items()}
    task = replace(TASKS["MinorLoops"], duration=30.0)
    options = {"suit": suit.model_copy(update={"joints": joints}), "gravity": "microgravity"}
    arms = ArmEnv(task, **options, **needed_options("adaptive")).rows(2, max_episode_steps=3000)
    policy = make_policy("adaptive:suit=emu-like", arms)
    rollout(arms, policy, [1, 2])
    scale = policy.estimate[..., 0]
    np.testing.assert_allclose(scale, factor, rtol=0.1)


def test_the_right_belief_stays():
    options = {"gravity": "microgravity", **needed_options("adaptive")}
    arms = ArmEnv("ElbowFlexion", **options).rows(2, max_episode_steps=1000)
    policy = make_policy("adaptive", arms)
    rollout(arms, policy, [1, 2])
    np.testing.assert_allclose(policy.estimate[:, 1, 0], 1.0, atol=0.15)


def test_no_data_leave_the_certified_set():
    arms = ArmEnv(**needed_options("adaptive")).rows(3)
    policy = make_policy("adaptive", arms)
    still = {"motor_torque": np.zeros((3, 2)), "interaction_torque": np.zeros((3, 4))}
    policy.begin({"angle": np.zeros((3, 4)), "rate": np.zeros((3, 4)), **still})
    rng = np.random.default_rng(0)
    entry = load_suit("mock-suit").joints["elbow_flexion"]
    for i in range(2000):
        terms = rng.standard_cauchy((3, 2, 4)) * 10.0 ** rng.integers(-3, 3)
        measured = rng.choice([np.nan, np.inf, 0.0, 1.0], (3, 2), p=[0.02, 0.02, 0.06, 0.9])
        policy.learn(terms, measured * rng.standard_cauchy((3, 2)) * 100, rng.random((3, 2)) < 0.9)
        assert np.isfinite(policy.estimate).all()
        scale = policy.estimate[..., 0]
        assert scale.min() >= SCALES[0] and scale.max() <= SCALES[1]
        if i % 500 == 0:
            model = entry.model.scaled(torque=float(scale[0, 1]))
            assert model.certificate(entry.range).certified


@pytest.mark.parametrize("bandwidth", [2.0, 30.0])
def test_the_residual_of_a_step_is_exponential(bandwidth):
    observer, unknown = MomentumObserver(bandwidth, 0.01), np.array([[3.0, -1.0]])
    observer.begin(np.zeros((1, 2)))
    for period in range(1, 100):
        momentum = (unknown + 0.5) * 0.01 * period
        residual = observer.step(momentum, np.full((1, 2), 0.5))
        grown = 1 - math.exp(-bandwidth * 0.01 * period)
        np.testing.assert_allclose(residual, grown * unknown, rtol=1e-9)


def test_the_momentum_observer_finds_a_torque_on_a_moving_arm():
    # The believed arm swings from rest under gravity, with an unknown constant torque.
    arm, unknown = Plant.of(ArmEnv(suit="none").episodes).believed(), np.array([4.0, -1.5])
    inertia, weight, model = arm.inertia(), arm.whole_weight(), arm.model()
    model.dof_frictionloss[:] = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    data = mujoco.MjData(model)
    data.qpos[:], data.qfrc_applied[1:3] = [0.1, 0.9, 1.2, 0.1], unknown
    observer = MomentumObserver(10.0, 0.01)
    observer.begin(inertia.momentum(data.qpos[None], data.qvel[None])[0])
    for period in range(1, 61):
        known = np.zeros((1, 2))
        for _ in range(10):
            mujoco.mj_forward(model, data)
            other = (data.qfrc_passive + data.qfrc_constraint)[None, 1:3]
            gyration = inertia.momentum(data.qpos[None], data.qvel[None])[1]
            known += (gyration - weight(data.qpos[None]) + other) / 10
            data.qvel[:] += 0.001 * data.qacc
            data.qpos[:] += 0.001 * data.qvel
        momentum = inertia.momentum(data.qpos[None], data.qvel[None])[0]
        grown = 1 - math.exp(-0.1 * period)
        found = observer.step(momentum, known)[0]
        np.testing.assert_allclose(found, grown * unknown, atol=0.03 * np.abs(unknown).max())
    assert np.abs(data.qvel).max() > 1  # it has moved fast meanwhile


def test_the_momentum_observer_needs_no_model_of_the_suit():
    options = {"motions": 1, "adapted": False, "references": False}
    options |= {"gravity": "microgravity", "suit": "emu-like"}
    policies = ("none", "observer", "compensation:suit=mock-suit")
    scores = evaluate("ActiveSuit/ElbowFlexion-v0", policies, **options).scores
    off, observer, compensation = (scores[name].torque["elbow_flexion"][0] for name in policies)
    assert observer < 0.3 * off and observer < 0.5 * compensation


def test_a_disturbance_is_cancelled_through_the_filter():
    bandwidth = 5.0
    # At rest, 2 and -1 N·m of the person without any motion: something withstands them.
    name = f"disturbance-observer:bandwidth={bandwidth}"
    policy, env = made(name, gravity="microgravity", suit="none")
    for period in range(1, 60):
        torque = asked(policy, env, interaction_torque=[0, 2, -1, 0])
        phase = math.tau * bandwidth * 0.01 * period
        whole = (1 - (1 + phase) * math.exp(-phase)) * np.array([2, -1])
        np.testing.assert_allclose(torque, whole, rtol=1e-5)


def test_a_gain_multiplies_the_believed_suit_alone():
    arms = ArmVectorEnv(2, gravity="earth")
    names = ("compensation", "compensation:gain=2.5", "feedforward")
    policies = [make_policy(name, arms) for name in names]
    observation, _ = arms.reset(seed=[0, 1])
    for policy in policies:
        policy.reset()
    for _ in range(120):
        plain, more, suit = (policy.act(observation) for policy in policies)
        np.testing.assert_allclose(more, np.clip(plain + 1.5 * suit, -1, 1), atol=1e-9)
        observation, *_ = arms.step(plain)
    assert np.abs(suit).max() > 0.02


def test_what_the_believed_arm_explains_is_no_disturbance():
    policy, env = made("disturbance-observer", gravity="earth")
    compensation = make_policy("compensation", env)
    peak = env.episodes.simulation.addresses.peak_torque
    angle = [0, 0.6, 1.0, 0]
    needed = asked(compensation, env, angle=angle)
    bare = needed - asked(make_policy("complement", env), env, angle=angle)
    for _ in range(50):  # motors carry all but the bare arm, which the person holds
        torque = asked(policy, env, angle=angle, motor_torque=(needed - bare) / peak)
    np.testing.assert_allclose(torque, needed, atol=1e-4)
