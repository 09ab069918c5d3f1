"""Mistakes and careless use of environments: one sentence for each, and nothing changes."""

import json
import os
import signal
from dataclasses import dataclass, field

import gymnasium
import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.tasks import RandomMoves, Task
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.errors import InputError
from arms import go_on
from helpers import assert_refused

ELBOW = "ActiveSuit/ElbowFlexion-v0"
BELIEF = ["encoders", "belief"]
SPAN = {"elbow_flexion": (0.5, 1.2)}
SHORT = RandomMoves(name="Short", span=SPAN, duration=0.1)
OPTIONS = [
    ({"suit": "nun"}, "unknown suit 'nun'"),
    ({"gravty": "moon"}, "unknown option 'gravty'.*did you mean 'gravity'"),
    ({"control": {"nose": 1}}, "unknown field of control 'nose'.*did you mean 'noise'"),
    ({"control": {"delay": 0.015}}, "delay is 0.015 s: give it as a multiple of the control"),
    ({"render_mode": "ascii"}, "render_mode is 'ascii'"),
    ({"width": 64.5}, "picture size is 64.5 x 480: use whole numbers"),
    ({"render_quality": "best"}, "unknown render_quality 'best': use one of fast, fine"),
    ({"render_quality": []}, "unknown render_quality"),
    ({"picture_dt": -1}, "picture_dt is -1: use a number from 0 to 10 s"),
    ({"control_dt": 0.003}, "control_dt must be a multiple"),
    ({"control_dt": np.nan}, "control_dt is nan: use a number from 0 to 0.02 s"),
    ({"control_dt": 0.008}, "control_dt is 0.008: it must divide 0.02 s"),
    ({"control_dt": 0.0}, "control_dt must be a multiple"),
    ({"fatigue": "no"}, "fatigue is 'no': use True or False"),
    # What is observed.
    ({"sensors": ["all"]}, "unknown sensor suite 'all': use one of belief, cuffs, emg"),
    ({"sensors": [["encoders"]]}, "unknown sensor suite"),
    ({"sensors": "encoders"}, "sensors is 'encoders': give a list of suites"),
    ({"sensors": []}, "sensors is empty: name at least one of encoders"),
    ({"sensors": ["encoders", "encoders"]}, "sensors has 'encoders' twice"),
    ({"sensors": ["cuffs"]}, "sensors has 'cuffs', and this coupling has none"),
    ({"normalize": 1}, "normalize is 1: use True or False"),
    ({"history": 0}, "history is 0: use a whole number from 1 to 1000"),
    ({"sensing": {"emg_noise": 2}}, "sensing.emg_noise is 2: use a number from 0 to 1"),
    ({"sensing": {"encoder_noise": 0.01}}, "sensing 'encoder_noise': .* 'exo.encoder_bits'"),
    ({"belief": {}}, r"belief is \{\}, and sensors is \['encoders'\]: add 'belief' to sensors"),
    ({"sensors": BELIEF, "belief": {"suite": 1}}, "unknown field of belief 'suite'"),
    ({"sensors": BELIEF, "belief": 3}, r"belief is 3: give ArmConfig\(...\) or a dict"),
    # What differs between episodes.
    ({"level": "randomised"}, "unknown level .*: use one of beyond, faults, nominal, ran"),
    ({"level": ["shift"]}, "unknown level"),
    ({"level": "shift", "randomize": 3}, "randomize is 3: give Randomization"),
    ({"randomize": {"size": 2}}, "unknown field of randomize 'size'"),
    ({"randomize": {"gravity": ["sun"]}}, "unknown place in randomize.gravity 'sun'"),
    ({"randomize": {"gravity": "moon"}}, "randomize.gravity is 'moon': give a list"),
    ({"randomize": {"spring": 2.5}}, "spring is 2.5: give the least and the greatest factor"),
    ({"randomize": {"loop": [0.7]}}, r"loop is \[0.7\]: give the least and the greatest factor"),
    ({"randomize": {"loop": [0.0, 2]}}, "loop is 0.0: use a number from 0.05 to 20"),
    ({"randomize": {"spring": [2.5, 0.7]}}, r"spring is \[2.5, 0.7\]: give the ends in ascending"),
    ({"randomize": {"spring": [0.7, "a"]}}, "spring is 'a': use a number from 0.05 to 20"),
    ({"randomize": {"loop": [0.7, 2.5]}, "suit": "none"}, "and suit is 'none': name a suit"),
    ({"randomize": {"payload": 3}}, "randomize.payload is 3: give two numbers"),
    ({"randomize": {"payload": [3, 1]}}, r"payload is \[3, 1\]: give the smaller number first"),
    ({"randomize": {"payload": [0, 99]}}, "payload is 99: use a number from 0 to 60 kg"),
    ({"randomize": {"pressure": "much"}}, "randomize.pressure is 'much'"),
    ({"randomize": {"load": 0.6}}, "randomize.load is 0.6: use a number from 0 to 0.5"),
    ({"randomize": {"suit": "any"}}, "unknown choice of randomize.suit 'any': use one of"),
    ({"randomize": {"suit": "samples"}}, "'samples', and the suit has none"),
    ({"randomize": {"pressure": 0.1}, "suit": "none"}, "and suit is 'none': name a suit"),
    ({"randomize": {"suits": "emu-like"}}, "suits is 'emu-like': give a list of suits"),
    ({"randomize": {"suits": ["none"]}}, "suits has 'none': give names or files of suits"),
    ({"randomize": {"cycles": [0, 4]}}, "cycles is .*, and no joint"),
    ({"randomize": {"wearers": [{"size": 2}]}}, r"unknown field of randomize.wearers\[0\]"),
    ({"randomize": {"wearers": {"sex": "male"}}}, "wearers is .*: give a list of persons"),
    ({"randomize": {"misalignment": 0.01}}, "only coupling='cuffs' lets exoskeleton and arm"),
    # What fails.
    ({"faults": {"torque_bias": 80}}, "faults.torque_bias is 80: use a number from -50 to 50 N·m"),
    ({"faults": {"since": np.nan}}, "faults.since is nan"),
    ({"faults": {"stuck": "elbow_flexion"}}, "faults.stuck is 'elbow_flexion': give a list"),
    ({"faults": {"stopped": ["wrist_flexion"]}}, "unknown joint of faults.stopped 'wrist_fl"),
    ({"faults": {"stopped": ["elbow_flexion"] * 2}}, "faults.stopped are .*: name each one once"),
    ({"faults": {"broken": 1}}, "unknown field of faults 'broken'"),
    ({"faults": 3}, "faults is 3"),
    ({"coupling": "none", "faults": {"stopped": ["elbow_flexion"]}}, "where there are no motors"),
]
ROWS = [
    ({"num_envs": 0}, "num_envs is 0: use at least 1"),
    ({"num_envs": 2.5}, "num_envs is 2.5"),
    ({"threads": -1}, "threads is -1: use at least 0"),
    ({"threads": 10**12}, "threads is 10.*: use at most 1,024"),
    ({"autoreset_mode": "Later"}, "unknown autoreset_mode 'Later': use one of"),
    ({"info": "some"}, "unknown info 'some': use one of full, metrics, none"),
    ({"stagger": 1}, "stagger is 1: use True or False"),
    ({"max_episode_steps": 0}, "max_episode_steps is 0: use at least 1"),
    ({"level": 3}, "unknown level"),
    ({"render_mode": "human"}, "render_mode is 'human': use None or 'rgb_array'"),
    ({"speed": 1}, "unknown option 'speed'"),
    ({"taught": True}, "'taught' was a name of version"),
]


