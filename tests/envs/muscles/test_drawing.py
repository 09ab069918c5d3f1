"""Muscles beside an arm that moves, and the elbow that muscles move."""

from contextlib import nullcontext
from itertools import pairwise

import activesuit.envs.muscles  # noqa: F401, registers the environment
import gymnasium
import mujoco
import mujoco.viewer
import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate, rollout
from activesuit.envs.making import make_arms, make_env
from activesuit.envs.muscles import MyoArm, muscle_activation
from activesuit.envs.muscles.drawing import BESIDE, LiveMuscles, color_of, width_of
from activesuit.envs.muscles.elbow import PEAK, MuscleElbow
from activesuit.envs.plant import Plant
from activesuit.envs.policies import NoAssist
from arms import go_on
from gymnasium.utils.env_checker import check_env
from helpers import assert_refused

TASK = "ActiveSuit/ElbowFlexion-v0"
BONES = 3


def moved(steps=5, **options):
    """An arm after some control periods without torque, and its muscles."""
    _, env = make_env(TASK, gravity="earth", **options)
    live = LiveMuscles(env.episodes.simulation)
    env.reset(seed=0)
    live()
    for _ in range(steps):
        env.step(np.zeros(2))
        live()
    return env, live


@pytest.mark.parametrize("stature", [1.65, 1.85])
@pytest.mark.parametrize("side", ["right", "left"])
def test_the_bones_stand_beside_the_arm_in_its_posture(side, stature):
    env, live = moved(side=side, wearer={"stature": stature})
    bones = live()[:BONES]
    places = np.array([bones[0].begin, *(bone.end for bone in bones)])
    outward = -1 if side == "right" else 1
    places[:, 1] -= outward * BESIDE[1]
    ours = np.array([env.data.body(name).xpos for name in ("upper_arm", "forearm", "hand")])
    np.testing.assert_allclose(places[0], ours[0], atol=1e-9)
    assert np.linalg.norm(places[1] - ours[1]) < 0.015
    assert np.linalg.norm(places[2] - ours[2]) < 0.09  # MyoArm has a carrying angle
    assert all((one.end == other.begin).all() for one, other in pairwise(bones))


def test_each_muscle_has_its_color_width_and_length(monkeypatch):
    """Length, but for the scale, and for where a tendon lies on a bone and is drawn as a chord."""
    _, live = moved()
    known = np.linspace(0, 1, 32)
    monkeypatch.setattr(live, "activation", lambda: known)
    muscles = live()[BONES:]
    scale = np.linalg.norm(live()[0].end - live()[0].begin) / live._upper_arm
    colors = np.array([one.color for one in muscles])
    assert {tuple(color) for color in colors} == {tuple(color) for color in color_of(known)}
    for name, active in zip(MyoArm.load().muscles, known, strict=True):
        mine = [one for one in muscles if (one.color == color_of(active)).all()]
        drawn = sum(np.linalg.norm(one.end - one.begin) for one in mine) / scale
        tendon = live._arm.model.actuator(name).trnid[0]
        assert drawn == pytest.approx(live._data.ten_length[tendon], rel=0.05), name
        assert {one.radius for one in mine} == {float(width_of(active))}
        assert all((one.end == other.begin).all() for one, other in pairwise(mine))  # a path
    assert color_of(0.0)[1] > 0.8 and color_of(1.0)[1] < 0.2  # pale, dark red
    data = live._data
    assert len(muscles) == data.ten_wrapnum.sum() - len(known)


def test_the_activation_is_that_of_the_whole_motion():
    arms = make_arms(TASK, 1, gravity="earth", max_episode_steps=60)
    live, found = LiveMuscles(arms.episodes.simulation), []

    class Watching(NoAssist):
        def torque(self, seen):
            found.append(live.activation())
            return super().torque(seen)

    (trace,) = rollout(arms, Watching(Plant.of(arms.episodes)), [0])
    expected = muscle_activation(trace)
    assert found[0] is None and found[2] is None  # before the first period, and after two
    lately = np.array(found[3:])  # a policy acts before a period
    assert len(lately) == 57
    difference = np.abs(lately - expected[2:-1])
    assert expected.max() > 0.2 and difference[10:].max() < 0.03


def test_a_new_motion_begins_without_muscles():
    env, live = moved()
    assert live.activation() is not None
    assert live.activation() is live.activation()  # while the arm is paused
    env.reset(seed=1)
    assert live() == []
    assert_refused(lambda: moved(fatigue=True), [("a wearer who does not tire",)])


class Window(nullcontext):
    """What `launch_passive` returns, without a display."""

    def __init__(self, model, data):
        super().__init__()
        self.user_scn, self.cam = mujoco.MjvScene(model, 1000), mujoco.MjvCamera()
        self.lock, self.is_running, self.close = lambda: self, lambda: True, lambda: None
        self.shown = []

    def sync(self):
        scene = self.user_scn
        self.shown.append([(*g.size[:1], *g.rgba) for g in scene.geoms[: scene.ngeom]])


def test_a_window_shows_them(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(mujoco.viewer, "launch_passive", Window)
    _, env = make_env(TASK, render_mode="human", control_dt=0.01)
    env.renderer.beside = LiveMuscles(env.episodes.simulation)
    env.reset(seed=0)
    go_on(env, 3)
    shown = env.renderer._window.shown
    assert [len(one) > 0 for one in shown] == [False, False, False, True]
    expected = [(one.radius, *one.color) for one in env.renderer.beside()]
    np.testing.assert_allclose(shown[-1], expected, atol=1e-6)
    env.close()


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
