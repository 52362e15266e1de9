"""A run that is watched while it goes on."""

import base64
import json
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
import zlib
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from chromium import Chromium
from rmfs_commands.replay.live import RUNNING, Watch
from rmfs_commands.replay.reading import read_replay
from rmfs_commands.replay.telling import told
from rmfs_core import hookimpl
from rmfs_core.events import Event

SETTINGS = ["instance.orders=20"]
HEED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
"""Whoever runs the tests in the background ignores Ctrl-C, and so would what they start."""


def asked(address: str, after: int = -1) -> dict[str, Any] | None:
    with urllib.request.urlopen(address.replace("?", f"run?after={after}&"), timeout=10) as answer:
        text = answer.read()
    found: dict[str, Any] | None = json.loads(zlib.decompress(base64.b64decode(text))) if text else None
    return found


class Asking:
    def __init__(self, watch: Watch) -> None:
        self.watch = watch
        self.found: list[tuple[int, dict[str, Any] | None]] = []
        self.events = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.events += 1
        if self.events % 200 == 1:
            self.found.append((event.tick, asked(self.watch.address)))


def test_a_browser_is_told_of_the_run_so_far(tmp_path: Path) -> None:
    watch = Watch("day")
    asking = Asking(watch)
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["trace"], observers=[asking, watch])
    told_in_time = [(tick, run) for tick, run in asking.found if run is not None]
    assert told_in_time
    assert all(run["status"] == RUNNING and run["tick"] <= tick for tick, run in told_in_time)
    last = asked(watch.address)
    whole = json.loads(json.dumps(told(read_replay(tmp_path))))
    assert {**last, **{key: whole[key] for key in ("name", "metrics", "says")}} == whole
    assert asked(watch.address, after=last["tick"] + 1) == last  # a page that has missed the end is told it, too
    watch.close()
    with pytest.raises(urllib.error.URLError):
        asked(watch.address)
    watch.close()


def test_telling_costs_a_tenth_of_the_time_at_most() -> None:
    watch = Watch("day")
    told_at: list[float] = []

    class Often:
        @hookimpl
        def on_event(self, event: Event) -> None:
            if watch.news(event.tick - 1) is not None:
                told_at.append(time.monotonic())

    rmfs_core.run("examples/small", overrides=SETTINGS, observers=[Often(), watch])
    watch.close()
    assert 1 <= len(told_at) < 100


def refusal(address: str, **headers: str) -> tuple[int, str]:
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=10)
    with refused.value as answer:
        return answer.code, answer.read().decode("utf-8")


def test_only_who_has_the_token_is_answered() -> None:
    watch, other = Watch("day"), Watch("day")
    rmfs_core.run("examples/small", overrides=["instance.orders=1"], observers=[watch])
    assert len(watch.token) > 30
    assert watch.token != other.token
    with urllib.request.urlopen(watch.address, timeout=10) as answer:
        assert (answer.status, answer.headers["Content-Type"]) == (200, "text/html; charset=utf-8")
        assert watch.token not in answer.read().decode("utf-8")
    assert asked(watch.address)
    page, _, _ = watch.address.partition("?")
    without = (403, "Open the address that rmfs run --watch printed, with its token.")
    for path in ("", "run", "etc"):
        for query in (
            "",
            "?token=",
            f"?token={other.token}",
            f"?token={watch.token[:-1]}",
            "?token=%C3%A9",
            "?after=0",
        ):
            assert refusal(f"{page}{path}{query}") == without, (path, query)
    watch.close()


def test_only_this_machine_s_pages_are_answered() -> None:
    watch = Watch("day")
    rmfs_core.run("examples/small", overrides=["instance.orders=1"], observers=[watch])
    elsewhere = (403, "This page is for the machine that it runs on.")
    assert refusal(watch.address, Host="example.org") == elsewhere
    assert refusal(watch.address, Host="localhost.example.org:80") == elsewhere
    assert refusal(watch.address.replace("?", "etc?")) == (404, "There is / and /run.")
    tunnel = urllib.request.Request(watch.address, headers={"Host": "localhost:8000"})
    with urllib.request.urlopen(tunnel, timeout=10) as answer:
        assert answer.status == 200
    assert asked(watch.address, after=0)
    assert asked(watch.address, after=int("9" * 4000))  # is no time: the whole run
    watch.close()


@pytest.mark.slow
def test_the_command_shows_the_run_in_a_browser_until_ctrl_c(tmp_path: Path) -> None:
    program = f"{HEED}; from rmfs_commands.cli.main import main; main()"
    long = ("--set", "instance.orders=4000", "--out", str(tmp_path / "out"))
    command = [sys.executable, "-c", program, "run", "paper-250", "--watch", "--quiet", *long]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process, Chromium() as browser:
        try:
            address = next(line.split()[-1] for line in process.stderr if line.startswith("Watch the run at"))
            assert "?token=" in address
            browser.open(address)
            first = browser.evaluate("replay.end")
            begin = time.monotonic()
            while browser.evaluate("replay.running"):
                assert time.monotonic() - begin < 120
                time.sleep(0.2)
            assert browser.evaluate("replay.end") > first
            assert browser.evaluate("replay.clock.tick") > 0
            assert browser.evaluate("replay.views[0].run.status") == "complete"
            assert browser.problems == []
            assert any("until you press Ctrl-C" in line for line in process.stderr)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=20) == 0
        finally:
            process.kill()
    assert (tmp_path / "out" / "result.json").is_file()
