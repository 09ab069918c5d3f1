"""What careless users did: nothing is lost, and one sentence says what was wrong."""

import json
import os
import signal
from dataclasses import dataclass, field

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.tasks import RandomMoves, Task
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.errors import InputError
from helpers import assert_refused

SPAN = {"elbow_flexion": (0.5, 1.2)}


@dataclass(frozen=True, kw_only=True)
class Fragile(RandomMoves):
    """A task whose motion can be made to fail."""

    broken: list = field(default_factory=list)

    def motion(self, rng, samples, dt):
        angle, rate, acceleration = super().motion(rng, samples, dt)
        return (angle * np.nan if self.broken else angle), rate, acceleration


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
    task = Fragile(name="Fragile", span=SPAN, duration=0.3)
    arms = ArmVectorEnv(3, task)
    arms.reset(seed=0)
    task.broken.append(True)
    assert_refused(lambda: arms.reset(seed=0), [("finite numbers",)])
    assert_refused(arms.step, [(np.zeros((3, 2)), "step before the first reset: call reset")])
    task.broken.clear()
    again, _ = arms.reset(seed=0)
    np.testing.assert_array_equal(again, ArmVectorEnv(3, task).reset(seed=0)[0])


def test_a_refused_action_leaves_the_history_alone():
    env = ArmEnv(history=3)
    env.reset(seed=0)
    for value in (0.1, 0.2, 0.3):
        seen, *_ = env.step(np.full(2, value))
    assert_refused(env.step, [([np.nan, 0.0], "finite")])
    np.testing.assert_array_equal(env.set_state(env.get_state())[0], seen)


def test_a_state_knows_that_its_episode_is_over():
    still = np.zeros((1, 2))
    for mode in ("NextStep", "Disabled"):
        arms = ArmVectorEnv(1, "ElbowFlexion", max_episode_steps=3, autoreset_mode=mode)
        arms.reset(seed=0)
        for _ in range(3):
            arms.step(still)
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


@dataclass(frozen=True, kw_only=True)
class Recorded(Task):
    """A task that has an array."""

    path: np.ndarray = field(default_factory=lambda: np.zeros(5))

    def motion(self, rng, samples, dt):
        still = np.zeros((samples, 4))
        return still + np.array([0, 0.8, 1, 0]), still, still


def test_states_of_tasks_with_arrays():
    env = ArmEnv(Recorded(name="Recorded", duration=0.2))
    env.reset(seed=0)
    env.set_state(env.get_state())
    other = ArmEnv(Recorded(name="Recorded", duration=0.2, path=np.ones(5)))
    assert_refused(other.set_state, [(env.get_state(), "path=")])


def test_an_info_that_nobody_has_read_is_whole_in_json():
    _, info = ArmEnv().reset(seed=0)
    text = json.dumps(info, default=lambda array: array.tolist())
    assert "human_torque" in json.loads(text)
