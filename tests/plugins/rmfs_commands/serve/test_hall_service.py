"""Halls over HTTP and by lines: made, asked, followed, killed, ended."""

import asyncio
import http.client
import io
import json
import os
import signal
import subprocess
import threading
import time
import urllib.error
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from email.message import Message
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import jsonschema
import pytest

from bad_rules import write_rule
from calling import refused
from cases import cases
from hall_trial import RULES, OwnHall, scenario_of
from rmfs_commands.cli.main import main
from rmfs_commands.details.loading import load_result
from rmfs_commands.serve.client import HallClient, HallError
from rmfs_commands.serve.hall_openapi import openapi_of_halls
from rmfs_commands.serve.hall_processes import HallProcesses
from rmfs_commands.serve.halls import POSTED, Halls
from rmfs_commands.session import Hall
from rmfs_commands.session.facts import FACTS
from rmfs_core.errors import InputError

Serve = Callable[..., Any]
SMALL = Path(__file__).parents[4] / "scenarios" / "examples" / "small.toml"
TABLES = {
    "instance": {"skus": 9, "pods": 9, "items_per_sku": 99, "skus_per_pod": 3, "orders": 1},
    "layout": {"block_rows": 5, "block_columns": 3, "stations_east": 2},
    "robots": {"count": 2},
    "rules": {"poa": "pod-match", "pps": "demand"},
}


def arrived(order: str) -> dict[str, Any]:
    return {"id": order, "kind": "order_arrived", "order": order, "lines": {"1": 1}}


@pytest.mark.slow
def test_halls_over_http(serve: Serve, tmp_path: Path) -> None:
    _, port = serve("--hall", f"a={SMALL}", "--journal", str(tmp_path))
    a, b = (HallClient(f"http://127.0.0.1:{port}", hall) for hall in "ab")
    b.make(TABLES)
    followed: list[Any] = []
    following = threading.Thread(target=lambda: followed.append(next(b.answers(0))))
    following.start()
    answer = b.send(1.0, [arrived("A")])
    assert {one["kind"] for one in answer["commands"]} == {"assign", "fetch"}
    answers = [answer, b.send(2.0, [])]
    following.join(20)
    assert followed == answers[:1]
    assert (a.state()["session"]["seq"], b.state()["session"]["seq"]) == (0, 2)
    stale = HallClient(f"http://127.0.0.1:{port}", "b")
    with pytest.raises(HallError, match=r"found 0; expected 2") as caught:
        stale.send(9.0, [])
    assert (caught.value.status, caught.value.told["seq"]) == (409, 2)

    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=20)) as stream:
        stream.request("GET", "/v1/halls/b/commands", headers={"Accept": "text/event-stream", "Last-Event-ID": "1"})
        lines = stream.getresponse()
        assert [lines.readline() for _ in range(3)][0::2] == [b"id: 2\n", b"\n"]
        b.send(3.0, [])
        assert lines.readline() == b"id: 3\n"

    def asked(method: str, path: str, headers: dict[str, str] | None = None) -> tuple[int, Any, Any]:
        with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=20)) as connection:
            connection.request(method, f"/v1/halls{path}", headers=headers or {})
            reply = connection.getresponse()
            return reply.status, reply.headers.get("ETag"), json.loads(reply.read())

    assert asked("GET", "") == (200, None, {"halls": ["a", "b"]})
    assert asked("GET", "/b")[:2] == (200, '"3"')
    for method, path, headers, status, told in (
        ("GET", "/c", {}, 404, "there is no hall"),
        ("GET", "/b", {"Host": "example.org"}, 421, "is not served here"),
        ("GET", "/b/commands?after=x", {}, 422, "after: expected"),
        ("GET", "/b/commands?after=9", {}, 422, "expected 0 to 3"),
        ("GET", "/b/commands?wait_s=99", {}, 422, "wait_s: expected"),
        ("POST", "/b/events", {}, 415, "expected application/json"),
        ("PUT", "/b", {}, 422, "If-Match: expected"),
        ("PUT", "/b", {"If-Match": '"3"'}, 415, "expected application/json"),
        ("PATCH", "/b", {}, 405, "is not answered"),
        ("DELETE", "/b", {"If-Match": '"2"'}, 409, "expected 3, the last batch"),
        ("DELETE", "/b", {"If-Match": '""'}, 422, "If-Match: expected"),
    ):
        found, _, problem = asked(method, path, headers)
        assert (found, told in problem["detail"]) == (status, True), problem
    with pytest.raises(HallError, match="there is a hall") as caught:
        b.make(TABLES)
    assert caught.value.status == 409
    main(["run", f"{tmp_path}/b{POSTED}", "--journal", f"{tmp_path}/b.jsonl", "--out", f"{tmp_path}/day", "--quiet"])
    assert load_result(tmp_path / "day").status == "horizon"
    state = b.state()
    answer = b.replace(state)
    assert (answer["seq"], answer["replaced"], b.state()["orders"]) == (4, True, state["orders"])
    for client, told, status in ((b, {**state, "pods": 3}, 422), (stale, state, 409)):
        with pytest.raises(HallError) as caught:
            client.replace(told)
        assert caught.value.status == status
    assert b.send(4.0, [{"id": "?", "kind": "handled", "station": "9"}])["seq"] == 5
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=20)) as connection:
        connection.request("GET", "/metrics")
        figures = connection.getresponse().read().decode().splitlines()
    expected = {"seq": 5, "facts_total": 2, "dropped_total": 1, "open_orders": 1, "overdue": 0, "quarantined": 0}
    assert {f'rmfs_hall_{name}{{hall="b"}} {value:.1f}' for name, value in expected.items()} <= {*figures}
    assert 'rmfs_answers_total{hall="b",status="200"} 5.0' in figures


