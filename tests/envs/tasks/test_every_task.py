"""What every task can do on every coupling and level, and when it has gone well."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.interface.reward import is_success
from activesuit.envs.tasks import TASKS
from activesuit.envs.tasks.task import FARTHEST, TOLERANCES
from arms import assert_same_states, go_on, physics, state
from gymnasium.utils.env_checker import check_env
from scipy.stats import qmc

# What learners meet: representative couplings, levels and observations.
LEARNED = [
    ("ArmTracking", {"level": "shift", "history": 3}),
    ("ElbowFlexion", {"sensors": ["encoders", "preview", "privileged"], "normalize": True}),
    ("Scoop", {"coupling": "cuffs", "level": "randomized", "sensors": ["encoders", "cuffs"]}),
    ("Handrail", {"sensors": ["encoders", "interaction", "emg"], "level": "faults"}),
    ("Hammer", {"exo": {"encoder_delay": 0.02}, "fatigue": True}),
    ("Ratchet", {"control": {"noise": 1.0, "tremor": 0.05, "contraction": 2.0}}),
]
OTHERS = [("rigid", "shift"), ("none", "randomized"), ("cuffs", "nominal"), ("rigid", "faults")]
# Cuffs at the level "randomized" have all parts that can go wrong. The other arms take turns.
COMBINATIONS = [
    *((name, "cuffs", "randomized") for name in TASKS),
    *(
        pytest.param((name, *OTHERS[i % len(OTHERS)]), marks=pytest.mark.slow)
        for i, name in enumerate(TASKS)
    ),
]
DURATION = 5.0  # s
ROWS = 3


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", TASKS)
def test_gymnasium_accepts_it(name):
    check_env(gymnasium.make(f"ActiveSuit/{name}-v0").unwrapped, skip_render_check=True)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("name", "options"), LEARNED, ids=[name for name, _ in LEARNED])
def test_both_checkers_accept_what_learners_meet(name, options):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = ArmEnv(name, **options)
    checker.check_env(env, warn=True, skip_render_check=True)
    check_env(env, skip_render_check=True)


@pytest.fixture(scope="module", params=COMBINATIONS, ids=str)
def made(request):
    """An environment of one task, coupling and level, which tests of it share."""
    name, coupling, level = request.param
    env = ArmEnv(replace(TASKS[name], duration=DURATION), coupling=coupling, level=level)
    arms = env.rows(ROWS, threads=1)
    env.reset(seed=0)
    return env, arms


def test_noise_breaks_nothing(made):
    env, _ = made
    motors = env.action_space.shape[0]
    periods = round(DURATION / env.control_dt)
    noise = 2 * qmc.Halton(max(1, motors), seed=0).random(periods)[:, :motors] - 1
    env.reset(seed=7)
    rewards = [env.step(action)[1] for action in noise]
    assert not env.episodes.simulation.batch.warning[..., 1].any()
    assert not state(env).diverged.any() and env.episodes.truncated.all()
    assert np.isfinite(rewards).all()
    assert np.isfinite(state(env).measured).all()


def until_loaded(env, arms, rng):
    """Plays until a load is in the hand, or for half a second where there never is one."""
    motors = env.action_space.shape
    for period in range(350):
        if period == 50 and not env.episodes.task.carries:
            break
        load = state(env).load[0]
        if period > 50 and load != state(env).carried[0].min():
            break
        actions = rng.uniform(-0.3, 0.3, (ROWS, *motors))
        answers = env.step(actions[1]), arms.step(actions)
    return answers


def test_a_row_is_the_single_environment_and_states_in_mid_task_go_on_alike(made):
    (env, arms), rng = made, np.random.default_rng(4)
    env.reset(seed=31)
    arms.reset(seed=30)
    one, rows = until_loaded(env, arms, rng)
    for alone, row in zip(one[:4], rows[:4], strict=True):
        np.testing.assert_array_equal(alone, row[1])
    state = env.get_state()
    assert_same_states(state, arms.get_state(rows=[1]))
    if env.episodes.task.carries:
        assert state["load"][0] > 0
    actions = rng.uniform(-0.3, 0.3, (30, *env.action_space.shape))
    first = [env.step(action)[0] for action in actions]
    after = env.get_state()
    env.reset(seed=1)
    env.set_state(state)
    again = [env.step(action)[0] for action in actions]
    np.testing.assert_array_equal(again, first)
    assert_same_states(env.get_state(), after)
    arms.reset(seed=2)
    arms.set_state(state, rows=[2])  # another environment, and another row
    third = [arms.step(np.tile(action, (ROWS, 1)))[0][2] for action in actions]
    np.testing.assert_array_equal(third, first)
    assert_same_states(arms.get_state(rows=[2]), after)


LOOSE = dict.fromkeys(TOLERANCES, 5.0)
UNTIL = {  # s
    **{"RangeOfMotion": 12.0, "Ratchet": 2.6, "Hammer": 1.8, "ReachPanel": 0.6},
    **{"Handrail": 5.0, "Scoop": 4.0},
}


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
    assert info["is_success"] and info["cost_terms"]["heat"] == 0
    watched = {name for name in TOLERANCES if getattr(shipped, name) < FARTHEST}
    assert watched >= {"tracking"}
    costs, periods = env.unwrapped.episodes.costs[0], int(state(env).step[0])
    for name in watched:
        strict = replace(env.episodes.task, **{name: 1e-6})
        assert not is_success(costs, periods, strict, ended=False), name
    assert not is_success(costs, periods, env.episodes.task, ended=True)
    unwatched = set(TOLERANCES) - watched - {"tracking", "effort"}
    usual = replace(env.episodes.task, **dict.fromkeys(unwatched, FARTHEST))
    assert is_success(costs, periods, usual, ended=False)


def test_costs_of_the_hand_by_hand():
    """Distance, pitch and lacking speed of a hand that hammers, from the joint angles alone."""
    task = replace(TASKS["Hammer"], duration=0.6, wait=(0.0, 0.0))
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
    assert go_on(env, 10)[-1]["cost_terms"]["hand_error"] > 0
    terms = env.reset()[1]["cost_terms"]
    assert terms["hand_error"] == terms["chatter"] == 0
