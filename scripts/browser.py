"""MuJoCo's viewer in a browser, for those who have the address with its token.

Every page that a browser has open can send requests to servers on the same machine. Such a request
lacks the token, or names the foreign page in its header Origin.
"""

import secrets
import socket
import time
from collections.abc import Callable, Sequence
from functools import partial
from http.client import HTTPConnection
from ipaddress import ip_address
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ..envs.rendering import Capsule
from ..errors import InputError, shown
from ..text import say

PORT = 0  # stands for the first free one from 8080
LOCAL = ("localhost", "127.0.0.1", "::1")
START = 30.0  # [s], longest time that the server may take to start
UPLOAD = "/drop"  # path on which MuJoCo's viewer would receive models from the page


class WebAccess:
    """Decides which requests a viewer answers.

    Attributes:
        token: Secret part of the viewer's address.
    """

    def __init__(self) -> None:
        self.token = secrets.token_urlsafe(16)

    def refusal(self, path: str, headers: Any) -> str | None:
        """Returns why a request is refused, as one sentence; None if it may be answered.

        Args:
            path: Path and query of the request.
            headers: Its header fields, as `websockets.datastructures.Headers`.
        """
        where, hosts = urlsplit(path), headers.get_all("Host")
        if any(hosts != [urlsplit(one).netloc] for one in headers.get_all("Origin")):
            return "The header Origin names another page: only the viewer's own page is served."
        if where.path.rstrip("/") == UPLOAD:
            return "This viewer shows one model: it takes no files."
        cookies = ";".join(headers.get_all("Cookie")).split(";")
        given = [*parse_qs(where.query).get("token", []), *(c.partition("=")[2] for c in cookies)]
        if not any(secrets.compare_digest(one.encode(), self.token.encode()) for one in given):
            return "The token is missing: open the whole address that the viewer printed."
        return None

    def cookie(self, port: int) -> str:
        """Returns the header field Set-Cookie with which the page's later requests are answered.

        Args:
            port: Port of the viewer; browsers share cookies among all ports of a machine.
        """
        return f"activesuit-{port}={self.token}; Path=/; HttpOnly; SameSite=Strict"


def check_address(host: str, port: int) -> None:
    """Checks that a web page can be served at an address.

    Args:
        host: Address of this machine, or a name of one.
        port: Port; 0 for any that is free.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"port is {shown(port)}: use 1 to 65535, or 0 for one that is free")
    if not host:
        raise InputError("host is '': use localhost, or another address of this machine")
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.socket(family, socket.SOCK_STREAM) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((host, port))
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or "no such name"
        raise InputError(
            f"nothing can listen on host {shown(host)}, port {port} ({why}): use an address of "
            "this machine, such as localhost, and a free port, or 0"
        ) from error


def served(host: str, port: int, beside: Sequence[Capsule] = ()) -> Any:
    """Starts the viewer in a thread; returns its handle, a context in which it is served.

    The viewer of MuJoCo 4.0 listens on all addresses and answers everyone. Here it listens on
    `host`, and each request is first judged by a `WebAccess`. Both change parts of MuJoCo that are
    not public, so they are tested before the address is printed.

    Args:
        host: Address to listen on.
        port: Port; 0 for the first free one from 8080.
        beside: What is drawn beside the model, which may change.
    """
    from mujoco.studio import app, launch_thread, plugin, viewer_protocol, web_viewer
    from mujoco.studio.web import web_server

    class Viewer(web_viewer.WebViewer):
        # A property wins over the assignment in the constructor of the viewer.
        _host: Any = property(lambda self: host, lambda self, value: None)

        def _start_server(self) -> None:
            super()._start_server()
            try:
                _check_locked(host, self._http_sock)
            except InputError:
                self._stop_server()
                raise

    access = WebAccess()
    web_server.serve = partial(_guarded, web_server.serve, access)
    web_viewer._print_url_banner = partial(_announce, access)
    # The panels are about a simulation that the viewer itself would step.
    bare = app.Config(show_options=False, show_inspector=False, show_status_bar=False)
    shown_parts, simulated_parts = plugin.split_plugins([app.App(bare), drawer(beside)])
    config = viewer_protocol.ViewerConfig(gfx="web", http_port=port)

    def show(endpoint: Any) -> None:
        viewer_protocol.run_viewer_loop(Viewer(config, endpoint, plugins=shown_parts))

    start: Callable[..., Any] = launch_thread.launch_thread
    return start(show, sim_plugins=simulated_parts)


def drawer(beside: Sequence[Capsule]) -> Any:
    """Returns a plugin of MuJoCo Studio that draws capsules."""
    import mujoco
    from mujoco.studio import messages, plugin

    class Drawer(plugin.ViewerPlugin):
        @messages.handler
        def on_update(self, _: messages.UpdateEvent) -> None:
            self.viewer.extra_geoms[:] = [one.into(mujoco.MjvGeom()) for one in beside]

    return Drawer()


def _guarded(
    serve: Callable[..., Any],
    access: WebAccess,
    handler: Callable[..., Any],
    *,
    sock: socket.socket,
    process_request: Callable[[Any, Any], Any],
    **options: Any,
) -> Any:
    """Calls `websockets.asyncio.server.serve`, with `access` asked before each request."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    def decide(connection: Any, request: Any) -> Any:
        refusal = access.refusal(request.path, request.headers)
        if refusal is not None:
            plain = Headers({"Content-Type": "text/plain; charset=utf-8"})
            return Response(403, "Forbidden", plain, f"{refusal}\n".encode())
        answer = process_request(connection, request)
        if answer is not None:
            answer.headers["Set-Cookie"] = access.cookie(sock.getsockname()[1])
            answer.headers["Referrer-Policy"] = "no-referrer"
        return answer

    return serve(handler, sock=sock, process_request=decide, **options)


def _check_locked(host: str, listening: socket.socket) -> None:
    address, port = listening.getsockname()[:2]
    if host in LOCAL and not ip_address(address).is_loopback:
        raise InputError(
            "this version of MuJoCo does not listen on localhost alone: use MuJoCo 4.0"
        )
    own = str({"0.0.0.0": "127.0.0.1", "::": "::1"}.get(address, address))
    deadline = time.monotonic() + START
    while True:
        connection = HTTPConnection(own, port, timeout=START)
        try:
            connection.request("GET", "/")
            answer = connection.getresponse().status
            break
        except OSError as error:  # its thread is still starting
            if time.monotonic() > deadline:
                raise InputError(f"the viewer's server does not start ({error})") from error
            time.sleep(0.02)
        finally:
            connection.close()
    if answer != 403:
        raise InputError("MuJoCo answers requests without a token: use MuJoCo 4.0")


def _announce(access: WebAccess, host: str, port: int) -> None:
    """Prints the address; takes the place of a banner that has no token."""
    name = socket.gethostname() if host in ("0.0.0.0", "::") else host
    name = f"[{name}]" if ":" in name else name
    say(f"open http://{name}:{port}/?token={access.token} in a browser; Ctrl-C ends the viewer")
    if host not in LOCAL:
        say("note: the page is not encrypted, so that others on the network can read the token")
