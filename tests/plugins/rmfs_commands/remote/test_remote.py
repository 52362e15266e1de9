import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

import rmfs
from rmfs_commands.serve.service import Service
from rmfs_core.errors import InputError, RuleError
from tests.helpers.cases import cases
from tests.helpers.tiny import TINY


@contextmanager
def served(rule: str, **reply: Any) -> Iterator[str]:
    """Yield the address at which a rule is served; or where each question gets the same reply."""
    service = None if reply else Service.of([rule])

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_POST(self) -> None:
            asked = self.rfile.read(int(self.headers["Content-Length"]))
            told = service.answer(asked) if service else None
            content = told.content if told else json.dumps(reply["body"]).encode()
            self.send_response(told.status if told else reply["status"])
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/decide"
        finally:
            server.shutdown()
            thread.join()


def result_with(scenario: str, key: str, choice: str, folder: Path) -> tuple[str, str]:
    changed = rmfs.load_scenario(scenario, [f"rules.{key}={choice}", *SHORT.get(scenario, ())])
    rmfs.run(changed, out=folder)
    return tuple((folder / name).read_text() for name in ("orders.csv", "visits.csv"))  # type: ignore[return-value]


SHORT = {
    "examples/small": ["instance.orders=25"],
    "examples/replenished": ["instance.orders=20"],
    "examples/packing": ["instance.orders=16"],
    "examples/charging": ["run.until_s=40"],
}


@cases(
    "scenario key rule",
    ("examples/small", "poa", "pod-match"),
    ("examples/small", "pps", "completes"),
    ("examples/small", "pr", "nearest"),
    ("examples/small", "ta", "nearest-robot"),
    ("examples/packing", "poa_pps", "pod-index"),
    ("examples/packing", "packing", "least-reserved"),
    ("examples/packing", "packing_task", "pack-first"),
    ("examples/replenished", "rps", "emptiest-pod"),
    ("examples/charging", "idle", "charge-when-low"),
)
def test_a_rule_decides_the_same_behind_an_address(scenario: str, key: str, rule: str, tmp_path: Path) -> None:
    here = result_with(scenario, key, f'"{rule}"', tmp_path / "here")
    with served(rule) as url:
        assert result_with(scenario, key, f'{{ rule = "remote", url = "{url}" }}', tmp_path / "there") == here


PROGRAM = """
import json, sys
for line in sys.stdin:
    state = json.loads(line)["state"]
    assert state["ask"]["decides"] == "PR"
    taken = {pod.get("cell") for pod in state["pods"].values()} | {*state["reserved"]}
    homes = [pod["home"] for pod in state["pods"].values()]
    print(json.dumps({"cell": next(cell for cell in homes if cell not in taken)}), flush=True)
"""


def test_a_program_beside_the_scenario_decides(tmp_path: Path) -> None:
    (tmp_path / "homes.py").write_text(PROGRAM)
    scenario = tmp_path / "tiny.toml"
    choice = f"pr = {{ rule = 'remote', command = '{sys.executable}', file = 'homes.py' }}"
    scenario.write_text(TINY + choice)
    first = rmfs.run(rmfs.load_scenario(scenario), out=tmp_path / "first")
    assert first.status == "complete"
    assert any("homes.py" in key for key in first.versions)
    rmfs.run(rmfs.load_scenario(scenario), out=tmp_path / "again")
    assert (tmp_path / "first/visits.csv").read_bytes() == (tmp_path / "again/visits.csv").read_bytes()


def test_a_program_that_says_more_than_its_answer_is_found_at_the_next_question(tmp_path: Path) -> None:
    (tmp_path / "homes.py").write_text(PROGRAM.replace(", flush=True)", " + '\\n' + 'one more', flush=True)"))
    scenario = tmp_path / "tiny.toml"
    scenario.write_text(TINY + f"pr = {{ rule = 'remote', command = '{sys.executable}', file = 'homes.py' }}")
    with pytest.raises(RuleError, match=r"said 'one more' before it was asked; expected one line per"):
        rmfs.run(rmfs.load_scenario(scenario))


