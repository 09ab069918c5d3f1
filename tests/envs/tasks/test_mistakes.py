"""Plans and tasks that cannot be: one sentence says what is wrong with each."""

from dataclasses import replace

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.model.workplace import add_pushes
from activesuit.envs.simulation.episode_plan import Plan
from activesuit.envs.tasks import TASKS, Hammer, ObjectRelocation, RandomMoves, Scoop, Task
from activesuit.envs.tasks.tools import Ratchet
from activesuit.envs.vector_env import ArmVectorEnv
from helpers import assert_refused

SAMPLES = 11
DURATION = 0.1  # s
HELD = np.tile([0.0, 0.8, 1.0, 0.0], (SAMPLES, 1))
STILL = np.zeros((SAMPLES, 4))
MOTION = (HELD, STILL, STILL)
PUSH = np.zeros((SAMPLES, 3))


class Planned(Task):
    """A task whose plan the test makes."""

    carries = True
    made = None

    def edit(self, spec):
        add_pushes(spec)

    def plan(self, rng, samples, dt, arm):
        return self.made


class Idle(Planned):
    """One that neither carries nor pushes."""

    carries, edit = False, Task.edit


def with_plan(kind, plan):
    task = kind(name="Planned", duration=DURATION)
    object.__setattr__(task, "made", plan)
    return task


def test_plans_are_checked():
    rows = [
        (Planned, MOTION, r"the task's plan is \(.*\): return a Plan"),
        (Planned, None, "the task's plan is None: return a Plan"),
        (Planned, Plan(("bent", STILL, STILL)), "the task's motion is 'bent': give numbers"),
        (Planned, Plan((9 * HELD, STILL, STILL)), "motion takes shoulder_flexion from 7.2 to "),
        (Planned, Plan((HELD[1:], STILL, STILL)), r"shape \(10, 4\), .*: give .*\(11, 4\) each"),
        (Planned, Plan((HELD * np.nan, STILL, STILL)), "finite numbers"),
        (Idle, Plan(MOTION, mass=np.ones(SAMPLES)), "plan has a mass: set carries = True in its"),
        (Idle, Plan(MOTION, push=PUSH), r"plan has a push: call add_pushes\(spec\) in its edit"),
        (Planned, Plan(MOTION, mass=np.full(SAMPLES, 61.0)), "load is 61 to 61 kg: stay between"),
        (Planned, Plan(MOTION, mass=np.ones(3)), r"mass has shape \(3,\): give finite numbers of"),
        (Planned, Plan(MOTION, mass=np.full(SAMPLES, np.nan)), "mass is not finite at sample 0"),
        (Planned, Plan(MOTION, mass="heavy"), "the task's mass is 'heavy': give numbers"),
        (Planned, Plan(MOTION, push=PUSH + 1), r"push begins with \[1.*\] N: begin with 0"),
        (Planned, Plan(MOTION, push=np.outer(np.arange(11), [0, 0, 200])), "push reaches 2000 N:"),
        (Planned, Plan(MOTION, push=PUSH[:, :2]), r"push has shape \(11, 2\): give finite numbers"),
        (Planned, Plan(MOTION, watched=np.ones(2)), r"watched has shape \(2,\): give finite"),
    ]
    assert_refused(lambda kind, plan: ArmEnv(with_plan(kind, plan), coupling="none"), rows)


def test_a_good_plan_is_none_of_them():
    plan = Plan(MOTION, np.full(SAMPLES, 60.0), PUSH, np.ones(SAMPLES, bool))
    ArmEnv(with_plan(Planned, plan), coupling="none").reset(seed=0)
    ArmEnv(with_plan(Idle, Plan(MOTION)), coupling="none").reset(seed=0)


def test_what_is_no_task_is_refused():
    rows = [
        (Task(name="Empty"), "'Empty' has no motion: override motion or plan"),
        (Scoop, "task is a type: give a Task, or the name of one"),
        ({"name": "Scoop"}, "task is a dict: give a Task, or the name of one"),
        ("Scop", "unknown task 'Scop': use one of .*; did you mean 'Scoop'"),
    ]
    assert_refused(ArmEnv, rows)
    assert_refused(lambda task: ArmVectorEnv(1, task), rows)


def moves(**fields):
    return RandomMoves(**{"name": "Mine", "span": {"elbow_flexion": (0.5, 1.2)}, **fields})


def test_fields_of_tasks_are_checked():
    rows = [
        (lambda: Hammer(name="Hammer", mass="x"), "the task's mass is 'x': use a number from"),
        (lambda: Scoop(name="Scoop", load=(5, 1)), r"load is \(5, 1\): give the smaller number"),
        (lambda: Scoop(name="Scoop", load=None), "the task's load is None: give two numbers"),
        (lambda: ObjectRelocation(name="O", load=(-1, 1)), "the task's load is -1: use a number"),
        (lambda: Ratchet(name="Ratchet", reaction=-1), "the task's reaction is -1: use a number"),
        (lambda: replace(TASKS["Handrail"], pull=(1,)), r"pull is \(1,\): give two numbers"),
        (lambda: Task(name="Mine", effort="low"), "the task's effort is 'low': use a number"),
        (lambda: moves(duration=-1), "the task's duration is -1: use a number from 0.02 to 3600 s"),
        (lambda: moves(duration=np.nan), "the task's duration is nan"),
        (lambda: moves(span={"knee": (0, 1)}), "unknown joint in the task's span 'knee'"),
        (lambda: moves(span={"elbow_flexion": (1, 0)}), "of elbow_flexion is .*: give the smaller"),
        (lambda: moves(span={"elbow_flexion": 3}), "span of elbow_flexion is 3: give two numbers"),
        (lambda: moves(span=[]), r"the task's span is \[\]: give a dict of angles by joint"),
        (lambda: moves(hold={"elbow_flexion": (0, 1)}), "span and hold both have elbow_flexion"),
        (lambda: moves(move_time=(2, 1)), "move_time is .*: give the smaller number first"),
        (lambda: moves(name=""), "the task's name is '': give it one"),
    ]
    assert_refused(lambda make: make(), rows)


def test_payload_and_load_are_refused_together_before_the_episode():
    task = replace(TASKS["OverheadHold"], load=10.0, duration=0.1)
    env = ArmEnv(task, coupling="none", payload={"mass": 55.0})
    message = "payload and the task's load are 65 kg together: stay"
    assert_refused(lambda: env.reset(seed=0), [(message,)])


def test_a_state_with_another_load_in_the_plan_is_refused():
    env = ArmEnv(replace(TASKS["OverheadHold"], duration=0.1), coupling="none")
    env.reset(seed=0)
    state = env.get_state()
    others = [{**state, "carried": 0 * state["carried"] + mass} for mass in (-1.0, 1e6)]
    message = r"the state's carried is .* from 0 to 60"
    assert_refused(env.set_state, [(other, message) for other in others])
