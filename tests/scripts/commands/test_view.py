"""`activesuit view`: what it draws, and who may see the page in the browser."""

import itertools
import re
import socket
import subprocess
import sys
from contextlib import nullcontext
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from activesuit.envs.animation import LoopPanel
from activesuit.envs.model import ArmConfig, compose
from activesuit.envs.rendering import Capsule, Renderer, RenderingUnavailableError
from activesuit.errors import InputError
from activesuit.scripts import browser
from activesuit.scripts.commands import view
from activesuit.scripts.main import main
from helpers import PATIENCE, fails, run, shorten_tasks
from matplotlib.image import imread
from websockets.datastructures import Headers


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
    for options in ("", "--task Ratchet", "--camera cuffs", "--side left", "--payload 9"):
        path = tmp_path / "arm.png"
        small = ["--size", 160, 120, "--quality", "fast"]
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
def test_an_episode_is_filmed_whole_in_real_time(capsys, tmp_path, opengl, short, kind):
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
            ours = f"localhost:{port}"
            assert asked(port, "/", Host=ours)[0] == 403
            foreign_page = {"Host": ours, "Origin": "http://evil.example"}
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


ACCESS = browser.WebAccess()
OWN = {"Host": "localhost:8080"}
TOKEN = {"Cookie": f"a=b; {ACCESS.cookie(8080).split(';')[0]}"}


@pytest.mark.parametrize(
    ("path", "given", "sentence"),
    [
        ("/?token=TOKEN", OWN, None),
        ("/state?sid=1", {**OWN, **TOKEN, "Origin": "http://localhost:8080"}, None),
        ("/", OWN, "token is missing"),
        ("/state?token=é", OWN, "token is missing"),
        ("/", {**OWN, "Cookie": "activesuit-8080=guess; other=1"}, "token is missing"),
        ("/", {**OWN, **TOKEN, "Origin": "null"}, "Origin names another page"),
        ("/", {**OWN, **TOKEN, "Origin": "http://localhost:3000"}, "Origin names another page"),
        ("/", {**TOKEN, "Origin": "http://evil.example"}, "Origin names another page"),
        # A foreign name that was made to point to this machine has no cookie.
        ("/", {"Host": "evil.example", "Origin": "http://evil.example"}, "token is missing"),
        ("/drop/?sid=1", {**OWN, **TOKEN}, "takes no files"),
    ],
)
def test_only_the_own_page_with_the_token_is_answered(path, given, sentence):
    path = path.replace("TOKEN", ACCESS.token)
    said = ACCESS.refusal(path, Headers(given))
    assert said is None if sentence is None else sentence in said


def test_the_browser_gets_motion_and_drawing(monkeypatch, short):
    shown = []

    class Viewer:
        def is_running(self):
            return len(shown) < 30

        def sync(self, model, data):
            shown.append(data.qpos.copy())

    drawn = []
    monkeypatch.setattr(view, "served", lambda host, port, beside: nullcontext(Viewer()))
    monkeypatch.setattr(view, "check_address", lambda host, port: drawn.append(port))
    main(["view", "--web", "--task", "ElbowFlexion"])
    assert drawn == [browser.PORT]
    assert np.ptp(shown, axis=0).max() > 0.001
    messages = pytest.importorskip("mujoco.studio.messages")
    end = np.array([0.0, 0.0, 1.0])
    capsules = [Capsule(end, 2 * end, 0.1, np.array([1.0, 0.0, 1.0, 1.0]))]
    plugin = browser.drawer(capsules)
    plugin.viewer = SimpleNamespace(extra_geoms=["of before"])
    plugin.on_update(messages.UpdateEvent())
    (geom,) = plugin.viewer.extra_geoms
    assert geom.rgba.tolist() == [1, 0, 1, 1]


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
