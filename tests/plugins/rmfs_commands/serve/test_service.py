"""Requests and answers, without a network: paths, statuses, states that are kept, and changes of them."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any, cast

import pytest
from attrs import define, field
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.results.files import to_json
from rmfs_commands.serve.app import MOST_WAITING, app_of
from rmfs_commands.serve.process import BusyError, EndedError, LateError, RuleProcess
from rmfs_commands.serve.service import SMALL, Reply, Service
from rmfs_commands.serve.warehouses import MOST_KEPT, StaleError, Warehouses
from rmfs_commands.states import decide, state_from_dict
from rmfs_commands.states.patches import patched
from rmfs_commands.states.state import ASKED
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

Answer = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def answered() -> Answer:
    """Return a function that asks a service: status, and what the answer says."""

    def ask(service: Service, request: Any) -> tuple[int, dict[str, Any]]:
        reply = service.answer(request if isinstance(request, bytes) else json.dumps(request).encode())
        assert reply.content.endswith(b"\n") and reply.content.count(b"\n") == 1
        return reply.status, json.loads(reply.content)

    return ask


@pytest.fixture(scope="module")
def service() -> Service:
    return Service.of(["first-come"])


def test_a_state_is_a_request(service: Service, state: dict[str, Any], answered: Answer) -> None:
    state["orders"]["\ud800"] = {"lines": {"jam": 1}}  # half a surrogate comes back as it came
    expected = json.loads(to_json(decide(state_from_dict(state), RuleChoice("first-come")).to_dict()))
    assert answered(service, state) == answered(service, {"state": state}) == (200, expected)


@cases(
    "request_ status place detail",
    (b"", 400, "request, line 1", "no valid JSON"),
    (b'{"a": 1, "a": 2}', 400, "request", "names 'a' twice"),
    (b"\xff", 400, "request", "UTF-8"),
    (b"[" * 100_000, 400, "request", ""),
    ([], 422, "request", "expected a JSON object, found []"),
    ({}, 422, "state, format", "no key `format`"),
    ({"format": "x" * 100_000}, 422, "state, format", "state, format: expected 'rmfs-state', found 'xxx"),
    ({"state": {}, "stat": 1}, 422, "request, stat", "did you mean `state`"),
    ({"rule": "first-come"}, 422, "request", "expected either `state` or `change`"),
    ({"change": {}, "warehouse": "w"}, 422, "request", "expected `warehouse` and `base` with `change`"),
    ({"state": {}, "base": "x"}, 422, "request", "found `base` with a whole state"),
    ({"change": [], "warehouse": "w", "base": ""}, 422, "request, change", "expected a table"),
    ({"state": {}, "rule": "first"}, 422, "request, rule", "did you mean `first-come`"),
    ({"change": {}, "warehouse": "w", "base": "x"}, 409, "request, warehouse", 'no state of "w" is kept'),
)
def test_what_is_wrong_with_a_request(service, answered, request_, status, place, detail) -> None:
    got, told = answered(service, request_)
    assert (got, told["status"], told["place"]) == (status, status, place)
    assert detail in told["detail"]
    assert len(told["detail"]) < 1_300


def test_several_rules(state: dict[str, Any], answered: Answer) -> None:
    service = Service.of(["first-come", '{ rule = "integrated", effort = 5 }'])
    assert answered(service, state)[1]["detail"] == "request, rule: is missing; expected first-come or integrated"
    status, told = answered(service, {"state": state, "rule": "integrated", "warehouse": "w"})
    assert (status, told["decides"], told["warehouse"]) == (200, "POA+PPS", "w")
    change = {"change": {}, "rule": "first-come", "warehouse": "w", "base": told["revision"]}
    assert answered(service, change)[1]["decides"] == "POA"


def test_a_change_is_enough(service: Service, state: dict[str, Any], answered: Answer) -> None:
    _, first = answered(service, {"warehouse": "w", "state": state})
    wrong = {"warehouse": "w", "base": first["revision"], "change": {"pods": None}}
    told = {"title": "Unprocessable Entity", "status": 422, "detail": "state, pods: this part is missing"}
    assert answered(service, wrong) == (422, told | {"place": "state, pods"})  # which is not kept
    request = wrong | {"change": {"orders": {"A": None, "C": {"lines": {"tea": 1}}}, "time_s": 7}}
    status, second = answered(service, request)
    assert status == 200 and second["revision"] != first["revision"]
    assert answered(service, request) == (200, second)  # who did not get the answer may ask again
    status, told = answered(service, request | {"change": {}})
    assert (status, told["place"]) == (409, "request, base")
    assert f'the last state is "{second["revision"]}"' in told["detail"]


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=8,
)


PATHS = "orders orders.A orders.A.lines pods pods.P1.contents pods.P1 stations.north stations.north.inbound time_s ask"
paths = st.sampled_from([tuple(path.split(".")) for path in (*PATHS.split(), "layout", "random", "seed")])


@settings(max_examples=80)
@given(paths, json_values)
def test_any_value_anywhere_gets_a_status(path: tuple[str, ...], value: Any) -> None:
    service = Service.of(["first-come"])
    state: dict[str, Any] = json.loads(json.dumps(SMALL)) | {"orders": {"A": {"lines": {"a": 1}}}}
    state["pods"] = {"P1": {"contents": {"a": 1}, "cell": 12}}
    state["stations"] = {"north": {"item_capacity": 3, "inbound": []}}
    del state["robots"], state["waiting"]
    good = json.dumps({"warehouse": "w", "state": state}).encode()
    base = json.loads(service.answer(good).content)["revision"]
    patch: Any = value
    for name in reversed(path):
        patch = {name: patch}
    changed = service.answer(json.dumps({"warehouse": "w", "base": base, "change": patch}).encode())
    assert changed.status in (200, 422), changed
    assert service.answer(good).status == 200


def test_a_rule_at_fault(trouble: str, state: dict[str, Any], answered: Answer) -> None:
    service = Service.of([trouble])
    status, told = answered(service, state | {"orders": {"raise": {"lines": {"jam": 1}}}})
    assert status == 500
    assert "assign_orders, at 0.000 s: raised ZeroDivisionError: nothing to divide" in told["detail"]
    assert answered(service, state)[0] == 200


@cases(
    "rules settings problem",
    (["firstcome"], [], r"^--rule firstcome: there is no rule"),
    (["integrated"], ["gap=-1"], r"^--set gap=-1: "),
    (["first-come", "integrated"], ["effort=1"], r"^--set effort=1: found 2 rules; expected one, or parameters in"),
    (["first-come", "first-come"], [], r"^--rule first-come: found this rule twice"),
    (["./mine.py:Mine"], [], r"--no-inline-rules refuses"),
    (["most-covered"], [], r"^--rule most-covered: .* decides filter; expected a rule for"),
)
def test_a_rule_that_cannot_be_had(rules: list[str], settings: list[str], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        Service.of(rules, settings, allow_inline=False)


def test_warming_up_asks_a_rule(trouble, capfd, monkeypatch) -> None:
    asked: list[Role] = []
    service = Service.of(["random"])
    monkeypatch.setattr("rmfs_commands.states.Decider.decide", lambda _self, state, *_: asked.append(state.ask.role))
    for _ in service.warm_up():
        pass
    assert asked == [*ASKED]
    monkeypatch.undo()
    for _ in Service.of(["random"]).warm_up():
        pass


RULES = ("pod-match", "workload", "first-come", "split-over-time", "integrated", "all")
SKUS, WANTED = ("a", "b", "c", "d"), {"lines": {"a": 1}}
HALL: dict[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "pods": {str(n): {"contents": {SKUS[n - 1]: 9, "a": 3}} for n in (1, 2, 3, 4)},
    "stations": {"1": {"item_capacity": 3, "inbound": ["1"]}, "2": {"order_capacity": 1}},
    "orders": {"1": {"lines": {"a": 2, "d": 1}}, "2": {"lines": {"b": 1, "c": 1}}, "3": WANTED},
}
one_sku, few = st.sampled_from(SKUS), st.integers(0, 3)
names = st.sampled_from("4567")


def some(**keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.fixed_dictionaries({}, optional=keys)


def of(**keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.fixed_dictionaries(keys)


parts = st.sampled_from(([], [{"station": "2", "skus": ["a"]}], [{"station": "1", "skus": ["a"], "period": 3}]))
wanted = of(lines=st.dictionaries(one_sku, st.integers(1, 3), max_size=2).map(lambda more: {"a": 1, **more}))
orders = st.tuples(
    wanted,
    some(arrival_s=st.integers(0, 9), due_s=st.just(50), priority=few, waits_for_stock=st.booleans(), parts=parts),
).map(lambda both: both[0] | both[1])
held = st.dictionaries(one_sku, few, max_size=2)
of_order_3 = st.sampled_from(([], [{"order": "3", "sku": "a"}], [{"order": "1", "sku": "d"}]))
inbound = st.sampled_from(([], ["1"], ["2", "1"]))
changes = some(
    orders=st.dictionaries(names, st.none() | orders, min_size=1, max_size=3),
    pods=st.dictionaries(names, of(contents=held), max_size=2),
    stations=some(**{"1": some(requests=of_order_3, inbound=inbound, item_capacity=st.sampled_from((3, 30)))}),
    time_s=st.integers(9, 20),
    backlog=st.none() | st.sampled_from((["2"], ["2", "4"])),
    skus=st.none() | st.just(["d", *SKUS[:3]]),
    sizes=st.none() | st.just({"a": 2}),
)
nulls = st.sampled_from(("motion", "reserved", "empty_pods", "seed", "ask", "chargers_down"))


@pytest.fixture(scope="module")
def ruled() -> Service:
    return Service.of(RULES)


def answer(asked: Service, **request: Any) -> tuple[int, bytes]:
    """Return status and content of an answer, without the state's revision."""
    reply = asked.answer(json.dumps(request).encode())
    told = json.loads(reply.content)
    content = reply.content
    for key in ("warehouse", "revision"):
        content = content.replace(f',"{key}":"{told.get(key)}"'.encode(), b"")
    return reply.status, content


