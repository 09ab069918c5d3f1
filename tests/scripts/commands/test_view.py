"""`activesuit view` and `animate`: what they draw, and one sentence for every mistake."""

import itertools
import re
import socket
import subprocess
import sys
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import mujoco
import numpy as np
import pytest
from activesuit.envs.animation import LoopPanel
from activesuit.envs.evaluation import rollout
from activesuit.envs.making import make_arms
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.policies import make_policy
from activesuit.envs.rendering import Renderer, RenderingUnavailableError
from activesuit.errors import InputError
from activesuit.scripts import browser, output
from activesuit.scripts.commands import animate, view
from activesuit.scripts.film import filmed
from activesuit.scripts.main import main
from helpers import PATIENCE, fails, run, shorten_tasks
from matplotlib.image import imread


@pytest.fixture(scope="module")
def opengl():
    renderer, model = Renderer(camera="front", width=16, height=16), compose(ArmConfig())
    try:
        renderer.picture(model, mujoco.MjData(model))
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    renderer.close()


@pytest.fixture
def short(monkeypatch):
    """For films of whole episodes, which then take 1 s instead of 10 s."""
    shorten_tasks(monkeypatch, 1.0)


@pytest.mark.render
def test_a_snapshot_shows_what_is_asked_for(capsys, tmp_path, opengl):
    pictures = []
    for options in ("", "--pose reach", "--camera cuffs", "--side left", "--payload 9"):
        path = tmp_path / "arm.png"
        small = ["--width", 160, "--height", 120, "--quality", "fast"]
        out = run(capsys, "view", "--snapshot", path, "--force", *small, *options.split())
        assert out == f"wrote {path}\n"
        pictures.append(imread(path)[:, :, :3])
        assert pictures[-1].shape == (120, 160, 3)
    for one, other in itertools.combinations(pictures, 2):
        assert np.abs(one - other).max() > 0.3


@pytest.mark.parametrize("coupling", ["rigid", "cuffs", "none"])
def test_the_browser_gets_the_same_arm_without_plugins(coupling):
    config = ArmConfig(coupling=coupling)
    shown, simulated = view._drawing(config, view.WHOLE), compose(config)
    assert simulated.nplugin > 0
    assert shown.nplugin == 0
    poses = [mujoco.MjData(shown), mujoco.MjData(simulated)]
    for model, data in zip((shown, simulated), poses, strict=True):
        data.qpos[:] = np.linspace(0.1, 0.8, model.nq)
        mujoco.mj_kinematics(model, data)
    np.testing.assert_array_equal(poses[0].geom_xpos, poses[1].geom_xpos)


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
def test_an_animation_is_a_loop(capsys, tmp_path, monkeypatch, opengl):
    monkeypatch.setattr(output, "QUIET", 0.0)
    monkeypatch.chdir(tmp_path)
    small = ["--width", "192", "--height", "120", "--fps", "5"]
    main(["animate", "--out", "arm.gif", *small])
    captured = capsys.readouterr()
    assert captured.out == "wrote arm.gif\n"
    lines = captured.err.splitlines()
    assert sum(line.startswith("pictures: ") for line in lines) == 10
    assert lines[-1].startswith("panels beside the arm: 100 % after ")
    assert [path.name for path in tmp_path.iterdir()] == ["arm.gif"]
    frames = loop(tmp_path / "arm.gif")
    # The other format gets the same pictures, which take long to draw.
    monkeypatch.setattr(animate, "_film", lambda *given: list(frames.astype(np.uint8)))
    assert run(capsys, "animate", "--out", "arm.mp4", *small) == "wrote arm.mp4\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.gif", "arm.mp4"]
    loop(tmp_path / "arm.mp4")
    again = fails(capsys, "animate", "--out", "arm.mp4", *small)
    assert "exists: give another name, or add --force" in again


def loop(path):
    """The pictures of a film whose last one leads to its first one."""
    imageio = pytest.importorskip("imageio.v3")
    frames = np.array(imageio.imread(path, index=None)[..., :3], float)
    assert len(frames) == 30
    assert frames.shape[1:] == (120, 192, 3)
    steps = np.abs(np.diff(frames, axis=0, append=frames[:1])).mean(axis=(1, 2, 3))
    assert steps[-1] < steps.max()
    assert np.abs(frames[8] - frames[0]).mean() > 2 * steps[-1]
    return frames


@pytest.mark.slow
@pytest.mark.render
def test_an_episode_is_filmed_whole(capsys, tmp_path, opengl, short):
    imageio = pytest.importorskip("imageio.v3")
    films = []
    for seed in ("0", "1"):
        out = tmp_path / f"{seed}.gif"
        arguments = ["--env", "ActiveSuit/ElbowFlexion-v0", "--seed", seed, "--out", out]
        run(capsys, "animate", *arguments, "--width", 192, "--height", 120, "--fps", 4)
        films.append(imageio.imread(out, index=None)[..., :3].astype(float))
        assert films[-1].shape == (4, 120, 192, 3)
    assert np.abs(films[0] - films[1]).mean() > 0.5


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize("kind", ["gif", "mp4"])
@pytest.mark.usefixtures("opengl", "short", "undrawn")
def test_simulate_films_in_real_time(capsys, tmp_path, monkeypatch, kind):
    imageio = pytest.importorskip("imageio.v3")
    draw, drawn = Renderer.picture, []

    def move_the_first(renderer, *scene):  # what is on the others is no matter here
        drawn.append(np.roll(drawn[0], len(drawn), axis=1) if drawn else draw(renderer, *scene))
        return drawn[-1]

    monkeypatch.setattr(Renderer, "picture", move_the_first)
    out = run(capsys, "simulate", "--out", tmp_path / "film", "--video", kind)
    assert f"trace.csv, result.json, report.html, motion.{kind} and 4 figures" in out
    film = tmp_path / "film" / f"motion.{kind}"
    frames = imageio.imread(film, index=None)
    assert frames.shape[:3] == (25, 480, 640)
    reported = imageio.immeta(film)
    assert reported["duration"] == pytest.approx(1 if kind == "mp4" else 40, rel=0.01)  # s; ms each