@pytest.mark.slow
def test_a_hall_whose_process_or_service_is_killed_goes_on(serve: Serve, tmp_path: Path) -> None:
    process, port = serve("--hall", f"a={SMALL}", "--journal", str(tmp_path))
    a = HallClient(f"http://127.0.0.1:{port}", "a")
    answer = a.send(1.0, [arrived("A")])
    children = [int(pid) for pid in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
    for child in children:
        os.kill(child, signal.SIGKILL)
    time.sleep(0.2)
    assert a.send(2.0, [])["seq"] == 2
    process.kill()
    process.wait()
    _, port = serve("--hall", f"a={SMALL}", "--journal", str(tmp_path))
    a = HallClient(f"http://127.0.0.1:{port}", "a")
    assert next(a.answers(0)) == answer
    assert a.state()["session"]["seq"] == 2
    a.end()
    with pytest.raises(HallError, match="there is no hall"):
        a.state()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.1.jsonl"]


def test_what_is_answered_is_what_is_described() -> None:
    document = openapi_of_halls()
    schemas = {
        name: {**schema, "components": document["components"]}
        for name, schema in document["components"]["schemas"].items()
    }
    session, seen = Hall(scenario_of(RULES["sequential"])), set[str]()

    def take(batch: dict[str, Any]) -> Any:
        answer = session.take(batch)
        kinds = {one["kind"] for one in (*batch["events"], *answer["commands"])}
        if not kinds <= seen:
            seen.update(kinds)
            jsonschema.validate(batch, schemas["Batch"])
            jsonschema.validate(answer | {"ask_again_s": answer["ask_again_s"] or 0}, schemas["Answer"])
        return answer

    hall = OwnHall(take, session.state)
    hall.at(1, lambda: iter([hall.order(f"{i}", {f"{i + 1}": 1}) for i in range(9)]))
    hall.run()
    assert seen >= {"assign", "fetch", "lift", "pick_next", "store", "order_arrived", "robot_at", "picked", "handled"}
    assert {f"fact_{kind}" for kind in FACTS} <= schemas.keys()
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"after": 0, "time_s": 1, "events": [{"id": "1", "kind": "handled"}]}, schemas["Batch"])