FULL = {"orders": dict.fromkeys("456", WANTED)}
ANOTHER, ALL = {"orders": {"4": None, "7": WANTED}}, {"stations": {"1": {"item_capacity": 30}}}
WAITS: dict[str, Any] = {"orders": {"4": WANTED | {"waits_for_stock": True}}}


@example(
    steps=[(FULL, "first-come"), (ANOTHER, "first-come"), (ALL, "first-come")], null="seed"
)  # orders have other ids then
@example(steps=[(WAITS, "first-come"), ({"backlog": ["2", "4"]}, "first-come")], null="motion")
@settings(max_examples=25)
@given(steps=st.lists(st.tuples(changes, st.sampled_from(RULES)), min_size=4, max_size=12), null=nulls)
def test_a_change_is_answered_as_the_whole_state(
    ruled: Service, steps: list[tuple[dict[str, Any], str]], null: str
) -> None:
    state = HALL
    reply = ruled.answer(json.dumps({"warehouse": "w", "state": state, "rule": "pod-match"}).encode())
    base = json.loads(reply.content)["revision"]
    for change, rule in steps:
        content = json.dumps({"warehouse": "w", "base": base, "change": change, "rule": rule}).encode()
        whole = patched(state, change)
        expected = answer(ruled, state=whole, rule=rule)
        assert answer(ruled, warehouse="w", base=base, change=change, rule=rule) == expected
        refused = answer(ruled, state=whole | {null: None}, rule=rule)
        assert refused == answer(ruled, warehouse="w", state=whole | {null: None}, rule=rule)
        assert refused[0] == 422
        if expected[0] == 200:
            base, state = json.loads(ruled.answer(content).content)["revision"], whole