@pytest.mark.slow
@pytest.mark.render
def test_filming_changes_nothing(opengl, short):
    small = {"render_mode": "rgb_array", "width": 40, "height": 30}
    arms = make_arms("ActiveSuit/ElbowFlexion-v0", 1, **small)
    policy = make_policy("feedforward", arms)
    with filmed(arms, 20) as film:
        (one,) = rollout(arms, policy, [0], on_step=film)
    assert film.steps == [*range(0, 100, 20)]
    assert len(film.pictures) == len(film.steps)
    (other,) = rollout(arms, policy, [0])
    for name in ("angle", "human_torque", "rewards"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    arms.close()


def test_mp4_without_its_extra_is_one_sentence(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for command in (["animate", "--out", "arm.mp4"], ["simulate", "--video", "mp4"]):
        monkeypatch.chdir(tmp_path)
        assert "needs the extra activesuit[video]" in fails(capsys, *command)
    assert list(tmp_path.iterdir()) == []


def test_a_snapshot_replaces_nothing_unasked(capsys, tmp_path, opengl):
    path = tmp_path / "arm.png"
    path.write_text("mine")
    small = ["--width", "40", "--height", "30", "--quality", "fast"]
    arguments = ["view", "--snapshot", str(path), *small]
    assert "exists: give another name, or add --force" in fails(capsys, *arguments)
    assert path.read_text() == "mine"
    run(capsys, *arguments, "--force")
    assert imread(path).shape[:2] == (30, 40)


@pytest.mark.slow
@pytest.mark.parametrize("host", ["localhost", "0.0.0.0"])
def test_the_web_page_listens_on_its_address_and_asks_for_the_token(host):
    port = free_port()
    serve = f"from activesuit.scripts.browser import served; served({host!r}, {port}); input()"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    # A process can have one viewer only.
    with subprocess.Popen([sys.executable, "-uc", serve], **pipes) as viewer:
        try:
            line = next(line for line in viewer.stdout if line.startswith("open http://"))
            address, token = re.search(r"(http://\S+:\d+)/\?token=(\S+)", line).groups()
            assert address.endswith(f":{port}")
            # Another address of this machine, as far as a listener is concerned.
            assert answers("127.0.0.2", port) == (host == "0.0.0.0")
            ours, foreign = f"localhost:{port}", "evil.example"
            assert asked(port, "/", Host=ours)[0] == 403
            assert asked(port, f"/?token={token}", Host=foreign)[0] == 403
            foreign_page = {"Host": ours, "Origin": f"http://{foreign}"}
            assert asked(port, f"/?token={token}", **foreign_page)[0] == 403
            status, page, cookie = asked(port, f"/?token={token}", Host=ours)
            assert (status, "<html" in page.lower()) == (200, True)
            cookie = {"Cookie": cookie.split(";")[0]}
            assert asked(port, "/web_client.js", Host=ours, **cookie)[0] == 200
            assert asked(port, "/web_client.js", Host=ours)[0] == 403
            socket_of_page = {"Host": ours, **cookie, "Origin": f"http://{ours}", **UPGRADE}
            assert asked(port, "/state?sid=1", **socket_of_page)[0] == 101
            assert asked(port, "/drop?sid=1", **socket_of_page)[0] == 403
            socket_of_page["Origin"] = "http://localhost:3000"
            assert asked(port, "/state?sid=1", **socket_of_page)[0] == 403
        finally:
            viewer.kill()


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def asked(port, path, **headers):
    """Status, text and cookie of the answer to a request with exactly these header fields."""
    connection = HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    connection.putrequest("GET", path, skip_host=True, skip_accept_encoding=True)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    text = "" if answer.status == 101 else answer.read().decode(errors="replace")
    connection.close()
    return answer.status, text, answer.getheader("Set-Cookie")


class AnswersEveryone(BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.end_headers()


def test_a_viewer_that_answers_everyone_is_not_announced():
    with HTTPServer(("127.0.0.1", 0), AnswersEveryone) as server:
        Thread(target=server.handle_request, daemon=True).start()
        with pytest.raises(InputError, match="answers requests without a token"):
            browser._check_locked("localhost", server.socket)
    with socket.create_server(("0.0.0.0", 0)) as open_to_all:
        with pytest.raises(InputError, match="does not listen on localhost alone"):
            browser._check_locked("localhost", open_to_all)


def test_a_taken_port_is_one_sentence(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        message = fails(capsys, "view", "--web", "--port", str(port))
    assert f"'localhost', port {port} (Address already in use)" in message


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as trial:
        return trial.getsockname()[1]


def answers(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=PATIENCE).close()
    except OSError:
        return False
    return True
