"""The wearer's control of the arm: impedance, reflex, correction, noise and learning."""

from collections import deque
from dataclasses import dataclass
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.evaluation.scores import root_mean_square as rms
from activesuit.envs.evaluation.wearers import Wearers, smoothed
from activesuit.envs.person import Person, isometric_strength, strength_limits
from activesuit.envs.person.control import (
    FORGETTING,
    NOISE_SIZE,
    PROVENANCE,
    RATE,
    STIFF,
    VoluntaryControl,
    noise_constants,
)
from activesuit.envs.policies import make_policy
from activesuit.envs.simulation.structs import MuscleNoise
from activesuit.envs.simulation.wearer_control import HARDENED, PERSISTENCE, vary
from activesuit.envs.tasks import ARM_TRACKING, RandomMoves
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.errors import InputError
from arms import addresses, go_on, physics, reported, state
from helpers import assert_refused

DT = 0.01
VALUE = {quantity.name: quantity.value for quantity in PROVENANCE}
STILL = RandomMoves(name="Still", hold={"elbow_flexion": (0.8, 0.9)}, duration=5.0)
BARE = {"coupling": "none", "suit": "none", "gravity": "microgravity"}
ELBOW = JOINTS.index("elbow_flexion")
WEAK = {"sex": "female", "stature": 1.5, "mass": 50.0}


def by_joint(name):
    return np.array([VALUE[f"control.{name}.{joint}"] for joint in JOINTS])


class Twin:
    """A slow, readable model of the wearer in a control period."""

    def __init__(self, settings, person, correction):
        own, usual = isometric_strength(person), isometric_strength(Person())
        self.strength, self.settings = own, settings
        self.stronger = own.sum(axis=0) / usual.sum(axis=0)
        self.held, self.fed, self.step = correction.copy(), np.zeros(4), 0
        self.goals = [correction.copy()] * 3
        self.past = deque([np.zeros(4)] * round(settings.delay / DT))
        self.seen = deque([np.zeros(4)] * round(VALUE["control.correction.delay"] / DT))

    def stiffness(self, muscle):
        base, slope = by_joint("stiffness.base"), by_joint("stiffness.slope")
        contraction = self.settings.contraction * by_joint("contraction")
        own = self.stronger * (base + slope * contraction)
        return self.settings.stiffness * (own + slope * np.abs(muscle))

    def act(self, foreseen, error, slip, target_rate, angle, rate):
        """Returns stiffness, damping and torque of the coming period."""
        settings, limits = self.settings, strength_limits(self.strength, angle, rate)
        muscle = np.clip(foreseen + self.fed + self.held, *limits)
        stiffness = self.stiffness(muscle)
        damping = settings.damping * stiffness
        total = np.clip(muscle + stiffness * error + damping * slip, *limits)
        self.past.append(stiffness * (error + VALUE["control.reflex.lead"] * slip))
        lag = 1 - np.exp(-DT / VALUE["control.reflex.lag"])
        self.fed = self.fed + lag * (settings.reflex * self.past.popleft() - self.fed)
        self.seen.append(error)
        self.correct(self.seen.popleft(), stiffness * (1 + settings.reflex), target_rate, limits)
        return stiffness, damping, total

    def correct(self, seen, elastic, target_rate, limits):
        """Begins a change of the correction every 0.2 s, and follows its course."""
        if self.step % 20 == 0:
            latest, before, oldest = self.goals
            remains = seen - (latest - oldest) / elastic
            wanted = latest + self.settings.correction * elastic * remains
            seen_at_all = np.abs(remains) > 0.012 + 0.17 * np.abs(target_rate)
            self.goals = [np.where(seen_at_all, np.clip(wanted, *limits), latest), latest, before]
        s = (self.step % 20 + 1) / 20
        share = 10 * s**3 - 15 * s**4 + 6 * s**5
        self.held = self.goals[1] + share * (self.goals[0] - self.goals[1])
        self.step += 1


