"""The elbow that muscles move: Gymnasium's checks, tracking, assistance, pushes and bad input."""

import activesuit.envs.muscles  # noqa: F401, registers the environment
import gymnasium
import mujoco
import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.muscles.elbow import PEAK, MuscleElbow
from gymnasium.utils.env_checker import check_env
from helpers import assert_refused


def run(action=lambda env: 0.0, steps=150, **options):
    env = MuscleElbow(**options)
    env.reset(seed=0)
    found = []
    for _ in range(steps):
        observation, reward, _, _, info = env.step(np.array([action(env)], np.float32))
        active = np.sqrt(np.mean(np.square(list(info["activation"].values()))))
        error = info["target_angle"] - observation[0]
        found.append((error, active, reward, info["reserve_torque"]))
    return np.array(found), env


@pytest.mark.filterwarnings("ignore:.*infinity.*")
def test_gymnasium_accepts_it_and_a_seed_is_a_motion():
    env = gymnasium.make("ActiveSuit/MuscleElbow-v0").unwrapped
    check_env(env, skip_render_check=True)
    first, again, other = (env.reset(seed=seed)[0] for seed in (1, 1, 2))
    assert np.array_equal(first, again) and not np.array_equal(first, other)


def test_muscles_follow_the_intention():
    for options in ({"suit": "none", "gravity": "microgravity"}, {}, {"suit": "emu-like"}):
        found, _ = run(**options)
        assert np.abs(found[:, 0]).max() < 0.1
        assert np.abs(found[:, 3]).max() < 1e-3


def test_a_motor_that_cancels_the_suit_relieves_the_muscles():
    def cancel(env):
        return -env.data.sensor("elbow_flexion_r_suit_torque").data[0] / PEAK

    place, active = {"gravity": "microgravity", "contraction": 0.0}, []
    for suit, action in (("none", {}), ("emu-like", {}), ("emu-like", {"action": cancel})):
        active.append(run(suit=suit, **place, **action)[0][20:, 1].mean())
    bare, alone, helped = active
    assert helped < 0.5 * alone and bare < 0.5 * alone


def test_contraction_makes_antagonists_work_and_costs_reward():
    found = [run(contraction=contraction)[0] for contraction in (0.0, 3.0, 10.0)]
    active = [one[50:, 1].mean() for one in found]
    assert active[0] < active[1] < active[2]
    assert found[0][50:, 2].mean() > found[2][50:, 2].mean()


def test_a_push_moves_the_elbow_and_the_wearer_comes_back():
    options = {"suit": "none", "gravity": "microgravity"}
    still, pushed = (run(steps=250, push=push, **options)[0][:, 0] for push in (0.0, 2.0))
    away = np.abs(pushed - still)
    assert away[:100].max() == 0 and 0.1 < away.max() < 0.5
    assert away[-10:].max() < 0.3 * away.max()


def test_stiffness_is_the_slope_of_torque():
    _, env = run(steps=30)
    slope = env.stiffness()
    data, angle = env.data, float(env.data.qpos[0])
    torque = []
    for step in (-1e-3, 1e-3):
        data.qpos[0], data.qvel[0] = angle + step, 0
        mujoco.mj_forward(env.model, data)
        torque.append(float(data.qfrc_actuator[0]))
    assert slope == pytest.approx((torque[0] - torque[1]) / 2e-3, rel=1e-3, abs=1e-3)


def test_bad_input():
    rows = [
        ({"suit": "emu"}, "emu"),
        ({"gravity": "venus"}, "venus"),
        ({"contraction": -1}, "contraction is -1: use a number from 0 to 15 N·m"),
        ({"contraction": "much"}, "contraction is 'much'"),
        ({"push": np.nan}, "push is nan"),
    ]
    assert_refused(lambda options: MuscleElbow(**options), rows)
    row = ("ActiveSuit/MuscleElbow-v0", ["none"], "is no arm of ActiveSuit")
    assert_refused(evaluate, [row])