WAVES = """
import json, sys
for line in sys.stdin:
    state = json.loads(line)["state"]
    late = state["time_s"] % 100 < 1
    orders = [o for o, told in state["orders"].items() if not told["parts"]] if late else []
    station, free = "1", state["stations"]["1"]["item_capacity"] - len(state["stations"]["1"]["requests"])
    given = []
    for order in orders:
        items = sum(state["orders"][order]["lines"].values())
        if items <= free:
            given.append({"order": order, "station": station})
            free -= items
    print(json.dumps({"assignments": given, "ask_again_s": 100 - state["time_s"] % 100}), flush=True)
"""


def test_a_program_says_when_to_ask_again(tmp_path: Path) -> None:
    (tmp_path / "waves.py").write_text(WAVES)
    scenario = tmp_path / "tiny.toml"
    choice = f"{{ rule = 'remote', command = '{sys.executable}', file = 'waves.py' }}"
    arrivals = "[instance.arrivals]\nprocess = 'poisson'\norders_per_hour = 100\n[layout]"
    scenario.write_text(TINY.replace('"pod-match"', choice).replace("[layout]", arrivals))
    rmfs.run(rmfs.load_scenario(scenario), out=tmp_path / "out")
    rows = (tmp_path / "out/orders.csv").read_text().splitlines()
    at = rows[0].split(",").index("assigned_s")
    assert all(float(row.split(",")[at]) % 100 < 1 for row in rows[1:])


def failure(choice: str, key: str = "pps") -> str:
    with pytest.raises((RuleError, InputError)) as raised:
        rmfs.run(rmfs.load_scenario("examples/small", [f"rules.{key}={{ rule = 'remote', {choice} }}"]))
    return str(raised.value)


@cases(
    "choice said",
    ("command = 'no-such-program x'", "cannot start `no-such-program x`: there is no program no-such-program"),
    (f"command = '{sys.executable} -c exit(3)'", "ended with exit code 3 and without an answer"),
    (f"command = '{sys.executable} -c 1/0'", "and said 'ZeroDivisionError: division by zero'"),
    (f"command = '{sys.executable} -c input();print();input()'", "this is no valid JSON"),
    (
        f"command = '{sys.executable} -c \"import time; time.sleep(60)\"', timeout_s = 0.2",
        "gave no answer within 0.2 s",
    ),
    ("url = 'http://127.0.0.1:9/decide'", "gave no answer: Connection refused"),
    ("url = 'file:///x'", "expected an address such as"),
    ("command = 'x', url = 'http://x'", "expected either `url` or `command`"),
    ("url = 'http://x', file = 'x'", "there is no file"),
    ("command = ' '", "`command` is empty"),
)
def test_a_program_that_does_not_answer(choice: str, said: str) -> None:
    assert said in failure(choice)


@cases(
    "status body said",
    (200, {"trips": [{"pod": "X", "station": "1"}]}, 'named pod "X", which is not there'),
    (200, {"trips": [{"pod": "1"}]}, "answer, trips[0].station"),
    (200, {"trip": []}, "answer, trip: unknown key (did you mean `trips`?)"),
    (200, [], "answer: expected a JSON object"),
    (200, {"status": 422, "detail": "No."}, "the program refuses the request: No."),
    (503, {"detail": "Too many."}, "answered with status 503: Too many."),
    (404, [], "answered with status 404"),
)
def test_a_wrong_answer(status: int, body: Any, said: str) -> None:
    with served("", status=status, body=body) as url:
        assert said in failure(f"url = '{url}'")


def test_no_other_program_decides_where_code_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RMFS_NO_INLINE_RULES", "1")
    assert "--no-inline-rules refuses" in failure("url = 'http://127.0.0.1:9'")


def test_an_answer_without_what_was_asked_for() -> None:
    with served("", status=200, body={}) as url:
        assert "answered without `cell`" in failure(f"url = '{url}'", "pr")