@pytest.mark.parametrize(
    ("settings", "person"),
    [
        ({}, {}),
        ({"stiffness": 2.0, "damping": 0.05, "contraction": 3.0}, {}),
        ({"reflex": 0.9, "delay": 0.02, "correction": 0.7}, WEAK),
    ],
)
def test_the_engine_is_given_what_the_law_says(settings, person):
    settings = VoluntaryControl(adaptation=0.0, **settings)
    env = ArmEnv(control=settings, wearer=person, coupling="none", payload={"mass": 2.0})
    env.reset(seed=2)
    twin, at = Twin(settings, Person(**person), state(env).correction[0]), addresses(env)
    own = env.episodes.simulation.own_torque(np.array([0]))[0]
    biasprm = env.episodes.simulation.batch.expand("actuator_biasprm")[0]
    for i in range(1, 120):
        physics(env, "qfrc_applied")[ELBOW] = -15.0 * (i > 40)
        angle, rate = physics(env, "qpos")[:4].copy(), physics(env, "qvel")[:4].copy()
        error, slip = state(env).angle[0, i] - angle, state(env).rate[0, i] - rate
        intended = state(env).rate[0, i]
        stiffness, damping, total = twin.act(own[i], error, slip, intended, angle, rate)
        env.step(np.zeros(0))
        np.testing.assert_allclose(-biasprm[at.human, 1], stiffness, rtol=1e-9)
        np.testing.assert_allclose(-biasprm[at.human, 2], damping, rtol=1e-9)
        given = physics(env, "ctrl")[at.intention]
        np.testing.assert_allclose(given[0] - angle, error, atol=1e-12)
        asked = stiffness * error + damping * slip + given[2]
        np.testing.assert_allclose(asked, total, rtol=1e-9, atol=1e-9)
    assert np.abs(twin.fed).max() > 0.3


def test_stiffness_at_rest_and_under_load():
    base, slope, _, relaxation, extra = VoluntaryControl().impedance(Person())
    assert 27 <= base[1] <= base[2] <= 28
    np.testing.assert_allclose(relaxation, 0.1)
    np.testing.assert_allclose(extra, by_joint("contraction"))
    np.testing.assert_allclose(slope, [3.2, 3.2, 6.2, 6.2])
    weak = VoluntaryControl().impedance(Person(**WEAK))
    ratio = isometric_strength(Person(**WEAK)).sum(axis=0) / isometric_strength(Person()).sum(0)
    np.testing.assert_allclose(weak[0], ratio * base)
    np.testing.assert_allclose(weak[1], slope)  # the slope does not depend on strength
    tense = VoluntaryControl(contraction=3).impedance(Person())
    np.testing.assert_allclose(tense[0] - base, slope * (tense[4] - extra))
    np.testing.assert_allclose(tense[4], 3 * extra)
    guided = VoluntaryControl(stiff=True).impedance(Person())
    np.testing.assert_array_equal(guided[[0, 2]], STIFF)
    assert not guided[[1, 3, 4]].any()


def test_all_contraction_counts_as_effort_and_tires():
    efforts, tired = [], []
    for contraction in (0.0, 1.0, 3.0):
        env = ArmEnv(STILL, fatigue=True, control={"contraction": contraction}, **BARE)
        env.reset(seed=0)
        info = go_on(env, 50)[-1]
        efforts.append(info["effort"])
        tired.append(info["fatigue"].max())
    usual, three = efforts[1] - efforts[0], efforts[2] - efforts[0]
    assert (usual > 0.0199).all()
    assert (three > 2.9 * usual).all()  # more where torque and strength change their side
    assert tired[2] > 2 * tired[1] > 0.0005 > tired[0]


@pytest.mark.parametrize(
    ("joint", "push", "load"), [("shoulder_flexion", 4.0, 5.0), ("elbow_flexion", 3.0, 0.0)]
)
def test_a_pushed_arm_is_back_within_a_second(joint, push, load):
    """People begin to correct after 100 to 150 ms, and are at the target after 0.5 to 1 s."""
    options = BARE | {"payload": {"mass": load}, "gravity": "earth" if load else "microgravity"}
    env, away = ArmEnv(STILL, control={"adaptation": 0.0}, **options), []
    env.reset(seed=0)
    at = addresses(env).joints[JOINTS.index(joint)]
    for period in range(450):
        physics(env, "qfrc_applied")[at] = push * (period >= 50)
        info = env.step(np.zeros(0))[-1]
        away.append((info["angle"] - info["target_angle"])[JOINTS.index(joint)])
    away = np.abs(away)[50:]
    assert away[:50].max() > 0.012
    assert away[100] < 0.2 * push / 42 + 0.004  # the torque over stiffness and reflex
    assert np.ptp(away[-80:]) < 0.002


