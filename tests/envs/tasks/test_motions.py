"""Every task has many motions, which every wearer can carry out and no open loop knows."""

from dataclasses import fields, replace

import numpy as np
import pytest
from activesuit.envs.domain.levels import LEVELS
from activesuit.envs.model import ArmConfig, bare_arm, compose
from activesuit.envs.setup import Setup
from activesuit.envs.simulation.kinematics import Arm
from activesuit.envs.simulation.state import stream
from activesuit.envs.tasks import TASKS
from activesuit.envs.tasks.motions import distinct
from activesuit.published import LI_RANGES
from arms import PEOPLE
from helpers import assert_refused

DT = 0.01  # s
SEEDS = range(20)
EVALUATED = range(10_000, 10_008)
SETUPS = {name: Setup.of(TASKS["Scoop"], {"level": name}) for name in LEVELS}
PERSONS = {*PEOPLE, *(one for setup in SETUPS.values() for one in setup.randomize.wearers)}


def made_arm(wearer):
    config = ArmConfig(wearer=wearer)
    return Arm.of(bare_arm(config), compose(config, drawn=False).site("hand_grip").pos)


ARMS = {wearer: made_arm(wearer) for wearer in PERSONS}


def plan(task, seed, wearer=PEOPLE[0]):
    samples = round(task.duration / DT) + 1
    return task.plan(stream(seed, 0, "motion"), samples, DT, ARMS[wearer])


@pytest.fixture(scope="module", params=TASKS.values(), ids=TASKS)
def task(request):
    """A shipped task."""
    return request.param


def test_motions_that_differ_by_less_than_a_milliradian_are_one():
    still = np.zeros((5, 4))
    assert distinct([]) == 0
    assert distinct([still, still + 0.9e-3, still - 0.9e-3, still + 2e-3]) == 2
    assert distinct([still, still[:3]]) == 1  # one ended early


@pytest.mark.parametrize("level", LEVELS)
def test_every_seed_has_a_motion_of_its_own(task, level):
    """A level changes the motion through the wearer alone."""
    terms, short = SETUPS[level].randomize, replace(task, duration=min(task.duration, 20.0))
    found = []
    for seed in SEEDS:
        number = terms.person(lambda purpose, seed=seed: stream(seed, 0, purpose))
        wearer = (*terms.wearers, PEOPLE[0])[number]
        found.append(plan(short, seed, wearer).motion[0])
    assert distinct(found) == len(SEEDS)


def test_every_wearer_can_carry_out_every_motion(task):
    """Angles are within the measured ranges, and a hand that is wanted somewhere gets there."""
    for wearer in PERSONS:
        for seed in range(3):
            angle, rate, _ = plan(task, seed, wearer).motion
            for joint, (low, high) in zip(("shoulder", "elbow"), LI_RANGES.values(), strict=True):
                moved = angle[:, 1 if joint == "shoulder" else 2]
                assert low - 1e-9 <= moved.min() and moved.max() <= high + 1e-9
            assert not angle[:, 3].any() and np.abs(rate[0]).max() < 1e-6
            assert (ARMS[wearer].ranges[0, 0] <= angle[:, 0]).all()


def test_no_open_loop_knows_them(task):
    """Frozen arms, and those that play the mean or the first motion, exceed a limit in each."""
    plans = [plan(task, seed) for seed in EVALUATED]
    angles = np.array([one.motion[0] for one in plans])
    for i, one in enumerate(plans):
        others = np.delete(angles, i, axis=0)
        played = {"mean": others.mean(axis=0), "frozen": 0 * angles[i] + angles[i].mean(axis=0)}
        played |= {"first": angles[0]} if i else {}
        for name, angle in played.items():
            error = np.sqrt(np.mean((angle - angles[i]) ** 2, axis=0)).max()
            missed = 0.0
            if task.watches:
                arm = ARMS[PEOPLE[0]]
                apart = arm.places(angle) - arm.places(angles[i])
                missed = np.linalg.norm(apart, axis=1)[one.watched].max()
            assert error > task.tracking or missed > task.hand_error, (i, name)


def test_loads_and_motions_are_drawn_apart():
    for name, load in (("ObjectRelocation", "load"), ("Scoop", "load"), ("Handrail", "pull")):
        task = replace(TASKS[name], duration=12.0)
        one, other = plan(task, 3), plan(replace(task, **{load: (0.0, 0.0)}), 3)
        np.testing.assert_array_equal(one.motion, other.motion)
        for loads, carried in ((one.mass, other.mass), (one.push, other.push)):
            assert loads is None or (loads.any() and not carried.any())


CYCLIC = [task for task in TASKS.values() if task.period]


@pytest.mark.parametrize("task", CYCLIC, ids=[task.name for task in CYCLIC])
def test_a_controller_may_rely_on_the_period(task):
    """Where places are not drawn anew, a period later all is as before."""
    places = {"grip", "release", "depth", "height"} & {one.name for one in fields(task)}
    fixed = replace(task, **{name: (0.6, 0.6) for name in places})
    for seed in range(5):
        one = plan(fixed, seed)
        period, begin = round(task.period / DT), round((max(task.wait) + 1.5) / DT)
        before, after = slice(begin, -period), slice(begin + period, None)
        np.testing.assert_allclose(one.motion[0][after], one.motion[0][before], atol=1e-6)
        assert np.mean(one.watched[after] == one.watched[before]) > 0.98
        assert one.watched[before].any()


@pytest.mark.parametrize("name", TASKS)
def test_ranges_are_fields_that_are_checked(name):
    task = TASKS[name]
    ranges = [
        one.name
        for one in fields(task)
        if "setting" in one.metadata and isinstance(one.default, tuple)
    ]
    assert ranges or name == "MinorLoops"  # whose phases are any
    rows = [({one: (1.0,)}, rf"the task's {one} is \(1.0,\): give two numbers") for one in ranges]
    rows += [({one: (-1.0, 0.5)}, f"the task's {one} is -1.0: use a number from") for one in ranges]
    assert_refused(lambda given: replace(task, **given), rows)


def test_a_fixed_range_is_a_fixed_motion():
    fixed = {"grip": (0.1, 0.1), "release": (0.9, 0.9), "pull_time": (2.0, 2.0), "wait": (0.0, 0.0)}
    rail = replace(TASKS["Handrail"], duration=8.0, **fixed)
    assert distinct(plan(rail, seed).motion[0] for seed in range(3)) == 1