STATE: dict[str, Any] = {"pods": {"P": {"contents": {"tea": 2, "milk": None}}}, "orders": {"A": {}}}


@pytest.fixture
def kept() -> Warehouses:
    kept = Warehouses()
    kept.keep("w", "r1", STATE)
    return kept


def test_the_state_that_was_asked_for_least_lately_is_forgotten(kept: Warehouses) -> None:
    for i in range(MOST_KEPT - 1):
        kept.keep(str(i), "r1", STATE)
    kept.keep("w", "r2", STATE)
    kept.keep("one more", "r1", STATE)
    assert kept.changed("w", "r2", {}, "r3") == kept.changed("1", "r1", {}, "r2") == STATE
    with pytest.raises(StaleError, match='no state of "0" is kept; expected the whole state first'):
        kept.changed("0", "r1", {}, "r2")


@pytest.mark.parametrize("pod", ["P", "Q"])
def test_null_is_no_stock(kept: Warehouses, pod: str) -> None:
    """In a merge patch null takes away: a SKU that never runs out cannot be said, and is not lost without a word."""
    change = {"pods": {pod: {"contents": {"jam": None}}}}
    with pytest.raises(InputError, match=rf"^change, pods.{pod}.contents.jam: null removes a SKU"):
        kept.changed("w", "r1", change, "r2")
    taken = kept.changed("w", "r1", {"pods": {"P": {"contents": {"milk": None}}}}, "r2")
    assert taken["pods"]["P"] == {"contents": {"tea": 2}}


