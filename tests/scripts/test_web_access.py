"""Requests that the viewer in a browser answers, and those that it refuses."""

import pytest
from activesuit.scripts.web_access import WebAccess

ACCESS = WebAccess("localhost")
TOKEN = {"Cookie": ACCESS.cookie(8080).split(";")[0]}
OWN = {"Host": "localhost:8080"}


def refusal(path="/", access=ACCESS, **headers):
    return access.refusal(path, headers.items())


def test_the_address_with_its_token_is_answered():
    assert refusal(f"/?token={ACCESS.token}", **OWN) is None


@pytest.mark.parametrize("path", ["/", "/web_client.wasm", "/model?crc32=5", "/ui?sid=1", "/state"])
def test_the_page_is_answered_by_its_cookie(path):
    assert refusal(path, **OWN, **TOKEN) is None
    assert refusal(path, **OWN, **TOKEN, Origin="http://localhost:8080") is None


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=guess", "/model", "/state?token=é"])
def test_a_request_without_the_token_is_refused(path):
    assert "token is missing" in refusal(path, **OWN)
    assert "token is missing" in refusal(path, **OWN, Cookie="activesuit-8080=guess; other=1")
    assert "token is missing" in refusal(path, **OWN, Cookie=f"other={ACCESS.token}")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost:3000", "http://localhost:8080.evil"]
)
def test_another_page_is_refused_even_with_the_token(origin):
    asked = refusal(f"/state?token={ACCESS.token}", **OWN, **TOKEN, Origin=origin)
    assert "Origin names another page" in asked


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8080", "localhost.evil.example", ""]
)
def test_a_foreign_name_of_this_machine_is_refused(host):
    address = f"/?token={ACCESS.token}"
    assert "Host names another server" in refusal(address, Host=host)
    assert "Host names another server" in refusal(address)
    twice = [("Host", "localhost:8080"), ("host", "evil.example")]
    assert "Host names another server" in ACCESS.refusal(address, twice)


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "[::1]:8080", "192.0.2.7", "LOCALHOST:9000"])
def test_addresses_and_tunnels_are_answered(host):
    # An IP address in Host was typed as such: no name can have been made to point here.
    assert refusal("/", Host=host, **TOKEN) is None


def test_the_name_that_was_asked_for_is_answered():
    access = WebAccess("lab-pc.local")
    assert access.refusal(f"/?token={access.token}", [("Host", "lab-pc.local:8080")]) is None


@pytest.mark.parametrize("path", ["/drop", "/drop?sid=1", "/drop/"])
def test_files_are_always_refused(path):
    assert "takes no files" in refusal(path, **OWN, **TOKEN)


def test_each_viewer_has_its_own_token():
    assert len({WebAccess("localhost").token for _ in range(20)}) == 20