def pushed(joint, push, periods, persistent, coupling="rigid", load=0.0):
    """Returns displacement [rad] and the wearer's answer [N·m], both along a push, in 4 s.

    The command of the exoskeleton is frozen. The push lasts for some control periods.
    """
    control, found = {"adaptation": 0.0, "persistent": persistent}, []
    options = {"coupling": coupling, "gravity": "microgravity", "payload": {"mass": load}}
    if coupling == "none":
        options["suit"] = "none"
    task, j = RandomMoves(name="Still", hold=BENT, duration=6.0), JOINTS.index(joint)
    for torque in (0.0, push):
        env = ArmEnv(task, control=control, **options)
        observation, info = env.reset(seed=1)
        command = make_policy("compensation" if coupling == "rigid" else "none", env)
        action, courses = command.act(observation), []
        for period in range(500):
            now = torque * (100 <= period < 100 + periods)
            physics(env, "qfrc_applied")[addresses(env).joints[j]] = now
            info = env.step(action)[-1]
            courses.append((info["angle"][j], -info["human_torque"][j]))
        found.append(np.array(courses)[100:].T)
    return np.sign(push) * (found[1] - found[0])


@pytest.mark.parametrize(
    ("joint", "push", "friction"), [("shoulder_flexion", 4.0, 3.0), ("elbow_flexion", -3.0, 2.0)]
)
def test_a_persistent_wearer_corrects_behind_the_friction_of_gears(joint, push, friction):
    """The usual wearer leaves two thirds after a second; see the page of the model."""
    for periods in (400, 30):
        usual, _ = pushed(joint, push, periods, False)
        away, answer = pushed(joint, push, periods, True)
        if periods == 400:
            assert usual[100] > 0.66 * usual.max()
        assert abs(away[100]) < max(away.max() / 3, 0.012)
        assert answer.max() < 1.25 * (abs(push) + friction)
        assert away[-150:].std() < 0.004


def test_a_persistent_wearer_calms_a_heavy_bare_arm():
    usual, _ = pushed("shoulder_flexion", 4.0, 400, False, "none", 4.0)
    away, _ = pushed("shoulder_flexion", 4.0, 400, True, "none", 4.0)
    assert usual[-150:].std() > 0.04
    assert away[-150:].std() < 0.01


def test_persistence_has_state_only_where_a_wearer_is_persistent():
    for control, rows in (
        ({}, 0),
        ({"persistent": True}, PERSISTENCE),
        ({"persistent": True, "stiff": True}, 0),
    ):
        assert state(ArmEnv(STILL, control=control)).persistence.shape == (1, rows, 4)
    with pytest.raises(InputError, match="persistent is 'no': use True or False"):
        VoluntaryControl(persistent="no")


def test_co_contraction_of_a_persistent_wearer_counts_as_effort():
    env, efforts = ArmEnv(STILL, control={"persistent": True}, **BARE), []
    env.reset(seed=0)
    for hard in (0.0, 5.0):
        state(env).persistence[:, HARDENED] = hard
        efforts.append(env.step(np.zeros(0))[-1]["effort"])
    assert (efforts[1] > efforts[0] + 0.02).all()


def test_noise_and_tremor_have_the_stated_spectra():
    count, periods = 100, 400
    rng, found = np.random.default_rng(2), []
    draws = {"muscle_noise": np.zeros((count, 3, 4)), "muscle_draws": np.empty((count, 1, 3, 4))}
    noise = MuscleNoise(**draws, recursion=noise_constants(DT), noise=0.0, tremor=0.0)
    for _ in range(periods):
        rng.standard_normal(out=noise.muscle_draws)
        for row in range(count):
            vary.py_func(row, 0, noise)
        found.append(noise.muscle_noise.copy())
    found = np.array(found[100:])
    np.testing.assert_allclose(found.std(axis=(0, 1)), 1, atol=0.05)
    slow, tremor = found[:, :, 0], found[:, :, 1]
    memory, expected = np.mean(slow[4:] * slow[:-4], axis=(0, 1)), np.exp(-2 * np.pi * 4 * 0.04)
    np.testing.assert_allclose(memory, expected, atol=0.05)
    power = (np.abs(np.fft.rfft(tremor, axis=0)) ** 2).sum(axis=(1, 2))
    frequency = np.fft.rfftfreq(len(tremor), DT)
    band = (frequency >= 8) & (frequency <= 12)
    assert power[band].sum() / power.sum() == pytest.approx(0.5, abs=0.05)
    assert abs(frequency[power.argmax()] - 10) < 1


