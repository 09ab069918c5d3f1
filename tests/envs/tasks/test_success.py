"""When a task has gone well: each quantity that it watches can spoil it, and no other."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.reward import is_success
from activesuit.envs.tasks import TASKS
from activesuit.envs.tasks.task import FARTHEST, TOLERANCES
from arms import physics, state

LOOSE = dict.fromkeys(TOLERANCES, 5.0)
TINY = 1e-6
UNTIL = {"RangeOfMotion": 12.0, "Ratchet": 2.0, "Hammer": 0.6, "ReachPanel": 0.6}  # s
ALWAYS = {"tracking", "effort"}


@pytest.fixture(scope="module", params=TASKS)
def played(request):
    """An episode that goes well by loose tolerances, to where the task first looks at the hand."""
    name = request.param
    task = replace(TASKS[name], duration=UNTIL.get(name, 1.0), **LOOSE)
    env = ArmEnv(task, coupling="none")
    env.reset(seed=2)
    # Something pulls the arm up and hinders it, so that no motion is as intended.
    pull, rate = physics(env, "qfrc_applied"), physics(env, "qvel")
    truncated = False
    while not truncated:
        pull[1:3] = 3.0 - 6.0 * rate[1:3]
        *_, truncated, info = env.step(np.zeros(0))
    return TASKS[name], env, info


def test_an_episode_goes_well_and_each_quantity_that_is_watched_can_spoil_it(played):
    shipped, env, info = played
    assert info["is_success"]
    assert info["cost_terms"]["heat"] == 0
    watched = {name for name in TOLERANCES if getattr(shipped, name) < FARTHEST}
    assert watched >= {"tracking"}
    costs, periods = env.unwrapped.episodes.costs[0], int(state(env).step[0])
    for name in watched:
        strict = replace(env.episodes.task, **{name: TINY})
        assert not is_success(costs, periods, strict, ended=False), name
    assert not is_success(costs, periods, env.episodes.task, ended=True)
    unwatched = set(TOLERANCES) - watched - ALWAYS
    usual = replace(env.episodes.task, **dict.fromkeys(unwatched, FARTHEST))
    assert is_success(costs, periods, usual, ended=False)


def test_costs_of_the_hand_by_hand():
    """Distance, pitch and lacking speed of a hand that hammers, from the joint angles alone."""
    task = replace(TASKS["Hammer"], duration=0.6)
    env = ArmEnv(task, coupling="none")
    env.reset(seed=3)
    arm, dt = env.episodes.simulation.arm_of(0), env.control_dt
    watched, wanted = env.get_state()["watched"][0], state(env).angle[0]
    angle = [env.episodes.info(0)["angle"]]
    for _ in range(60):
        angle.append(env.step(np.zeros(0))[-1]["angle"])
    hand, place = arm.places(np.array(angle)), arm.places(wanted)
    looks = np.flatnonzero(watched)
    looks = looks[looks > 0]
    assert looks.size
    error = np.linalg.norm(hand - place, axis=1)[looks]
    tilt = np.abs((np.array(angle) - wanted)[looks, 1:].sum(axis=1))
    speed, intended = (
        np.linalg.norm(np.diff(path, axis=0), axis=1)[looks - 1] / dt for path in (hand, place)
    )
    costs = env.episodes.info(0)["cost_terms"]
    assert costs["hand_error"] == pytest.approx(error.max(), rel=1e-9)
    assert costs["tilt"] == pytest.approx(tilt.max(), rel=1e-9)
    assert costs["slowness"] == pytest.approx(max(0.0, (1 - speed / intended).max()), rel=1e-9)


def test_costs_of_the_hand_begin_anew_with_each_episode():
    env = ArmEnv(replace(TASKS["OverheadHold"], duration=0.2), coupling="none")
    env.reset(seed=0)
    for _ in range(10):
        info = env.step(np.zeros(0))[-1]
    assert info["cost_terms"]["hand_error"] > 0
    terms = env.reset()[1]["cost_terms"]
    assert terms["hand_error"] == terms["chatter"] == 0
