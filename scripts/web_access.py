"""Who may use the viewer in a browser: requests with the token of its address, from its own page.

Every page that a browser has open can send requests to servers on the same machine. Such a request
names the foreign page in its header Origin, or, if that page made its own domain name point to this
machine, in its header Host. Neither has the cookie with the token.
"""

import secrets
import socket
from collections.abc import Iterable
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

UPLOAD = "/drop"  # path on which MuJoCo's viewer would receive models from the page


class WebAccess:
    """Decides which requests a viewer answers.

    Args:
        host: Address that the viewer listens on, or a name of one.

    Attributes:
        token: Secret part of the viewer's address.
    """

    def __init__(self, host: str) -> None:
        self.token = secrets.token_urlsafe(16)
        self._names = {"localhost", host.lower(), socket.gethostname().lower()}

    def refusal(self, path: str, headers: Iterable[tuple[str, str]]) -> str | None:
        """Returns why a request is refused, as one sentence; None if it may be answered.

        Args:
            path: Path and query of the request.
            headers: Names and values of its header fields.
        """
        fields: dict[str, list[str]] = {}
        for name, value in headers:
            fields.setdefault(name.lower(), []).append(value.strip())
        hosts, origins = fields.get("host", []), fields.get("origin", [])
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return "The header Host names another server: open the address that the viewer printed."
        if any(urlsplit(origin).netloc.lower() != hosts[0].lower() for origin in origins):
            return "The header Origin names another page: only the viewer's own page is served."
        where = urlsplit(path)
        if where.path.rstrip("/") == UPLOAD:
            return "This viewer shows one model: it takes no files."
        given = [*parse_qs(where.query).get("token", []), *self._cookies(fields.get("cookie", []))]
        if not any(secrets.compare_digest(one.encode(), self.token.encode()) for one in given):
            return "The token is missing: open the whole address that the viewer printed."
        return None

    def cookie(self, port: int) -> str:
        """Returns the header field Set-Cookie with which the page's later requests are answered.

        Args:
            port: Port of the viewer; browsers share cookies among all ports of a machine.
        """
        return f"activesuit-{port}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def _is_ours(self, host: str) -> bool:
        """Returns whether a header Host names this machine: an IP address cannot be rebound."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        try:
            ip_address(name)
        except ValueError:
            return name in self._names
        return True

    def _cookies(self, fields: Iterable[str]) -> list[str]:
        found = []
        for field in fields:
            try:
                cookies = SimpleCookie(field)
            except CookieError:
                continue
            found += [one.value for name, one in cookies.items() if name.startswith("activesuit-")]
        return found