@cases(
    "hall content status detail",
    ("a", b"{", 422, "no valid JSON"),
    ("a", b"[]", 422, "expected an object with `scenario`"),
    ("a", b'{"scenario": {"seed": 1e400}}', 422, "has a number that is not finite"),
    ("a/b", b'{"scenario": {}}', 422, "expected NAME=SCENARIO"),
)
def test_what_cannot_be_made(tmp_path: Path, hall: str, content: bytes, status: int, detail: str) -> None:
    reply = asyncio.run(HallProcesses((), str(tmp_path), None).make(hall, content))
    assert reply.status == status
    assert detail in json.loads(reply.content)["detail"]


def test_a_batch_that_fails_is_answered_once_whatever_is_in_the_journal(tmp_path: Path) -> None:
    write_rule(tmp_path, "poa", "assert all(one.name != 'bad' for one in warehouse.backlog); return []")
    text = SMALL.read_text().replace('poa = "pod-match"', 'poa = "./bad.py:Bad"')
    (tmp_path / "hall.toml").write_text(text)

    async def asked() -> list[Any]:
        halls = HallProcesses([f"a={tmp_path}/hall.toml"], str(tmp_path), None)
        await halls.start()
        told = [{"after": n, "time_s": n, "events": [arrived("bad" if n == 3 else f"{n}")]} for n in (0, 1, 2, 3)]
        replies = [await halls.ask("a", json.dumps(batch).encode()) for batch in told]
        replies.append(await halls.ask("a", {"get": "seq"}))
        await halls.stop()
        return [(reply.status, json.loads(reply.content).get("seq")) for reply in replies]

    assert asyncio.run(asked()) == [(200, 1), (200, 2), (200, 3), (500, None), (200, 3)]


def test_simultaneous_requests_make_a_hall_once_and_end_it_once(tmp_path: Path) -> None:
    """A request to make it again gets the first one's answer, as long as the hall has taken no batch."""
    wanted, other = (json.dumps({"scenario": TABLES | more}).encode() for more in ({}, {"seed": 2}))

    async def asked() -> list[int]:
        halls = HallProcesses((), str(tmp_path), None)
        first, number = halls.make("a", wanted), halls.ask("a", {"get": "seq"})
        replies = await asyncio.gather(first, number, halls.make("a", wanted), halls.make("a", other))
        replies.append(await halls.ask("a", b'{"after": 0, "time_s": 0, "events": []}'))
        replies.append(await halls.make("a", wanted))
        ending = asyncio.create_task(halls.end("a", None))
        while "a" in halls.names:
            await asyncio.sleep(0)
        replies += await asyncio.gather(ending, halls.make("a", other))
        replies.append(await halls.ask("a", {"get": "seq"}))
        (tmp_path / "a.1.jsonl").rename(tmp_path / "b.jsonl")  # a hall that was not ended
        replies.append(await halls.make("b", wanted))
        await halls.stop()
        return [(reply.status, json.loads(reply.content).get("seq")) for reply in replies]

    made, begun, none = (201, 0), (200, 1), (409, None)
    assert asyncio.run(asked()) == [made, (200, 0), made, none, begun, none, begun, made, (200, 0), (201, 1)]
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"a{POSTED}", "a.jsonl", f"b{POSTED}", "b.jsonl"]


@cases(
    "tables problem",
    ('{"instance": ', f"a{POSTED}, line 1: this is no valid JSON"),
    ({"instance": {"orders_file": "/etc/passwd"}}, "orders_file: .*expected no file"),
    ({"rules": {"poa": "rule.py:Rule", "pps": "demand"}}, "rules.poa: there is no file"),
    ({"rules": {"poa": {"rule": "remote", "command": "id"}, "pps": "demand"}}, "no-inline-rules refuses"),
)
def test_a_hall_that_is_made_over_http_is_whole_names_no_file_and_starts_no_program(
    tmp_path: Path, tables: str | dict[str, Any], problem: str
) -> None:
    file = tmp_path / f"a{POSTED}"
    file.write_text(tables if isinstance(tables, str) else json.dumps(tables))
    with pytest.raises(InputError, match=problem):
        Halls.of([f"a={file}"], allow_inline=False)


