"""Muscles beside an arm that moves: their places, colors and activation, and bad input."""

from contextlib import nullcontext
from itertools import pairwise

import mujoco
import mujoco.viewer
import numpy as np
import pytest
from activesuit.envs.evaluation import rollout
from activesuit.envs.making import make_arms, make_env
from activesuit.envs.muscles import MyoArm, muscle_activation
from activesuit.envs.muscles.drawing import BESIDE, LiveMuscles, color_of, width_of
from activesuit.envs.plant import Plant
from activesuit.envs.policies import NoAssist
from arms import go_on
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
