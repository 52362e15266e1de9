"""A client of a hall that `rmfs serve --hall` runs over HTTP, for a program of one's own; it needs Python alone."""

from __future__ import annotations

import json
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from http.client import HTTPException
from typing import Any
from urllib.parse import quote


class HallError(Exception):
    """A request that was refused; ``status`` is that of HTTP, ``told`` the problem as the service says it."""

    def __init__(self, status: int, told: Mapping[str, Any]) -> None:
        super().__init__(told.get("detail", f"status {status}"))
        self.status, self.told = status, told


class HallClient:
    """One hall. It numbers batches, and sends one again whose answer was lost.

    Parameters
    ----------
    url
        Of the service: ``http://127.0.0.1:8750``.
    hall
        The hall's name.
    tries
        How often a batch is sent that gets no answer, with a second in between.

    Attributes
    ----------
    seq
        Number of the last batch.

    Examples
    --------
    >>> hall = HallClient("http://127.0.0.1:8750", "north")  # doctest: +SKIP
    >>> answer = hall.send(12.5, [{"id": "e1", "kind": "robot_at", "robot": "1", "cell": 40}])  # doctest: +SKIP
    """

    def __init__(self, url: str, hall: str, tries: int = 60) -> None:
        self._url, self._tries = f"{url.rstrip('/')}/v1/halls/{quote(hall)}", tries
        self.seq = 0

    def make(self, scenario: Mapping[str, Any]) -> None:
        """Make the hall of the tables of a scenario."""
        self.seq = int(self._ask("POST", "", {"scenario": scenario})["seq"])

    def state(self) -> dict[str, Any]:
        """Return the whole state; go on after its last batch."""
        state = self._ask("GET", "")
        self.seq = int(state["session"]["seq"])
        return state

    def send(self, time_s: float, events: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Send facts, and return the answer.

        Raises
        ------
        HallError
            Where they are refused; with status 409 ``told`` has the number of the last batch as ``seq``.
        """
        answer = self._ask("POST", "/events", {"after": self.seq, "time_s": time_s, "events": [*events]})
        self.seq = int(answer["seq"])
        return answer

    def replace(self, state: Mapping[str, Any]) -> dict[str, Any]:
        """Put a state into the place of the hall's own, and return the answer; raises as `send`."""
        answer = self._ask("PUT", "", state)
        self.seq = int(answer["seq"])
        return answer

    def answers(self, after: int, wait_s: float = 25.0) -> Iterator[dict[str, Any]]:
        """Yield the answers after a batch, without end, as they are given."""
        while True:
            for answer in self._ask("GET", f"/commands?after={after}&wait_s={wait_s:g}")["answers"]:
                after = answer["seq"]
                yield answer

    def end(self) -> None:
        """End the hall."""
        self._ask("DELETE", "")

    def _ask(self, method: str, path: str, body: Mapping[str, Any] | None = None) -> dict[str, Any]:
        content = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"} | ({"If-Match": f'"{self.seq}"'} if method == "PUT" else {})
        for tried in range(1, self._tries + 1):
            try:
                request = urllib.request.Request(self._url + path, content, headers, method=method)
                with urllib.request.urlopen(request, timeout=120) as reply:
                    return _object(reply.read())
            except urllib.error.HTTPError as error:
                told: dict[str, Any] = {}
                with error, suppress(ValueError, HTTPException):  # of a proxy, or not whole
                    told = _object(error.read())
                if (method, error.code) == ("DELETE", 404) and tried > 1:
                    return {}  # it ended at a try before, whose answer was lost
                if error.code not in (502, 503, 504) or tried == self._tries:
                    raise HallError(error.code, told) from None
            except (OSError, HTTPException, ValueError):
                if tried == self._tries:
                    raise
            time.sleep(1.0)
        raise AssertionError("there is a last try")


def _object(content: bytes) -> dict[str, Any]:
    """Return the object of JSON that an answer is; ValueError for anything else, as a proxy may send it."""
    if isinstance(told := json.loads(content), dict):
        return told
    raise ValueError("found an answer that is no object of JSON")
