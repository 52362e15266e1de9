"""`rmfs serve` as a process: where it listens, what it answers; and the process of the rules that it asks."""

import asyncio
import http.client
import io
import json
import os
import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from urllib.parse import urlsplit
from urllib.request import urlopen

import jsonschema
import pytest
import uvicorn
from hypothesis import given, settings
from hypothesis import strategies as st
from uvicorn.server import ServerState

from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.serve import connections
from rmfs_commands.serve.connections import Connection
from rmfs_commands.serve.lines import serve_lines
from rmfs_commands.serve.openapi import openapi
from rmfs_commands.serve.process import BusyError, EndedError, LateError, RuleProcess
from rmfs_commands.serve.server import is_loopback, listen, url_of
from rmfs_commands.serve.service import SMALL, Service
from rmfs_core.errors import InputError

SPAWNING = """
import subprocess, time
from attrs import define
from rmfs_core import hookimpl

@define
class Spawning:
    "POA: starts a child; asked about an order called hang, or always, it never returns."
    always: bool = False
    @hookimpl
    def assign_orders(self, warehouse):
        child = subprocess.Popen(["sleep", "600"])
        with open("children", "a") as file:
            print(child.pid, file=file)
        while self.always or any(order.name == "hang" for order in warehouse.backlog):
            pass
        return []
"""


def living(pids: Iterable[int]) -> list[int]:
    """Return the processes that have not ended, of some."""
    found = []
    for pid in pids:
        with suppress(FileNotFoundError, ProcessLookupError):
            if Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z":
                found.append(pid)
    return found


def ended(pids: Iterable[int]) -> bool:
    until = time.monotonic() + 20
    while living(pids) and time.monotonic() < until:
        time.sleep(0.02)
    return not living(pids)