def test_options():
    rows = [*((ArmEnv, *row) for row in OPTIONS), *((ArmVectorEnv, *row) for row in ROWS)]
    assert_refused(lambda kind, options: kind(**options), rows)


@pytest.fixture(scope="module")
def env():
    return ArmEnv(SHORT)


@pytest.fixture(scope="module")
def arms():
    return ArmVectorEnv(3, SHORT, autoreset_mode="Disabled", learned_torque=True)


def test_what_is_no_action_is_refused_and_changes_nothing(env):
    actions = [
        *(["0.5", "-0.5"], "00", [None, None], [True, False], [[0.1], [0.1, 0.2]]),
        *([0.1 + 0j, 0.2], {"elbow": 1}, np.array([b"1", b"0"]), ["x" * 1000, 0]),
    ]
    env.reset(seed=0)
    env.step(np.full(2, 0.2))
    before = env.get_state()["physics"]
    message = r"^action is .{1,280}: give 2 numbers from -1 to 1$"
    assert_refused(env.step, [(action, message) for action in actions])
    np.testing.assert_array_equal(env.get_state()["physics"], before)


def test_resets_that_cannot_be_change_nothing(env, arms):
    env.reset(seed=0)
    state = env.get_state()
    known = r"reset got the options .*: there are no such options"
    junk = [(5, known), ({"seed": 1}, known), ({"x": [0] * 5000}, known), ({"mask": 1}, known)]
    assert_refused(lambda options: env.reset(seed=5, options=options), junk)
    again = env.get_state()
    np.testing.assert_array_equal(again["physics"], state["physics"])
    assert (again["seed"], again["episode"]) == (state["seed"], state["episode"])
    env.reset(options={})
    assert_refused(env.render, [("render_mode is None",)])
    learned = np.zeros((3, 11, 4))
    rows = [
        ([], r"the options \[\]: give a dict"),
        ({"mask": None}, r"reset got the options \['mask'\]: use 'reset_mask'"),
        ({"reset_mask": [True] * 3}, "reset_mask is .*: give an array of 3 booleans"),
        ({"reset_mask": np.ones(2, bool)}, "reset_mask is .*: give an array of 3 booleans"),
        ({"reset_mask": np.zeros(3, bool)}, "reset_mask names no row: set at least one"),
        ({"learned_torque": learned[:, 1:]}, r"shape \(3, 10, 4\): .* \(3, 11, 4\)"),
        ({"learned_torque": learned + np.nan}, "learned_torque is not finite at sample 0: give"),
    ]
    assert_refused(lambda options: arms.reset(seed=0, options=options), rows)
    other = ArmVectorEnv(3, SHORT)
    row = ({"learned_torque": learned}, "make the environment with learned_torque=True")
    assert_refused(lambda options: other.reset(seed=0, options=options), [row])
    other.reset(seed=0)
    rows = [
        ([1, 2], "seed has 2 numbers: give one for each of 3 rows"),
        (-1, "seed is -1: use at least 0"),
        ("one", "seed is 'one': use a whole number"),
        *((seed, "seed") for seed in (2**63 - 1, np.array(3), b"ab", [1, True, 2])),
    ]
    assert_refused(lambda seed: other.reset(seed=seed), rows)
    other.step(np.zeros((3, 2)))