JSON = {"content-type": "application/json"}

SCOPE: dict[str, Any] = {
    **{"type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "scheme": "http"},
    **{"method": "POST", "path": "/decide", "root_path": "", "query_string": b""},
    "headers": [(b"content-type", b"application/json")],
}
"""Scope of a request, as a server tells an application."""


async def sent_by(app: Any, receive: Callable[[], Awaitable[Any]], **changes: Any) -> list[Any]:
    """Return the messages that an application sends to a server."""
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    await app(SCOPE | changes, receive, send)
    return sent


@define
class Scripted:
    answer: Reply | RmfsError = field(factory=lambda: Reply(200, b'{"decides":"POA"}\n'))
    pid: int | None = 1
    names: tuple[str, ...] = ("scripted",)
    restarts: int = 3
    limit_s: float = 5.0
    gate: asyncio.Event | None = None

    async def ask(self, content: bytes) -> Reply:
        if self.gate is not None:
            await self.gate.wait()
        if isinstance(self.answer, RmfsError):
            raise self.answer
        return self.answer


class Client:
    """Calls an application, with requests of at most so many bytes, by some names of its host, as a server does."""

    def __init__(self, process: Scripted, most_bytes: int = 1000, hosts: tuple[str, ...] | None = None) -> None:
        self.app = app_of(cast(RuleProcess, process), most_bytes, hosts)

    async def call(
        self, method: str, path: str, content: bytes = b"", headers: dict[str, str] | None = None, parts: int = 1
    ) -> tuple[int, dict[str, str], bytes]:
        """Return status, headers and content of an answer."""
        size = max(-(-len(content) // parts), 1)
        pieces = [content[i : i + size] for i in range(0, len(content), size)] or [b""]
        messages = [
            {"type": "http.request", "body": piece, "more_body": i + 1 < len(pieces)} for i, piece in enumerate(pieces)
        ]
        encoded = [(name.encode(), value.encode()) for name, value in (headers or {}).items()]

        async def receive() -> Any:
            return messages.pop(0) if messages else {"type": "http.disconnect"}

        sent = await sent_by(self.app, receive, method=method, path=path, headers=encoded)
        found = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
        return sent[0]["status"], found, b"".join(message.get("body", b"") for message in sent[1:])


def call(process: Scripted, *arguments: Any, **options: Any) -> tuple[int, dict[str, str], bytes]:
    return asyncio.run(Client(process).call(*arguments, **options))


@cases(
    "host status",
    ("localhost:8000", 200),
    ("[::1]:8000", 200),
    ("LOCALHOST", 200),
    ("example.org:8000", 421),
    ("", 421),
    ("[", 421),
)
def test_only_requests_for_this_host(host: str, status: int) -> None:
    """A web page cannot have a browser ask in its name, even if its own host's name leads here."""
    client = Client(Scripted(), hosts=("localhost", "::1"))
    got, _, content = asyncio.run(client.call("POST", "/decide", b"{}", {**JSON, "host": host}))
    assert got == status
    assert status == 200 or json.loads(content)["detail"] == f'"{host}" is not served here'


@cases(
    "accept",
    *("", "*/*", "application/json", ";,=;q=x", "\xff", "text/plain; version=1.0.0; escaping=allow-utf-8"),
    *("application/openmetrics-text; version=abc", "application/openmetrics-text;version"),
)
def test_figures_whatever_the_request_accepts(accept: str) -> None:
    status, headers, content = call(Scripted(), "GET", "/metrics", headers={"accept": accept})
    assert (status, headers["content-type"]) == (200, "text/plain; version=0.0.4; charset=utf-8")
    assert b"rmfs_restarts 3.0" in content


@cases(
    "method path headers content status detail",
    ("POST", "/decide", {}, b"{}", 415, 'found Content-Type ""; expected application/json'),
    ("POST", "/decide", {"content-type": "text/plain"}, b"{}", 415, "expected application/json"),
    ("POST", "/decide", JSON | {"content-length": "1001"}, b"", 413, "found more than 1,000 bytes"),
    ("POST", "/decide", JSON | {"content-length": "9" * 5000}, b"", 413, "found more than 1,000 bytes"),
    ("POST", "/decide", JSON, b" " * 1001, 413, "found more than 1,000 bytes"),
    ("GET", "/decide", {}, b"", 405, "GET /decide is not answered"),
    ("POST", "/health", {}, b"", 405, "POST /health is not answered"),
    ("GET", "/health/", {"host": "example.org"}, b"", 404, "there is nothing at /health/"),
    ("GET", "/nowhere", {}, b"", 404, "there is nothing at /nowhere"),
    ("GET", "/docs/files/nothing.js", {}, b"", 404, "there is nothing at"),
)
def test_what_is_wrong_with_a_call(method, path, headers, content, status, detail) -> None:
    got, found, told = call(Scripted(), method, path, content, headers, parts=3)
    assert (got, found["content-type"]) == (status, "application/problem+json")
    assert detail in json.loads(told)["detail"]
    assert ("allow" in found) == (status == 405)


def test_too_many_at_a_time() -> None:
    async def run() -> None:
        process = Scripted(gate=asyncio.Event())
        client = Client(process)
        waiting = [asyncio.create_task(client.call("POST", "/decide", b"{}", JSON)) for _ in range(MOST_WAITING)]
        await asyncio.sleep(0)
        status, headers, _ = await client.call("POST", "/decide", b"{}", JSON)
        assert (status, headers["retry-after"]) == (503, "1")
        cast(asyncio.Event, process.gate).set()
        assert {status for status, _, _ in await asyncio.gather(*waiting)} == {200}
        assert b'rmfs_answers_total{status="200"} 64.0' in (await client.call("GET", "/metrics"))[2]

    asyncio.run(run())


async def breaks_off() -> Any:
    return {"type": "http.disconnect"}


@cases("receive status", (lambda: asyncio.Event().wait(), 408), (breaks_off, 400), ids=["does not come", "breaks off"])
def test_a_request_that_is_not_whole(receive: Any, status: int) -> None:
    app = app_of(cast(RuleProcess, Scripted(limit_s=0.01)), 1000)
    assert asyncio.run(sent_by(app, receive))[0]["status"] == status


def test_health() -> None:
    assert call(Scripted(), "GET", "/health")[::2] == (200, b'{"status":"ok","rules":["scripted"]}')
    assert call(Scripted(pid=None), "GET", "/health")[0] == 503


def test_metrics() -> None:
    async def run() -> list[str]:
        client = Client(Scripted())
        await client.call("POST", "/decide", b"{}", JSON)
        await client.call("POST", "/decide", b"{}")
        status, headers, content = await client.call("GET", "/metrics")
        assert (status, headers["content-type"].partition(";")[0]) == (200, "text/plain")
        return content.decode().splitlines()

    lines = asyncio.run(run())
    for line in ('rmfs_answers_total{status="200"} 1.0', 'rmfs_answers_total{status="415"} 1.0', "rmfs_waiting 0.0"):
        assert line in lines
    assert {"rmfs_restarts 3.0", "rmfs_answer_seconds_count 2.0"} <= {*lines}
    assert any(line.startswith("rmfs_rules_process_resident_memory_bytes ") for line in lines)


def test_the_page_and_its_files() -> None:
    status, _, content = call(Scripted(), "GET", "/docs")
    page = content.decode()
    assert status == 200 and "//" not in page
    files = [part.split('"')[0] for part in page.split('"docs/')[1:]]
    assert len(files) == 3
    for file in files:
        assert call(Scripted(), "GET", f"/docs/{file}")[0] == 200
    assert call(Scripted(), "GET", "/")[1]["location"].endswith("/docs")
    assert json.loads(call(Scripted(), "GET", "/openapi.json")[2])["openapi"].startswith("3.")


@cases(
    "answer status more",
    (Reply(200, b'{"decides":"POA"}\n'), 200, {"content-type": "application/json"}),
    (Reply(422, b"{}\n"), 422, {}),
    (BusyError("busy"), 503, {"retry-after": "1"}),
    (EndedError("ended"), 503, {"retry-after": "1"}),
    (LateError("late"), 504, {}),
)
def test_what_the_process_says_is_answered(answer: Reply | RmfsError, status: int, more: dict[str, str]) -> None:
    of_type = {"content-type": "Application/JSON; charset=utf-8"}
    got, headers, content = call(Scripted(answer), "POST", "/decide", b"{}", of_type)
    assert got == status
    assert ({"content-type": "application/problem+json"} | more).items() <= headers.items()
    if isinstance(answer, RmfsError):
        assert json.loads(content)["detail"] == str(answer)
    else:
        assert content == answer.content