@contextmanager
def served(rmfs: tuple[str, ...], *arguments: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = (*rmfs, "serve", *arguments, "--stdio")
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        yield process
        process.kill()


def ask(process: "subprocess.Popen[bytes]", request: Any) -> Any:
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.flush()
    return json.loads(process.stdout.readline())


def test_lines_name_their_hall(rmfs: tuple[str, ...]) -> None:
    batch = {"after": 0, "time_s": 1, "events": []}
    with served(rmfs, "--hall", f"a={SMALL}", "--hall", f"b={SMALL}") as process:
        assert ask(process, {"hall": "a", **batch})["seq"] == 1
        assert ask(process, {"hall": "b", "get": "state"})["session"]["seq"] == 0
        stale = ask(process, {"hall": "a", **batch, "time_s": 2})
        assert (stale["status"], stale["seq"]) == (409, 1)
        for request, status, detail in (
            (batch, 422, "hall: is missing; expected a or b"),
            ({"hall": "c", **batch}, 422, "no hall is"),
            ({"hall": "a", "get": "all"}, 422, "expected state, answers, seq or counts"),
            ({"hall": "a", "get": "answers", "after": 2}, 422, "expected 0 to 1"),
        ):
            answer = ask(process, request)
            assert answer["status"] == status
            assert detail in answer["detail"]


@cases(
    "arguments problem",
    (["--hall", "a", "--stdio"], "expected NAME=SCENARIO"),
    (["--hall", f"a={SMALL}", "--hall", f"a={SMALL}", "--stdio"], "found this hall twice"),
    (["--hall", f"a={SMALL}", "--rule", "pod-match", "--stdio"], "found --rule with --hall"),
    (["--rule", "pod-match", "--journal", "x", "--stdio"], "found --journal with --rule"),
    (["--hall", f"a={SMALL}"], "needs --journal"),
    (["--hall", f"a={SMALL}", "--journal", __file__, "--stdio"], "_service.py: found a file; expected a folder"),
)
def test_what_cannot_be_served_is_refused(capsys: Any, arguments: list[str], problem: str) -> None:
    assert problem in refused(capsys, main, ["serve", *arguments])


def test_an_end_whose_answer_was_lost_is_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    gone = urllib.error.HTTPError("", 404, "", Message(), io.BytesIO(b"{}"))
    replies: list[Exception] = [
        OSError("lost"),
        gone,
        urllib.error.HTTPError("", 404, "", Message(), io.BytesIO(b"{}")),
    ]
    monkeypatch.setattr("urllib.request.urlopen", Mock(side_effect=replies))
    monkeypatch.setattr("time.sleep", Mock())
    HallClient("http://127.0.0.1:1", "a").end()
    with pytest.raises(HallError):
        HallClient("http://127.0.0.1:1", "a", tries=1).end()


def test_a_lost_answer_or_that_of_a_proxy_is_asked_for_again(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [urllib.error.HTTPError("", code, "", Message(), io.BytesIO(b"[]")) for code in (502, 403)]
    replies = [http.client.IncompleteRead(b"{"), told[0], io.BytesIO(b"<html>"), io.BytesIO(b'{"seq": 1}'), told[1]]
    monkeypatch.setattr("urllib.request.urlopen", Mock(side_effect=replies))
    monkeypatch.setattr("time.sleep", Mock())
    hall = HallClient("http://127.0.0.1:1", "a")
    assert hall.send(0, []) == {"seq": 1}
    with pytest.raises(HallError, match="status 403"):
        hall.send(1, [])