@pytest.fixture
def spawning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "spawning.py").write_text(SPAWNING, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "children"


def numbers(children: Path) -> list[int]:
    return [*map(int, children.read_text(encoding="utf-8").split())]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes as Linux has them")
def test_children_of_rules_end_with_their_process(spawning: Path, state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        begun = numbers(spawning)
        assert living(begun) == begun
        with pytest.raises(LateError):
            await process.ask(json.dumps(state | {"orders": {"hang": {"lines": {"jam": 1}}}}).encode())
        assert await asyncio.to_thread(ended, begun)
        process.limit_s = 30
        assert (await process.ask(json.dumps(state).encode())).status == 200
        assert living(numbers(spawning))
        os.kill(process.pid, signal.SIGKILL)
        assert await asyncio.to_thread(ended, numbers(spawning))

    with_process("./spawning.py:Spawning", 1, do)
    assert ended(numbers(spawning))


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes as Linux has them")
def test_nothing_outlives_a_service_that_is_killed(spawning, state, rmfs) -> None:
    """Not even a rule that computes and would never see the end of its input."""
    command = [*rmfs, "serve", "--rule", "./spawning.py:Spawning", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        address = service.stdout.readline().partition(" at ")[2].partition(";")[0]
        hanging = json.dumps(state | {"orders": {"hang": {"lines": {"jam": 1}}}}).encode()
        before = len(numbers(spawning))
        with socket.create_connection((urlsplit(address).hostname, urlsplit(address).port)) as client:
            head = "POST /decide HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: "
            client.sendall(head.encode() + b"%d\r\n\r\n" % len(hanging) + hanging)
            while len(numbers(spawning)) == before:
                time.sleep(0.02)
            group = os.getpgid(numbers(spawning)[-1])
            assert living([group]) == [group]
            service.kill()
    assert ended([group, *numbers(spawning)])


def test_a_first_decision_that_never_returns(spawning: Path) -> None:
    async def run() -> None:
        rule = "{ rule = './spawning.py:Spawning', always = true }"
        process = RuleProcess([rule], limit_s=0.5, start_s=8)
        with pytest.raises(EndedError, match=r"the rules were not loaded, or one did not decide, within 8 s"):
            await process.start()
        assert process.pid is None

    asyncio.run(run())
    assert ended(numbers(spawning))


def with_process(rule: str, limit_s: float, do: Callable[[RuleProcess], Awaitable[None]]) -> None:
    async def run() -> None:
        process = RuleProcess([rule], limit_s=limit_s)
        await process.start()
        try:
            await do(process)
        finally:
            await process.stop()
        assert process.pid is None

    asyncio.run(run())


def test_late_busy_ended(trouble: str, state: dict[str, Any], capfd: pytest.CaptureFixture[str]) -> None:
    def named(name: str) -> bytes:
        return json.dumps(state | {"orders": {name: {"lines": {"jam": 1}}}}).encode()

    async def do(process: RuleProcess) -> None:
        first = process.pid
        slow = asyncio.create_task(process.ask(named("sleep")))
        await asyncio.sleep(0)  # it has begun
        process.limit_s = 0.1  # of those who wait for their turn: they give up first
        late, after = await asyncio.gather(*(process.ask(named(one)) for one in "AB"), return_exceptions=True)
        process.limit_s = 0.7
        with pytest.raises(LateError, match=r"^no decision within 0\.7 s \(`--limit-s`\); it was given up$"):
            await slow
        assert all(isinstance(one, BusyError) for one in (late, after))
        process.limit_s = 30  # the machine may be busy
        assert (await process.ask(named("A"))).status == 200
        assert process.pid not in (None, first)
        with pytest.raises(EndedError, match="ended with code 7"):
            await process.ask(named("exit"))
        replies = await asyncio.gather(*(process.ask(named(name)) for name in ("A", "print", "C", "D")))
        assert [reply.status for reply in replies] == [200] * 4
        assert process.restarts == 2

    with_process(trouble, 0.7, do)
    assert sorted(capfd.readouterr().err.splitlines()) == ["from below", "hello"]


def test_a_process_that_was_ended_by_somebody(state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        os.kill(process.pid, signal.SIGKILL)
        while process.pid is not None:
            await asyncio.sleep(0.01)
        assert (await process.ask(json.dumps(state).encode())).status == 200
        assert process.restarts == 1

    with_process("first-come", 30, do)


def test_large_requests(state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        content = json.dumps(state).encode()
        reply = await process.ask(content + b" " * 3_000_000)
        assert reply == await process.ask(content)

    with_process("first-come", 30, do)


def asked(text: bytes, most_bytes: int = 1_000_000) -> list[dict[str, Any]]:
    answers = io.BytesIO()
    serve_lines(Service.of(["first-come"]), io.BytesIO(text), answers, most_bytes)
    return [json.loads(line) for line in answers.getvalue().splitlines()]


def test_answers_and_lines(state: dict[str, Any]) -> None:
    line = json.dumps(state).encode()
    first, second, third = asked(b"\n" + line + b"\r\nnonsense\n" + line)
    assert first == third
    assert (first["decides"], second["status"]) == ("POA", 400)
    line = json.dumps(state).encode()
    first, second = asked(b"x" * 5 * len(line) + b"\n" + line + b"\n", len(line))
    assert first["detail"] == f"request: found more than {len(line)} bytes; expected at most that many (`--max-mb`)"
    assert second["decides"] == "POA"
    assert [told["status"] for told in asked(b"x" * 9, 8)] == [413]


Serve = Callable[..., tuple[subprocess.Popen[str], int]]
EXTRA = ("starlette", "uvicorn", "prometheus_client", "swagger_ui_bundle")
WITHOUT = f"import sys; sys.modules.update(dict.fromkeys({EXTRA})); from rmfs_commands.cli.main import main; main()"


def post(port: int, content: bytes, path: str = "/decide") -> tuple[int, bytes]:
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=30)) as connection:
        connection.request("POST", path, content, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        return answer.status, answer.read()


def test_the_same_bytes_by_all_ways(serve: Serve, rmfs: tuple[str, ...], state: dict[str, Any]) -> None:
    arguments = ("--rule", "random", "--decides", "POA")
    content = json.dumps(state | {"seed": 5}).encode()
    _, port = serve(*arguments)
    other = json.dumps(state | {"seed": 6, "orders": {"Z": {"lines": {"jam": 1}}}}).encode()
    over_http = [post(port, content), post(port, other), post(port, content)]
    called = [
        subprocess.run((*rmfs, *words, *arguments), input=content + b"\n", capture_output=True, check=True).stdout
        for words in (("serve", "--stdio"), ("decide", "-"))
    ]
    assert over_http[0] == over_http[2] == (200, called[0])
    compact = json.dumps(json.loads(called[1]), separators=(",", ":"), ensure_ascii=False) + "\n"
    assert called[0] == compact.encode()


def test_closed_standard_input(rmfs: tuple[str, ...]) -> None:
    command = f"{shlex.join((*rmfs, 'serve', '--rule', 'first-come', '--stdio'))} <&-"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@cases("number ending", (signal.SIGINT, (130, "", "Interrupted.")), (signal.SIGTERM, (0, "", "")))
def test_it_ends_in_order(serve, number, ending, state) -> None:
    process, port = serve("--rule", "first-come")
    assert post(port, json.dumps(state).encode())[0] == 200
    process.send_signal(number)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out, err.strip()) == ending
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", port), timeout=1)


@pytest.mark.slow
def test_it_ends_in_order_in_the_middle_of_a_decision(serve: Serve, trouble: str, state: dict[str, Any]) -> None:
    process, port = serve("--rule", trouble)
    endless = json.dumps(state | {"orders": {"sleep": {"lines": {"jam": 1}}}}).encode()
    with ThreadPoolExecutor() as clients:
        asked = [clients.submit(post, port, endless) for _ in range(2)]
        while "rmfs_waiting 2.0" not in urlopen(f"http://127.0.0.1:{port}/metrics").read().decode():
            time.sleep(0.05)
        process.terminate()
        answers = [json.loads(one.result()[1]) for one in asked]
    assert [(told["status"], told["detail"]) for told in answers] == [(503, "the service ends")] * 2
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out, err) == (0, "", "")


def test_it_goes_on_after_a_decision_without_end(serve: Serve, trouble: str, state: dict[str, Any]) -> None:
    """504; then the next request is answered, by the rule loaded anew, to which a change means nothing."""
    _, port = serve("--rule", trouble, "--limit-s", "0.5")
    kept = json.loads(post(port, json.dumps({"warehouse": "w", "state": state}).encode())[1])
    endless = state | {"orders": {"sleep": {"lines": {"jam": 1}}}}
    assert post(port, json.dumps(endless).encode())[0] == 504
    change = {"warehouse": "w", "base": kept["revision"], "change": {}}
    answers = [post(port, json.dumps(change).encode()) for _ in range(20)]
    assert {status for status, _ in answers} <= {503, 409}
    assert answers[-1][0] == 409
    assert post(port, json.dumps(state).encode())[0] == 200


@pytest.fixture(scope="module")
def shared() -> Iterator[int]:
    code = "from rmfs_commands.cli.main import main; main()"
    command = (sys.executable, "-c", code, "serve", "--rule", "first-come", "--port", "0", "--max-mb", "0.1")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield int(process.stdout.readline().partition("; ")[0].rpartition(":")[2])
        process.terminate()


@settings(max_examples=40)
@given(st.binary(max_size=200), st.sampled_from([b"", b"POST /decide HTTP/1.1\r\n", b"GET "]))
def test_any_bytes_are_survived(shared: int, content: bytes, start: bytes) -> None:
    with socket.create_connection(("127.0.0.1", shared), timeout=10) as connection:
        connection.sendall(start + content)
        connection.shutdown(socket.SHUT_WR)
        answer = b""
        while part := connection.recv(65536):
            answer += part
    assert answer == b"" or answer.startswith((b"HTTP/1.1 4", b"HTTP/1.1 2"))
    assert post(shared, b"{}")[0] == 422


@cases(
    "arguments problem",
    (("--rule", "firstcome"), 'Error: --rule firstcome: there is no rule "firstcome"'),
    (("--rule", "first-come", "--set", "x=1", "--stdio"), "Error: --set x=1: "),
    (("--rule", "first-come", "--stdio", "--limit-s", "3"), "--limit-s is for HTTP; expected it without --stdio.\n"),
    (("--rule", "first-come", "--max-mb", "nan"), "'--max-mb': expected a number from 0.001 to 190, found nan\n"),
    (("--rule", "first-come", "--limit-s", "nan"), "'--limit-s': expected a number from 0.1 to 86,400, found nan\n"),
    (("--rule", "./a.py:A", "--no-inline-rules"), "--no-inline-rules refuses"),
    (("--rule", "./a.py:A", "--no-inline-rules", "--stdio"), "--no-inline-rules refuses"),
    (("--rule", "first-come", "--host", "nowhere.invalid"), "Error: --host nowhere.invalid --port 8750: cannot listen"),
    (("--rule", "first-come", "--host", "a..b"), "Error: --host a..b --port 8750: cannot listen there: "),
    ((), "Missing option '--rule' or '--hall'"),
    (("--stdio",), "Missing option '--rule' or '--hall'"),
)
def test_wrong_input(capfd: pytest.CaptureFixture[str], arguments: tuple[str, ...], problem: str) -> None:
    err = refused(capfd, main, ["serve", *arguments])
    assert problem in err and "Traceback" not in err


def test_without_the_extra(state: dict[str, Any]) -> None:
    command = (sys.executable, "-c", WITHOUT, "serve", "--rule", "first-come")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("Error: serve: needs further packages; expected `pip install 'rmfs[serve]'` (")
    lines = subprocess.run((*command, "--stdio"), input=json.dumps(state), capture_output=True, text=True, check=True)
    assert json.loads(lines.stdout)["decides"] == "POA"


def test_who_listens_to_all_is_told(serve: Serve) -> None:
    process, _ = serve("--rule", "first-come", "--host", "0.0.0.0")
    process.terminate()
    assert process.communicate(timeout=20)[1].startswith("Note: other machines reach this address; there is neither")


@pytest.mark.parametrize(("address", "loopback"), [("::1", True), ("::", False), ("fe80::1%eth0", False)])
def test_ipv6(address: str, loopback: bool) -> None:
    found = cast(socket.socket, SimpleNamespace(getsockname=lambda: (address, 80, 0, 0)))
    assert url_of(found) == f"http://[{address}]:80"
    assert is_loopback(found) == loopback


def test_ports_and_hosts_that_are_taken() -> None:
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(InputError, match=r"cannot listen there: .*ddress already in use"):
            listen("127.0.0.1", port)
    with listen("localhost", 0) as here:
        assert is_loopback(here)
        assert url_of(here).endswith(f":{here.getsockname()[1]}")
    with listen("0.0.0.0", 0) as everywhere:
        assert not is_loopback(everywhere)


Client = tuple[asyncio.StreamReader, asyncio.StreamWriter]
ASKED = b"GET / HTTP/1.1\r\nHost: here\r\n\r\n"


async def slow(_scope: Any, _receive: Any, send: Any) -> None:
    """Answer when longer has passed than a connection may be silent."""
    await asyncio.sleep(1.5)
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body"})


def with_server(do: Callable[[Callable[[], Awaitable[Client]]], Awaitable[None]]) -> None:
    async def run() -> None:
        config = uvicorn.Config(slow, log_config=None, timeout_keep_alive=1, lifespan="off")
        state = ServerState()
        server = await asyncio.get_running_loop().create_server(lambda: Connection(config, state, {}), "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        async with server:
            await do(lambda: asyncio.open_connection("127.0.0.1", port))

    asyncio.run(run())


@pytest.mark.parametrize("sent", [b"", b"GET / HT"])
def test_who_asks_nothing_is_not_waited_for(sent: bytes) -> None:
    async def do(connect: Callable[[], Awaitable[Client]]) -> None:
        reader, writer = await connect()
        writer.write(sent)
        assert await asyncio.wait_for(reader.read(), 20) == b""
        writer.close()

    with_server(do)


def test_no_more_than_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "MOST_CONNECTIONS", 2)

    async def do(connect: Callable[[], Awaitable[Client]]) -> None:
        taken = [await connect() for _ in range(2)]
        for _, writer in taken:
            writer.write(ASKED)
        more, its = await connect()
        assert await more.read() == b""
        its.close()
        for reader, writer in taken:
            assert (await reader.readline()).startswith(b"HTTP/1.1 204")
            writer.close()
            await writer.wait_closed()
        await asyncio.sleep(0.1)
        reader, writer = await connect()
        writer.write(ASKED)
        assert (await reader.readline()).startswith(b"HTTP/1.1 204")
        writer.close()

    with_server(do)


REFERENCE = Path(__file__).resolve().parents[4] / "docs" / "reference" / "service.md"


def test_the_reference_has_what_the_document_has_and_that_holds_together() -> None:
    text = REFERENCE.read_text(encoding="utf-8")
    document = openapi(["first-come"])
    for key in document["components"]["schemas"]["Request"]["properties"]:
        assert f"| `{key}` |" in text
    for status in document["paths"]["/decide"]["post"]["responses"].keys() - {"200"}:
        assert f"| {status} |" in text
    for path, methods in document["paths"].items():
        assert all(f"`{method.upper()} {path}`" in text for method in methods)
    for part in parts(document):
        if reference := part.get("$ref"):
            assert reference.removeprefix("#/components/schemas/") in document["components"]["schemas"]
        assert part.get("type") != "null" and "$schema" not in part
    assert json.loads(json.dumps(document)) == document


def parts(value: Any) -> Iterator[dict[str, Any]]:
    if isinstance(value, dict):
        yield value
        value = list(value.values())
    for entry in value if isinstance(value, list) else ():
        yield from parts(entry)


@cases("rule asked", ("first-come", {}), ("first-come", {"warehouse": "w"}), ("integrated", {}))
def test_requests_and_answers_are_as_it_says(rule: str, asked: dict[str, Any]) -> None:
    schemas = openapi([rule])["components"]["schemas"]
    orders = {name: order | {"due_s": 90} for name, order in SMALL["orders"].items()}
    request = asked | {"state": {**SMALL, "orders": orders}}
    assert request.keys() <= schemas["Request"]["properties"].keys()
    answer = json.loads(Service.of([rule]).answer(json.dumps(request).encode()).content)
    assert {"due", "outcome"} < answer.keys()
    jsonschema.validate(answer, schemas["Answer"] | {"additionalProperties": False})
    for kind in parts(schemas["Answer"]):  # nothing in an answer is of any type
        assert kind.get("type") != "object" or kind.get("properties") or kind.get("additionalProperties"), kind
    contents = schemas["State"]["properties"]["pods"]["additionalProperties"]["properties"]["contents"]
    assert contents["additionalProperties"] == {"type": "integer", "nullable": True}
