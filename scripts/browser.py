"""MuJoCo's viewer in a browser, listening on an address that the user chooses."""

import socket
from collections.abc import Callable
from typing import Any

from ..errors import InputError, shown

PORT = 0  # the first free one from 8080
LOCAL = ("localhost", "127.0.0.1", "::1")


def check_address(host: str, port: int) -> None:
    """Checks that a web page can be served at an address.

    Args:
        host: Address of this machine, or a name of one.
        port: Port; 0 for any that is free.

    Raises:
        InputError: It is not an address of this machine, or the port is taken or not allowed.
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


def served(host: str, port: int) -> Any:
    """Starts the viewer in a thread; returns its handle, a context in which it is served.

    The viewer of MuJoCo 4.0 always listens on all addresses. Its only say in that is an attribute,
    which this one therefore holds fixed.
    """
    from mujoco.studio import app, launch_thread, plugin, viewer_protocol, web_viewer

    class Viewer(web_viewer.WebViewer):
        # A property wins over the assignment in the constructor of the viewer.
        _host: Any = property(lambda self: host, lambda self, value: asked.append(value))

    asked: list[str] = []
    # The panels are about a simulation that the viewer itself would step.
    bare = app.Config(show_options=False, show_inspector=False, show_status_bar=False)
    shown_parts, simulated_parts = plugin.split_plugins([app.App(bare)])
    config = viewer_protocol.ViewerConfig(gfx="web", http_port=port)

    def show(endpoint: Any) -> None:
        viewer = Viewer(config, endpoint, plugins=shown_parts)
        if not asked and host in LOCAL:
            viewer.close()
            raise RuntimeError("this version of MuJoCo does not listen on localhost alone")
        viewer_protocol.run_viewer_loop(viewer)

    start: Callable[..., Any] = launch_thread.launch_thread
    return start(show, sim_plugins=simulated_parts)