def test_steps_and_states_of_rows_that_cannot_be():
    arms = ArmVectorEnv(3, SHORT, autoreset_mode="Disabled", max_episode_steps=2)
    still = np.zeros((3, 2))
    assert_refused(arms.step, [(still, "step before the first reset: call reset")])
    arms.reset(seed=0)
    before = arms.get_state()["physics"]
    rows = [
        (np.zeros((2, 2)), r"action has shape \(2, 2\): give \(3, 2\)"),
        ([[0, 0], [0, np.nan], [0, 0]], r"action of row 1 is \[0.0, nan\]: give finite numbers"),
        ("push", "action is 'push': give 2 numbers"),
    ]
    assert_refused(arms.step, rows)
    np.testing.assert_array_equal(arms.get_state()["physics"], before)
    two = arms.get_state(rows=[0, 1])
    assert_refused(arms.set_state, [(two, "the state is of 2 rows, and 3 are to be restored")])
    junk = ([3], [0, 0], [0.5], [[1]], [[0], [1, 2]], "all")
    assert_refused(arms.get_state, [(rows, "rows is .*: give different whole") for rows in junk])
    go_on(arms, 2)
    assert_refused(arms.step, [(still, r"episodes of rows \[0, 1, 2\] are over: reset them")])


def test_calls():
    rows = [
        (lambda: evaluate(ELBOW, 3), "policies is 3: give a list of names"),
        (lambda: evaluate("ActiveSuit/Knee-v0", ["none"]), "unknown environment 'ActiveSuit/Knee"),
        (lambda: evaluate("CartPole-v1", ["none"]), "'CartPole-v1' is no arm of ActiveSuit"),
        (lambda: evaluate(3, ["none"]), "env_id is 3: give the id of an environment"),
        (lambda: evaluate(ELBOW, ["none"], stagger=True), "is True: rollout needs 'NextStep'"),
        (lambda: evaluate(ELBOW, ["none"], autoreset_mode="SameStep"), "False: rollout needs"),
        (lambda: vec_env()(gymnasium.make(ELBOW)), r"arms is .*: give an ArmVectorEnv"),
        (lambda: ArmEnv(suit=load_suit("mock-suit"), randomize={"cycles": [4, 0]}), "cycles"),
    ]
    assert_refused(lambda call: call(), rows)


