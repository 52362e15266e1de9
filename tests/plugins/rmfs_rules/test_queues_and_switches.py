"""Rules that keep something from call to call: queues at stations, and which rule decides by now."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core import InputError, load_scenario, run
from rmfs_core.rules import RuleSet
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.station_queue import StationQueue
from rmfs_rules.switch import Case, Switch
from standing import assigned as decide
from standing import put_at_station


def assign(world: Warehouse, found: list[tuple[str, int]]) -> None:
    for name, station in found:
        order = next(order for order in world.orders if order.name == name)
        world.assign(order, world.stations[station], [line.sku for line in order.open_lines])


def test_orders_queue_where_their_items_are() -> None:
    orders = {"x": {"a": 2}, "1": ["a", "b"], "2": ["a"], "3": ["c"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["c"]}, capacities=[2, 2])
    world.bind(world.pods[0], world.stations[1])
    assign(world, [("x", 1)])
    rule = StationQueue(fast_lane=0)
    assert decide(world, rule) == [("3", 0)]
    assert rule.queue_of == {1: 1, 2: 1, 3: 0}
    assign(world, [("3", 0)])
    assert decide(world, rule) == []  # station 0 has a slot free, but nobody queues for it
    world, rule = small_world({"1": {"a": 2}, "2": ["b"]}, {"p": ["a", "b"]}, capacities=[2]), StationQueue()
    view = WarehouseView(world)
    rule.assign_orders(view.showing([]))
    assign(world, decide(world, rule))
    assert rule.queue_of == {0: 0, 1: 0}
    assert rule.assign_orders(view.showing([])) == []
    orders = {"old": ["z"], "soon": ["b"], "now": ["a"], "due": ["z"], "later": ["z"]}
    pods = {"p": ["a"], "q": ["b"], "r": ["z"]}
    world = small_world(orders, pods, capacities=[5], due_s={"due": 1000, "later": 1001})
    put_at_station(world, 0, 0)
    world.bind(world.pods[1], world.stations[0])
    world.now = 400_000
    assert [name for name, _ in decide(world, StationQueue(fast_lane=0))] == ["due", "now", "soon", "old", "later"]
    assert decide(world, StationQueue(fast_lane=0, urgent_s=0))[0] == ("now", 0)


@pytest.mark.parametrize("wrong", [{"queue_length": 0}, {"urgent_s": -1}, {"fast_lane": -1}])
def test_wrong_parameters_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="must be >="):
        StationQueue(**wrong)


def test_short_queues_conform() -> None:
    assert check_rule(StationQueue(queue_length=1)).findings == ()


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


def one_place(orders: int = 2) -> Warehouse:
    """Return a world with one slot, in which first-come takes order 0, and earliest-due the last one."""
    names = [str(i) for i in range(orders)]
    return small_world({name: ["a"] for name in names}, {"p": ["a"]}, capacities=[1], due_s={names[-1]: 9})


def test_it_wakes_up_when_another_rule_is_to_decide() -> None:
    rule = Switch((Case("first-come", before_s=60), Case("earliest-due")))
    for now, expected in ((0, "0"), (59_999, "0"), (60_000, "1")):
        made = one_place()
        made.now = now
        assert decide(made, rule) == [(expected, 0)]
    rule = Switch((Case("first-come", before_s=60), Case("random", before_s=90), Case("first-come")))
    made, rng = one_place(), np.random.default_rng(0)
    answers = []
    for now in (0, 59_999, 60_000, 90_000):
        made.now = now
        answers.append(rule.wake_at(WarehouseView(made), rng))
    assert answers == [60, 60, 90, None]
    rule = Switch((Case("station-queue", {"queue_length": 1}),))
    assert [decide(one_place(3), rule), decide(one_place(2), rule)] == [[("2", 0)], [("1", 0)]]
    rule = Switch((Case("assignment", before_s=60), Case("nearest-robot")))
    assert rule.libraries == ("rmfs", "scipy")
    assert (rule.needs, rule.splits_over_time) == ((), False)
    assert [role.label for role in rule.decides] == ["TA"]


def test_it_asks_as_the_rules_alone_are_asked(tmp_path: Path) -> None:
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


@cases(
    "cases problem",
    ("[]", "of which the last one has neither before_s nor backlog_below"),
    ('[{ rule = "first-come", before_s = 5 }]', "of which the last one has neither before_s nor backlog_below"),
    ('[{ rule = "first-cone" }]', r'cases\[0\].rule: there is no rule "first-cone" \(did you mean'),
    ('[{ rule = "./mine.py:Mine" }]', "expected an installed rule, found './mine.py:Mine'"),
    ('[{ rule = "first-come", befor_s = 5 }]', "cases"),
    ('[{ rule = "first-come", parameters = { patience = 5 } }]', r"cases\[0\].parameters.patience: .* no parameter"),
    ('[{ rule = "random", before_s = 5 }, { rule = "demand" }]', r'rule "switch" \(.*\) decides PPS, .* expected POA'),
    ('[{ rule = "random", before_s = 5 }, { rule = "nearest" }, { rule = "demand" }]', "rules that decide the same"),
    ('[{ rule = "integrated" }]', r"expected rules that decide the same, .*decides POA\+PPS"),
)
def test_wrong_cases_are_refused(tmp_path: Path, cases: str, problem: str) -> None:
    (tmp_path / "s.toml").write_text(SCENARIO.format(f'{{ rule = "switch", cases = {cases} }}'))
    with pytest.raises(InputError, match=problem) as caught:
        run(load_scenario(tmp_path / "s.toml"))
    assert "rules.poa" in str(caught.value)


WATCHING = """
@define
class Waves:
    @hookimpl
    def assign_orders(self, warehouse): return []
    @hookimpl
    def on_event(self, event): pass
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
    def assign_orders(self, warehouse): return []
    @hookimpl
    def wake_at(self, warehouse): return warehouse.now_s + 5
"""


def test_it_wakes_up_when_the_rule_that_decides_wants_to(install: Callable[..., None]) -> None:
    install("acme", {"tides": "acme_tides:Waves"}, acme_tides=WAKING)
    rule = Switch((Case("tides", before_s=60), Case("first-come")))
    made, rng = one_place(), np.random.default_rng(0)
    assert rule.wake_at(WarehouseView(made), rng) == 5
    made.now = 58_000
    assert rule.wake_at(WarehouseView(made), rng) == 60


def test_files_of_the_rules_parameters_are_beside_the_scenario(install: Callable[..., None], tmp_path: Path) -> None:
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
        assert decide(one_place(), bound.instance) == [("0", 0)]
    (tmp_path / "station.txt").unlink()
    expected = r"rules\.poa: .*cases\[0\]\.parameters\.file: there is no file .*station\.txt"
    with pytest.raises(InputError, match=expected):
        run(tmp_path / "s.toml")
