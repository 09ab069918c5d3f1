"""Pictures and videos of an arm that moves, also where there is no OpenGL."""

import itertools
import pickle

import gymnasium
import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig
from activesuit.envs.rendering import ArmRenderer, RenderingUnavailableError
from arms import go_on
from helpers import assert_refused

pytestmark = pytest.mark.render
ID = "ActiveSuit/ElbowFlexion-v0"


def arm_env(camera="side", **options):
    made = gymnasium.make(ID, render_mode="rgb_array", camera=camera, **options)
    made.reset(seed=0)
    return made.unwrapped


@pytest.fixture
def env():
    made = arm_env()
    try:
        made.render()
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    yield made
    made.close()


def test_pictures_show_the_motion(env):
    first = env.render()
    assert (first.shape, first.dtype) == ((480, 640, 3), np.uint8)
    assert first.std() > 20
    go_on(env, 100)
    assert np.abs(env.render().astype(int) - first).mean() > 0.5


@pytest.mark.slow
def test_two_videos_and_a_pickle(env):
    first = env.render()
    again = pickle.loads(pickle.dumps(env))  # the OpenGL context stays behind
    assert np.abs(again.render().astype(int) - first).max() < 8
    again.close()
    env.close()
    env.close()
    env.reset(seed=0)
    assert env.render().std() > 20


def test_no_opengl_is_one_sentence(env, monkeypatch):
    def fail(*arguments):
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", fail)
    monkeypatch.setattr(ArmRenderer, "_unavailable", None)
    renderer = ArmRenderer(ArmConfig(), None, "front", 64, 48)
    posture = env.episodes.simulation.posture_of(0)
    # No second attempt: it could abort the process.
    assert_refused(renderer.picture, [(posture, "MUJOCO_GL=egl"), (posture, "no display")])
    renderer.close()
    monkeypatch.setattr(ArmRenderer, "_unavailable", None)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert_refused(renderer.show, [(posture, 0.01, "rgb_array")])
    message = "unknown camera 'top': use one of cuffs, elbow, follow"
    assert_refused(arm_env(camera="top").render, [(message,)])


@pytest.mark.slow
def test_usual_pictures_have_neither_shadows_nor_samples():
    small = {"width": 160, "height": 120}
    usual, fine = arm_env(**small), arm_env(**small, render_quality="fine")
    pictures = [arm.render().astype(int) for arm in (usual, fine)]
    assert np.abs(pictures[0] - pictures[1]).mean() > 0.1
    contexts = [arm.renderer._offscreen._mjr_context for arm in (usual, fine)]
    sizes = [(context.shadowSize, context.offSamples > 0) for context in contexts]
    assert sizes == [(0, False), (4096, True)]
    usual.close()
    fine.close()


@pytest.mark.slow
def test_pictures_repeat_within_their_time_only(env):
    arm = arm_env(picture_dt=0.04, width=80, height=60)
    arm.reset(seed=0)
    pictures = [arm.render()]
    for _ in range(40):
        arm.step(np.zeros(2, np.float32))
        pictures.append(arm.render())
    same = [np.array_equal(*pair) for pair in itertools.pairwise(pictures)]
    assert same[10:] == [i % 4 != 3 for i in range(10, 40)]
    state = arm.get_state()
    arm.reset(seed=1)
    assert not np.array_equal(arm.render(), pictures[-1])
    arm.set_state(state)
    np.testing.assert_array_equal(arm.render(), pictures[-1])
    pictures[-1][:] = 0
    assert arm.render().any()
    arm.close()


@pytest.mark.slow
def test_a_recorded_video_plays_in_real_time(env, tmp_path):
    pytest.importorskip("moviepy")
    imageio = pytest.importorskip("imageio.v3")
    small = {"width": 160, "height": 120, "picture_dt": 0.04}
    made = gymnasium.make(ID, render_mode="rgb_array", **small)
    recorder = gymnasium.wrappers.RecordVideo(made, str(tmp_path / "films"))
    recorder.reset(seed=0)
    go_on(recorder, 100)
    recorder.close()
    (film,) = (tmp_path / "films").iterdir()
    assert imageio.immeta(film, plugin="FFMPEG")["duration"] == pytest.approx(1.01, abs=0.02)
    frames = imageio.imread(film, plugin="FFMPEG")
    assert frames.shape == (101, 120, 160, 3)
    assert np.abs(frames[-1].astype(int) - frames[0]).mean() > 0.5