def test_noise_varies_the_torque_in_proportion():
    env = ArmEnv(STILL, control={"noise": 1.0, "adaptation": 0.0}, coupling="none")
    torque, share = [], []
    env.reset(seed=0)
    for _ in range(300):
        angle, rate = physics(env, "qpos").copy(), physics(env, "qvel").copy()
        env.step(np.zeros(0))
        target, target_rate, given = physics(env, "ctrl")[addresses(env).intention]
        biasprm = env.episodes.simulation.batch.expand("actuator_biasprm")[0]
        stiffness, damping = -biasprm[addresses(env).human, 1:3].T
        total = given + stiffness * (target - angle) + damping * (target_rate - rate)
        share.append(NOISE_SIZE * state(env).muscle_noise[0, 0])
        torque.append(total / (1 + share[-1]))
    assert np.std(share, axis=0) == pytest.approx(NOISE_SIZE, rel=0.6)
    # Without its noise the shoulder's torque is that of an arm at rest.
    assert np.ptp(np.array(torque)[:, 1]) < 0.25 * np.abs(torque)[:, 1].mean()


def test_mistakes_are_named():
    rows = [
        ({"adaptation": 1.1}, "control.adaptation is 1.1: use a number from 0 to 1"),
        ({"adaptation": True}, "adaptation is True"),
        ({"stiffness": 0.1}, "control.stiffness is 0.1: use a number from 0.25 to 4 times a"),
        ({"delay": 50}, "control.delay is 50: use a number from 0 to 0.5 s"),
        ({"noise": float("nan")}, "noise is nan"),
        ({"tremor": "0.1"}, "control.tremor is '0.1': use a number from"),
        ({"stiff": 1}, "stiff is 1: use True or False"),
    ]
    assert_refused(lambda settings: VoluntaryControl(**settings), rows)
    between = [(DT, r"delay is 0.055 s.*0.01 s, such as 0.06 s")]  # two control periods
    assert_refused(VoluntaryControl(delay=0.055).periods, between)


MOVED = [JOINTS.index("shoulder_flexion"), ELBOW]
CREDIT = 10  # control periods between what was missing and what is given more of


@dataclass(frozen=True, kw_only=True)
class Again(RandomMoves):
    def motion(self, rng, samples, dt):
        return super().motion(np.random.default_rng(5), samples, dt)


BENT = {"shoulder_flexion": (0.8, 0.9), "elbow_flexion": (0.8, 0.9)}
HELD = RandomMoves(name="Still", hold=BENT, duration=2.0)
AGAIN = Again(name="Again", span=ARM_TRACKING.span, duration=4.0)
MOTION = "Test/Again-v0"


@pytest.fixture(scope="module", autouse=True)
def registered():
    gymnasium.register(MOTION, entry_point=ArmEnv, kwargs={"task": AGAIN})
    yield
    del gymnasium.registry[MOTION]


PLACE = {"coupling": "none", "gravity": "microgravity"}


def repeated(env, times):
    """Returns the tracking errors of whole episodes [rad], shape (periods, 2) each."""
    found = []
    for _ in range(times):
        if found:
            env.reset()
        told = reported(env, np.zeros((400, *env.action_space.shape)))
        assert env.episodes.truncated.all()
        found.append((told["target_angle"] - told["angle"])[:, MOVED])
    return found


@pytest.fixture(scope="module")
def practised():
    """A wearer who has repeated a motion in the suit, and the errors of each time."""
    env = ArmEnv(AGAIN, **PLACE)
    env.reset(seed=0)
    return SimpleNamespace(env=env, errors=repeated(env, 12))


def test_errors_fall_and_after_effects_point_the_other_way_and_are_forgotten(practised):
    sizes = [rms(error) for error in practised.errors]
    assert sizes[4] < 0.6 * sizes[0] and sizes[-1] < 0.45 * sizes[0]
    bare = ArmEnv(AGAIN, suit="none", **PLACE)
    bare.reset(seed=0)
    (usual,) = repeated(bare, 1)
    state(bare).next_gains[:] = state(practised.env).next_gains  # the suit is taken off
    bare.reset()
    errors = repeated(bare, 12)
    loaded, first = practised.errors[0] - usual, errors[0] - usual
    assert np.sum(first * loaded) < -0.2 * np.sum(loaded**2)
    assert rms(errors[-1] - usual) < 0.4 * rms(first)


