"""Plans and tasks that cannot be: one sentence says what is wrong with each."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.model.workplace import add_pushes
from activesuit.envs.simulation.episode_plan import Plan
from activesuit.envs.tasks import (
    ARM_TRACKING,
    TASKS,
    Hammer,
    ObjectRelocation,
    RandomMoves,
    RecordedMotion,
    Scoop,
    Task,
)
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
    carries = True
    made = None

    def edit(self, spec):
        add_pushes(spec)

    def plan(self, rng, samples, dt, arm):
        return self.made


class Idle(Planned):
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


HEADER = ["time", *JOINTS]
STEP = 0.02  # s between recorded samples
TIME = STEP * np.arange(50)
SWING = np.column_stack(
    [TIME, 0.1 * np.sin(TIME), 0.8 + 0.2 * np.sin(TIME), 1 + 0.2 * np.cos(TIME), 0 * TIME]
)


def write(path, rows, header=HEADER):
    lines = [",".join(header), *(",".join(str(cell) for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def test_a_recorded_plan_is_the_same_motion(tmp_path):
    """The step is 0.02 s, and the jerk of a move jumps by at most 60 rad / (1.2 s)^3.

    So a cubic spline is off by less than 35 rad/s³ (0.02 s)³ / 40 = 7e-6 rad, its slope by
    35 rad/s³ (0.02 s)² / 4 = 4e-3 rad/s. The end, where the spline is at rest and the motion is
    not, is half a second after what is compared.
    """
    dt, duration = 0.01, 2.0
    samples = round(duration / dt) + 1
    motion = ARM_TRACKING.motion(np.random.default_rng(5), samples + 50, dt)
    rows = np.column_stack([3.0 + dt * np.arange(samples + 50), motion[0]])[::2]
    order = [2, 0, 4, 1, 3]  # of columns, which have names
    path = write(tmp_path / "plan.csv", rows[:, order], [HEADER[i] for i in order])
    task = RecordedMotion(name="Recorded", path=path, duration=duration)
    found = task.motion(np.random.default_rng(0), samples, dt)
    for now, before, error in zip(found, motion, (7e-6, 4e-3, 1.0), strict=True):
        np.testing.assert_allclose(now, before[:samples], atol=error)
    assert np.ptp(found[0], axis=0)[1] > 0.3
    np.testing.assert_allclose(found[0][::2], motion[0][:samples:2], atol=1e-12)


def test_the_arm_follows_it_until_its_end(tmp_path):
    path = write(tmp_path / "swing.csv", SWING)
    task = RecordedMotion(name="Swing", path=path)
    assert task.duration == pytest.approx(TIME[-1])
    env = ArmEnv(task, coupling="none")
    env.reset(seed=0)
    truncated, steps = False, 0
    while not truncated:
        *_, terminated, truncated, info = env.step(np.zeros(0))
        assert not terminated
        steps += 1
    assert steps == round(TIME[-1] / 0.01)
    np.testing.assert_allclose(info["target_angle"], SWING[-1, 1:], atol=1e-12)
    longer = replace(task, duration=2.0).motion(np.random.default_rng(0), 201, 0.01)
    np.testing.assert_allclose(longer[0][120:], np.tile(SWING[-1, 1:], (81, 1)), atol=1e-12)
    assert not longer[1][120:].any() and not longer[2][120:].any()


def test_the_mark_of_spreadsheets_and_empty_lines_do_no_harm(tmp_path):
    path = tmp_path / "sheet.csv"
    plain = RecordedMotion(name="A", path=write(path, SWING)).motion(None, 50, 0.01)
    path.write_text("\ufeff" + path.read_text().replace("\n", "\r\n\r\n"), encoding="utf-8")
    sheet = RecordedMotion(name="B", path=str(path)).motion(None, 50, 0.01)
    np.testing.assert_array_equal(plain, sheet)


def test_files_that_are_no_motion_are_refused(tmp_path):
    def changed(row, column, value):
        rows = SWING.astype(object)
        rows[row, column] = value
        return rows

    def recorded(cells, header):
        path = write(tmp_path / "motion.csv", cells, header)
        return ArmEnv(RecordedMotion(name="Recorded", path=path), coupling="none")

    rows = [
        (np.delete(SWING, range(10, 15), axis=0), HEADER, "a gap from 0.18 to 0.3 s, .*: fill it"),
        (SWING * [20, 1, 1, 1, 1], HEADER, "samples may be 0.2 s apart at most"),
        (SWING * [1, *[180 / np.pi] * 4], HEADER, "if these are degrees, give radians"),
        (SWING, ["time", "a", "b", "c", "d"], "has the columns time, a, b, c, d: use time, should"),
        ([], [], "is empty: give a header 'time,"),
        (SWING[:2], HEADER, "has 2 samples: a motion needs at least 3"),
        (changed(7, 0, SWING[6, 0]), HEADER, "line 9: the time stands still at 0.12 s"),
        (changed(7, 2, "bent"), HEADER, "shoulder_flexion is 'bent': give a finite number"),
        (changed(7, 2, "nan"), HEADER, "shoulder_flexion is .*: give a finite number"),
        ([*SWING[:9].tolist(), [1, 2]], HEADER, "line 11: 2 cells where the header has 5"),
        (SWING * [1e-4, 1, 1, 1, 1], HEADER, "lasts 9.8e-05 s: use 0.02 to 3600 s"),
        (SWING + np.eye(5)[3] * 2.5, HEADER, r"elbow_flexion from .* to .* rad: stay between"),
    ]
    assert_refused(recorded, rows)
    rows = [(path, "cannot read the motion ") for path in ("nowhere.csv", ".", None, 3, "a\0b")]
    assert_refused(lambda path: RecordedMotion(name="Recorded", path=path), rows)
