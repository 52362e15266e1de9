"""Rule switch."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core import InputError, load_scenario, run
from rmfs_core.rules import RuleSet
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.switch import Case, Switch

SCENARIO = """
seed = 1
[instance]
orders = 12
skus = 6
pods = 8
skus_per_pod = 2
[layout]
block_rows = 3
block_columns = 2
stations_east = 1
[robots]
count = 2
[rules]
pps = "demand"
pp = "free-flow"
poa = {}
"""


def decide(world: Warehouse, rule: Switch) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    given = rule.assign_orders(WarehouseView(world), np.random.default_rng(0))
    return [(world.orders[one.order].name, one.station) for one in given]


def world(orders: int = 2) -> Warehouse:
    """Return a world with one place, in which first-come takes order 0, and earliest-due the last one."""
    names = [str(i) for i in range(orders)]
    return small_world({name: ["a"] for name in names}, {"p": ["a"]}, capacities=[1], due_s={names[-1]: 9})


def test_rules_decide_by_the_time() -> None:
    """At 60 s the next one does."""
    rule = Switch((Case("first-come", before_s=60), Case("earliest-due")))
    for now, expected in ((0, "0"), (59_999, "0"), (60_000, "1")):
        made = world()
        made.now = now
        assert decide(made, rule) == [(expected, 0)]


def test_rules_decide_by_the_load() -> None:
    """Three orders are fewer than four."""
    rule = Switch((Case("first-come", backlog_below=4), Case("earliest-due")))
    assert decide(world(3), rule) == [("0", 0)]
    assert decide(world(4), rule) == [("3", 0)]


def test_rules_have_their_parameters() -> None:
    """Of a kind of its own each."""
    rule = Switch((Case("first-come", {"tie_break": "due"}, before_s=60), Case("first-come")))
    late = world()
    late.now = 60_000
    assert (decide(world(), rule), decide(late, rule)) == ([("1", 0)], [("0", 0)])


def test_it_asks_as_the_rules_alone_are_asked(tmp_path: Path) -> None:
    """A whole run, from a scenario file."""
    cases = {
        "alone": '"station-queue"',
        "always": '{ rule = "switch", cases = [{ rule = "station-queue" }] }',
        "never": '{ rule = "switch", cases = [{ rule = "first-come", before_s = 0.001 }, { rule = "station-queue" }] }',
        "parameters": '{ rule = "switch", cases = [{ rule = "station-queue", parameters = { queue_length = 1 } }] }',
    }
    results = {}
    for name, poa in cases.items():
        (tmp_path / f"{name}.toml").write_text(SCENARIO.format(poa))
        results[name] = run(load_scenario(tmp_path / f"{name}.toml"))
    assert results["always"].orders == results["alone"].orders
    assert results["never"].orders != results["alone"].orders
    assert results["parameters"].orders != results["alone"].orders
    assert results["always"].versions["rmfs"] == results["alone"].versions["rmfs"]


@pytest.mark.parametrize(
    ("cases", "problem"),
    [
        ("[]", "of which the last one has neither before_s nor backlog_below"),
        ('[{ rule = "first-come", before_s = 5 }]', "of which the last one has neither before_s nor backlog_below"),
        ('[{ rule = "first-cone" }]', r'cases\[0\].rule: there is no rule "first-cone" \(did you mean'),
        ('[{ rule = "./mine.py:Mine" }]', "expected an installed rule, found './mine.py:Mine'"),
        ('[{ rule = "first-come", befor_s = 5 }]', "cases"),
        (
            '[{ rule = "first-come", parameters = { patience = 5 } }]',
            r"cases\[0\].parameters.patience: .* no parameter",
        ),
        (
            '[{ rule = "random", before_s = 5 }, { rule = "demand" }]',
            r'rule "switch" \(.*\) decides PPS, .* expected POA',
        ),
        (
            '[{ rule = "random", before_s = 5 }, { rule = "nearest" }, { rule = "demand" }]',
            "rules that decide the same",
        ),
        ('[{ rule = "integrated" }]', r"expected rules that decide the same, .*decides POA\+PPS"),
    ],
)
def test_wrong_cases_are_refused(tmp_path: Path, cases: str, problem: str) -> None:
    """Before the run, with the place in the scenario."""
    (tmp_path / "s.toml").write_text(SCENARIO.format(f'{{ rule = "switch", cases = {cases} }}'))
    with pytest.raises(InputError, match=problem) as caught:
        run(load_scenario(tmp_path / "s.toml"))
    assert "rules.poa" in str(caught.value)


def test_what_rules_declare_counts() -> None:
    """Libraries of any, and the distributions that they come from."""
    rule = Switch((Case("assignment", before_s=60), Case("nearest-robot")))
    assert rule.libraries == ("rmfs", "scipy")
    assert (rule.needs, rule.splits_over_time) == ((), False)
    assert [role.label for role in rule.decides] == ["TA"]


def test_it_is_tried_as_what_its_rules_decide() -> None:
    """The conformance suite asks it nothing else."""
    report = check_rule(Switch((Case("nearest-robot"),)))
    assert (report.decides, report.findings) == (("TA",), ())


def test_it_wakes_up_when_another_rule_is_to_decide() -> None:
    """At 60 s, at 90 s, and then no more."""
    rule = Switch((Case("first-come", before_s=60), Case("random", before_s=90), Case("first-come")))
    made, rng = world(), np.random.default_rng(0)
    answers = []
    for now in (0, 59_999, 60_000, 90_000):
        made.now = now
        answers.append(rule.wake_at(WarehouseView(made), rng))
    assert answers == [60, 60, 90, None]


WATCHING = """
@define
class Waves:
    @hookimpl
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def on_event(self, event):
        pass
