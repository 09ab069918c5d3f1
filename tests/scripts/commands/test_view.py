"""`activesuit view` and `animate`: what they draw, and one sentence for every mistake."""

import itertools
import sys

import mujoco
import numpy as np
import pytest
from activesuit.envs.animation import LoopPanel
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.rendering import Renderer, RenderingUnavailableError
from activesuit.scripts.commands import animate, view
from activesuit.scripts.main import main
from matplotlib.image import imread


def run(capsys, *arguments) -> str:
    main([str(argument) for argument in arguments])
    return capsys.readouterr().out


@pytest.fixture
def opengl():
    renderer, model = Renderer(camera="front", width=16, height=16), compose(ArmConfig())
    try:
        renderer.picture(model, mujoco.MjData(model))
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    renderer.close()


@pytest.fixture
def no_display(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.render
def test_a_snapshot_shows_what_is_asked_for(capsys, tmp_path, opengl):
    pictures = []
    for options in ("", "--pose reach", "--camera cuffs", "--side left", "--payload 9"):
        path = tmp_path / "arm.png"
        size = ["--width", 160, "--height", 120]
        out = run(capsys, "view", "--snapshot", path, *size, *options.split())
        assert out == f"wrote {path}\n"
        pictures.append(imread(path)[:, :, :3])
        assert pictures[-1].shape == (120, 160, 3)
    for one, other in itertools.combinations(pictures, 2):
        assert np.abs(one - other).max() > 0.3


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--snapshot", "arm.jpg"], "snapshot is 'arm.jpg': use a name that ends with .png"),
        (["--snapshot", "arm.png", "--web"], "both web and snapshot are given: use one of them"),
        (["--snapshot", "arm.png", "--pose", "sit"], "unknown pose 'sit': use one of home, reach"),
        (["--snapshot", "arm.png", "--width", "0"], "the picture size is 0 x 960"),
        (["--snapshot", "arm.png", "--height", "9999"], "height is 9999: use 1 to 4096 pixels"),
        (["--snapshot", "no/arm.png"], "cannot write 'no/arm.png'"),
        (["--coupling", "glue"], "unknown coupling 'glue'"),
        (["--policy", "magic"], "unknown policy 'magic'"),
        (["--seed", "-1"], "seed is -1: use at least 0"),
        ([], "no window can be opened here: use --snapshot FILE.png for a picture, or --web"),
    ],
)
def test_mistakes_of_view(capsys, tmp_path, monkeypatch, no_display, arguments, sentence):
    monkeypatch.chdir(tmp_path)
    assert sentence in mistake(capsys, "view", *arguments)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--out", "arm.avi"], "out is 'arm.avi': use a name that ends with .gif or .mp4"),
        (["--out", "no/arm.gif"], "cannot write 'no/arm.gif'"),
        (["--policy", "magic"], "unknown policy 'magic'"),
        (["--gravity", "sun"], "unknown gravity 'sun'"),
        (["--camera", "top"], "unknown camera 'top'"),
    ],
)
def test_mistakes_of_animate(capsys, tmp_path, monkeypatch, arguments, sentence):
    monkeypatch.chdir(tmp_path)
    assert sentence in mistake(capsys, "animate", *arguments)
    assert list(tmp_path.iterdir()) == []


def mistake(capsys, *arguments) -> str:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    assert stop.value.code == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    message = captured.err.strip().splitlines()[-1]
    assert message.startswith("activesuit: error: ")
    return message


@pytest.mark.parametrize("coupling", ["rigid", "cuffs", "none"])
def test_the_browser_gets_the_same_arm_without_plugins(coupling):
    config = ArmConfig(coupling=coupling)
    shown, simulated = view._drawing(config), compose(config)
    assert simulated.nplugin > 0
    assert shown.nplugin == 0
    poses = [mujoco.MjData(shown), mujoco.MjData(simulated)]
    for model, data in zip((shown, simulated), poses, strict=True):
        data.qpos[:] = np.linspace(0.1, 0.8, model.nq)
        mujoco.mj_kinematics(model, data)
    np.testing.assert_array_equal(poses[0].geom_xpos, poses[1].geom_xpos)


def test_the_intended_motion_is_smooth_and_periodic():
    time = np.linspace(0, animate.PERIOD, 6001)
    for turns in animate.TURNS.values():
        angle, rate, acceleration = animate._periodic(time, turns)
        np.testing.assert_allclose(angle[0], angle[-1], atol=1e-12)
        np.testing.assert_allclose(np.gradient(angle, time)[1:-1], rate[1:-1], atol=1e-4)
        np.testing.assert_allclose(np.gradient(rate, time)[1:-1], acceleration[1:-1], atol=2e-2)
        phases, stops = zip(*turns, strict=True)
        at_turns = animate._periodic(np.array(phases) * animate.PERIOD, turns)
        np.testing.assert_allclose(at_turns[0], stops, atol=1e-12)
        np.testing.assert_allclose(at_turns[1:], 0, atol=1e-9)


def test_the_panel_moves_with_the_cycle_and_closes_it():
    phase = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    angle, torque = np.tile(np.cos(phase), (4, 1)).T, np.tile(5 * np.sin(phase), (4, 1)).T
    panel = LoopPanel(angle, torque, 0 * torque, width=200, height=300)
    first, later = panel.picture(0).astype(int), panel.picture(50)
    assert first.shape == (300, 200, 3)
    assert np.abs(first - later).max() > 100
    np.testing.assert_array_equal(panel.picture(100), first)


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize("name", ["arm.gif", "arm.mp4"])
def test_an_animation_is_a_loop(capsys, tmp_path, monkeypatch, opengl, name):
    imageio = pytest.importorskip("imageio.v3")
    small = {"ARM_WIDTH": 112, "PANEL_WIDTH": 80, "HEIGHT": 108, "SHADOWS": 16}
    for constant, value in {**small, "FPS": 5, "STRIDE": 20}.items():
        monkeypatch.setattr(animate, constant, value)
    run(capsys, "animate", "--out", tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    frames = np.array(imageio.imread(tmp_path / name, index=None)[..., :3], float)
    assert len(frames) == 30
    assert frames.shape[1:] == (108, 192, 3)
    steps = np.abs(np.diff(frames, axis=0, append=frames[:1])).mean(axis=(1, 2, 3))
    assert steps[-1] < steps.max()
    assert np.abs(frames[8] - frames[0]).mean() > 2 * steps[-1]


def test_mp4_without_its_extra_is_one_sentence(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    message = mistake(capsys, "animate", "--out", str(tmp_path / "arm.mp4"))
    assert "needs the extra activesuit[video]" in message
    assert list(tmp_path.iterdir()) == []
