"""Where the service listens."""

from __future__ import annotations

import socket
from types import SimpleNamespace
from typing import cast

import pytest

from rmfs_commands.serve.server import is_loopback, listen, url_of
from rmfs_core.errors import InputError


def test_loopback_and_others() -> None:
    """Which addresses other machines reach."""
    with listen("localhost", 0) as here:
        assert is_loopback(here)
        assert url_of(here).endswith(f":{here.getsockname()[1]}")
    with listen("0.0.0.0", 0) as everywhere:
        assert not is_loopback(everywhere)


@pytest.mark.parametrize(("address", "loopback"), [("::1", True), ("::", False), ("fe80::1%eth0", False)])
def test_ipv6(address: str, loopback: bool) -> None:
    """Brackets around the address."""
    found = cast(socket.socket, SimpleNamespace(getsockname=lambda: (address, 80, 0, 0)))
    assert url_of(found) == f"http://[{address}]:80"
    assert is_loopback(found) == loopback


@pytest.mark.parametrize("host", ["nowhere.invalid", "a..b", "x" * 70 + ".de"])
def test_an_address_that_is_none(host: str) -> None:
    """One sentence."""
    with pytest.raises(InputError, match=rf"^--host {host} --port 0: cannot listen there: "):
        listen(host, 0)


def test_a_port_that_is_taken() -> None:
    """One sentence, too."""
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(InputError, match=r"cannot listen there: .*ddress already in use"):
            listen("127.0.0.1", port)