"""


def test_a_rule_that_observes_is_refused(install: Callable[..., None]) -> None:
    """It would be told of the whole run, but decide in a part of it."""
    install("acme", {"tides": "acme_tides:Waves"}, acme_tides=WATCHING)
    with pytest.raises(ValueError, match=r'cases\[0\].rule: rule "tides" \(acme 1.0\) observes the run, which'):
        Switch((Case("tides"),))


WAKING = """
@define
class Waves:
    @hookimpl
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def wake_at(self, warehouse):
        return warehouse.now_s + 5
"""


def test_it_wakes_up_when_the_rule_that_decides_wants_to(install: Callable[..., None]) -> None:
    """Every five seconds, until another one decides."""
    install("acme", {"tides": "acme_tides:Waves"}, acme_tides=WAKING)
    rule = Switch((Case("tides", before_s=60), Case("first-come")))
    made, rng = world(), np.random.default_rng(0)
    assert rule.wake_at(WarehouseView(made), rng) == 5
    made.now = 58_000
    assert rule.wake_at(WarehouseView(made), rng) == 60


def test_what_rules_remember_of_a_run_they_forget() -> None:
    """Order 2 of the first world, which was queueing, is none in the second."""
    rule = Switch((Case("station-queue", {"queue_length": 1}),))
    assert [decide(world(3), rule), decide(world(2), rule)] == [[("2", 0)], [("1", 0)]]


def test_files_of_the_rules_parameters_are_beside_the_scenario(install: Callable[..., None], tmp_path: Path) -> None:
    """Also when the rules are made anew for another run; the result names them with their digests."""
    source = """
from pathlib import Path
from rmfs_core import OrderAssignment

@define
class Mine:
    file: Path

    @hookimpl
    def assign_orders(self, warehouse):
        orders = [order for order in warehouse.backlog if order.items <= warehouse.stations[0].free_capacity]
        return [OrderAssignment(order.id, int(self.file.read_text())) for order in orders[:1]]
"""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    (tmp_path / "station.txt").write_text("0", encoding="utf-8")
    rule = '{ rule = "switch", cases = [{ rule = "mine", parameters = { file = "station.txt" } }] }'
    (tmp_path / "s.toml").write_text(SCENARIO.format(rule), encoding="utf-8")
    assert run(tmp_path / "s.toml").versions["station.txt"] == f"sha256:{sha256(b'0').hexdigest()}"
    loaded = load_scenario(tmp_path / "s.toml")
    bound = RuleSet.load(loaded.rules, loaded.folder).poa
    assert bound is not None
    for _ in range(2):
        assert decide(world(), bound.instance) == [("0", 0)]
    (tmp_path / "station.txt").unlink()
    expected = r"rules\.poa: .*cases\[0\]\.parameters\.file: there is no file .*station\.txt"
    with pytest.raises(InputError, match=expected):
        run(tmp_path / "s.toml")