def vec_env():
    pytest.importorskip("stable_baselines3")
    from activesuit.envs.sb3 import ArmVecEnv

    return ArmVecEnv


@dataclass(frozen=True, kw_only=True)
class Posture(Task):
    angle: np.ndarray = field(default_factory=lambda: np.array([0, 0.8, 1, 0]))

    def motion(self, rng, samples, dt):
        still = np.zeros((samples, 4))
        return still + self.angle, still, still


def test_a_child_without_the_threads_of_its_parent_is_told_so():
    arms = ArmVectorEnv(2, threads=2)
    arms.reset(seed=0)
    arms.step(np.zeros((2, 2)))
    child = os.fork()
    if child == 0:  # ends without a word to pytest, whatever happens
        signal.alarm(20)
        try:
            arms.step(np.zeros((2, 2)))
        except InputError as error:
            os._exit(0 if "made before a fork" in str(error) else 2)
        os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_a_failed_reset_asks_for_another():
    task = Posture(name="Posture", duration=0.3)
    arms = ArmVectorEnv(3, task)
    arms.reset(seed=0)
    task.angle[1] = np.nan
    assert_refused(lambda: arms.reset(seed=0), [("finite numbers",)])
    assert_refused(arms.step, [(np.zeros((3, 2)), "step before the first reset: call reset")])
    task.angle[1] = 0.8
    again, _ = arms.reset(seed=0)
    np.testing.assert_array_equal(again, ArmVectorEnv(3, task).reset(seed=0)[0])


def test_a_state_knows_that_its_episode_is_over():
    still = np.zeros((1, 2))
    for mode in ("NextStep", "Disabled"):
        arms = ArmVectorEnv(1, "ElbowFlexion", max_episode_steps=3, autoreset_mode=mode)
        arms.reset(seed=0)
        go_on(arms, 3)
        state = arms.get_state()
        if mode == "NextStep":
            first = arms.step(still)
            arms.set_state(state)
            for one, other in zip(first[:4], arms.step(still)[:4], strict=True):
                np.testing.assert_array_equal(one, other)
    arms.reset()
    arms.set_state(state)
    assert_refused(arms.step, [(still, "are over: reset them")])


def test_a_restored_row_keeps_its_own_limit():
    single = ArmEnv("ElbowFlexion")
    single.reset(seed=0)
    arms = ArmVectorEnv(2, "ElbowFlexion", max_episode_steps=5)
    arms.reset(seed=0)
    arms.set_state(single.get_state(), rows=[0])
    ends = [arms.step(np.zeros((2, 2)))[3].tolist() for _ in range(5)]
    assert ends[-1] == [True, True]


def test_states_of_tasks_with_arrays():
    env = ArmEnv(Posture(name="Posture", duration=0.2))
    env.reset(seed=0)
    env.set_state(env.get_state())
    other = ArmEnv(Posture(name="Posture", duration=0.2, angle=np.array([0, 0.9, 1, 0])))
    assert_refused(other.set_state, [(env.get_state(), "angle=")])


def test_an_info_that_nobody_has_read_is_whole_in_json():
    _, info = ArmEnv().reset(seed=0)
    text = json.dumps(info, default=lambda array: array.tolist())
    assert "human_torque" in json.loads(text)
