"""`activesuit view`: what it draws, as a film or as a picture."""

import itertools
import sys

import numpy as np
import pytest
from activesuit.envs.animation import LoopPanel
from activesuit.envs.arm_env import ArmEnv
from activesuit.envs.rendering import RenderingUnavailableError
from helpers import fails, run, shorten_tasks
from matplotlib.image import imread


@pytest.fixture(scope="module")
def opengl():
    env = ArmEnv("ElbowFlexion", render_mode="rgb_array", width=16, height=16)
    try:
        env.render()
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    env.close()


@pytest.mark.render
def test_a_snapshot_shows_what_is_asked_for(capsys, tmp_path, opengl):
    pictures = []
    for options in ("", "--task Ratchet", "--camera cuffs", "--side left", "--payload 9"):
        path = tmp_path / "arm.png"
        small = ["--size", 160, 120, "--quality", "fast"]
        out = run(capsys, "view", "--snapshot", path, "--force", *small, *options.split())
        assert out == f"wrote {path}\n"
        pictures.append(imread(path)[:, :, :3])
        assert pictures[-1].shape == (120, 160, 3)
    for one, other in itertools.combinations(pictures, 2):
        assert np.abs(one - other).max() > 0.3


def test_the_panel_moves_with_the_motion():
    phase = np.linspace(0, 2 * np.pi, 100)
    angle, torque = np.tile(np.cos(phase), (4, 1)).T, np.tile(5 * np.sin(phase), (4, 1)).T
    panel = LoopPanel(angle, torque, 0 * torque, width=200, height=300)
    first, later = panel.picture(0).astype(int), panel.picture(50)
    assert first.shape == (300, 200, 3)
    assert np.abs(first - later).max() > 100


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize("kind", ["gif", "mp4"])
def test_an_episode_is_filmed_whole_in_real_time(capsys, tmp_path, opengl, monkeypatch, kind):
    shorten_tasks(monkeypatch, 1.0)
    imageio = pytest.importorskip("imageio.v3")
    films = []
    for seed in ("0", "1"):
        out = tmp_path / f"{seed}.{kind}"
        arguments = ["--task", "ElbowFlexion", "--seed", seed, "--film", out]
        assert run(capsys, "view", *arguments, "--size", 192, 120) == f"wrote {out}\n"
        films.append(imageio.imread(out, index=None)[..., :3].astype(float))
        assert films[-1].shape == (26, 120, 192, 3)
    assert np.abs(films[0] - films[1]).mean() > 0.5
    duration = imageio.immeta(out)["duration"]  # s; ms each
    assert duration == pytest.approx(1.04 if kind == "mp4" else 40, rel=0.01)


def test_mp4_without_its_extra_is_one_sentence(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.chdir(tmp_path)
    assert "needs the extra activesuit[video]" in fails(capsys, "view", "--film", "arm.mp4")
    assert list(tmp_path.iterdir()) == []


def test_a_snapshot_replaces_nothing_unasked(capsys, tmp_path, opengl):
    path = tmp_path / "arm.png"
    path.write_text("mine")
    small = ["--size", "160", "120", "--quality", "fast"]
    arguments = ["view", "--snapshot", str(path), *small]
    assert "exists: give another name, or add --force" in fails(capsys, *arguments)
    assert path.read_text() == "mine"
    run(capsys, *arguments, "--force")
    assert imread(path).shape[:2] == (120, 160)
