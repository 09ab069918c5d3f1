import pickle

import gymnasium
import numpy as np
import pytest
from activesuit.envs.rendering import Renderer, RenderingUnavailableError
from activesuit.errors import InputError

pytestmark = pytest.mark.render


@pytest.fixture
def env():
    made = gymnasium.make("ActiveSuit/ElbowFlexion-v0", render_mode="rgb_array", camera="side")
    try:
        made.reset(seed=0)
        made.render()
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    yield made
    made.close()


def test_pictures_show_the_motion(env):
    first = env.render()
    assert first.shape == (480, 640, 3)
    assert first.dtype == np.uint8
    assert first.std() > 20
    for _ in range(100):
        env.step(np.zeros(2, np.float32))
    assert np.abs(env.render().astype(int) - first).mean() > 0.5


def test_two_videos_and_a_pickle(env):
    arm = env.unwrapped
    first = env.render()
    again = pickle.loads(pickle.dumps(arm))  # the OpenGL context stays behind
    assert np.abs(again.render().astype(int) - first).max() < 8
    again.close()
    env.close()
    env.close()
    env.reset(seed=0)
    assert env.render().std() > 20


def test_unknown_camera():
    made = gymnasium.make("ActiveSuit/ElbowFlexion-v0", render_mode="rgb_array", camera="top")
    made.reset(seed=0)
    with pytest.raises(InputError, match="unknown camera 'top': use one of cuffs, elbow, follow"):
        made.render()


def test_no_opengl_is_one_sentence(env, monkeypatch):
    import mujoco

    def fail(*arguments):
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", fail)
    monkeypatch.setattr(Renderer, "_unavailable", None)
    arm = env.unwrapped
    renderer = Renderer(camera="front", width=64, height=48)
    with pytest.raises(RenderingUnavailableError, match="MUJOCO_GL=egl"):
        renderer.picture(arm.model, arm.data)
    with pytest.raises(RenderingUnavailableError, match="no display"):
        renderer.picture(arm.model, arm.data)  # no second attempt: it could abort the process
    renderer.close()
    monkeypatch.setattr(Renderer, "_unavailable", None)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(RenderingUnavailableError, match="rgb_array"):
        renderer.show(arm.model, arm.data, 0.01)