def test_a_seed_forgets_and_no_seed_remembers_if_the_wearer_ever_learns(practised):
    env, never = ArmEnv(AGAIN, **PLACE), ArmEnv(AGAIN, control={"adaptation": 0.0})
    never.reset(seed=0)
    np.testing.assert_array_equal(*repeated(never, 2))
    assert state(never).gains.size == 0
    env.reset(seed=0)
    repeated(env, 1)
    kept = state(env).next_gains.copy()
    assert not state(env).gains.any()  # what was learned is foreseen in the next episode
    env.reset()
    np.testing.assert_array_equal(state(env).gains, kept)
    assert kept.any()
    env.reset(seed=0)
    assert not state(env).gains.any()
    np.testing.assert_array_equal(repeated(env, 1)[0], practised.errors[0])


def test_the_adapted_wearer_is_the_limit_of_the_law():
    wearers = Wearers(MOTION, 1, threads=1, **PLACE)
    policy = make_policy("none", wearers.arms)
    traces = wearers.unadapted(policy, [0])
    own, learned = wearers.arms.episodes.simulation.own_torque(np.array([0])), 0.0
    errors = []
    for _ in range(31):
        (trace,) = traces
        errors.append(rms((trace.angle - trace.target_angle)[:, MOVED]))
        answer = smoothed([trace.human_torque], own.shape[1]) - own - learned
        late = np.concatenate([answer[:, CREDIT:], answer[:, -1:].repeat(CREDIT, 1)], axis=1)
        learned = (1 - FORGETTING) * learned + RATE * late
        traces = rollout(wearers.arms, policy, [0], learned={"learned_torque": learned})
    assert 10 <= np.flatnonzero(np.array(errors) < 0.25 * errors[0])[0] <= 30
    lesson = wearers.learned_torque(lambda: policy, [0])[..., MOVED]
    assert rms(learned[..., MOVED] - lesson) < 0.1 * rms(lesson)
    wearers.close()


def test_who_has_learned_the_exoskeleton_gains_from_it_and_little_more_from_a_repetition():
    found = {}
    for name, change in (("none", 0.002), ("compensation", 0.03)):
        wearers = Wearers(MOTION, 1, threads=1)
        policy, traces = make_policy(name, wearers.arms), []
        for rollouts in (2, 3):
            lesson = wearers.learned_torque(lambda made=policy: made, [0], rollouts=rollouts)
            traces += rollout(wearers.arms, policy, [0], learned={"learned_torque": lesson})
        wearers.close()
        two, three = (rms(trace.effort) for trace in traces)
        assert three == pytest.approx(two, rel=change)
        found[name] = traces[0]
    off, assisted = found["none"], found["compensation"]
    assert rms(assisted.human_torque) < 0.5 * rms(off.human_torque)
    assert rms(assisted.angle - assisted.target_angle) < 0.01  # rad


YIELDS = {"rigid": 0.001, "cuffs": 0.015}  # [rad]: cuffs are unloaded when motors begin


@pytest.mark.parametrize("coupling", YIELDS)
def test_motors_begin_with_the_first_action_and_the_arm_stays(coupling):
    env = ArmEnv(HELD, coupling=coupling, control={"adaptation": 0.0})
    gravity = make_policy("gravity", env)
    for first in (None, np.array([0.2, -0.1])):
        observation, info = env.reset(seed=3)
        action = gravity.act(observation) if first is None else first
        wanted = action * addresses(env).peak_torque
        assert np.abs(wanted).max() > 3
        *_, info = env.step(action)
        np.testing.assert_allclose(info["assist_torque"], wanted, rtol=1e-6, atol=1e-9)
    observation, info = env.reset(seed=3)
    for _ in range(20):
        observation, *_, info = env.step(gravity.act(observation))
        assert np.abs(info["angle"] - info["target_angle"]).max() < YIELDS[coupling]


def test_the_first_half_second_decides_no_score():
    for name in ("none", "gravity"):
        arms = ArmVectorEnv(8, threads=1)
        traces = rollout(arms, make_policy(name, arms), range(8))
        rewards = np.sum([trace.rewards for trace in traces], axis=0)
        assert 0.03 < rewards[:50].sum() / rewards.sum() < 0.08
