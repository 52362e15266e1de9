"""Rules that keep something from call to call, and the switch between rules; test_oracles.py has what they decide."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from cases import cases
from rmfs_commands.testing import small_layout, small_world
from rmfs_core import InputError, load_scenario, run
from rmfs_core.rules import RuleSet
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.activation import BacklogThreshold
from rmfs_rules.classes import Cache, Utility
from rmfs_rules.switch import Case, Switch
from standing import assigned as decide


def active(rule: BacklogThreshold, warehouse: Warehouse) -> list[int]:
    chosen = list(rule.activate_stations(WarehouseView(warehouse)))
    for station in warehouse.stations:
        warehouse.activate(station, station.id in chosen)
    return chosen


def test_an_activation_rule_forgets_the_run_before() -> None:
    def waiting() -> Warehouse:
        return small_world({}, {"p": ["a"]}, capacities=[5] * 4)

    warehouse, rule = waiting(), BacklogThreshold()
    warehouse.advance(700_000)
    assert active(rule, warehouse) == [0, 1, 2]
    rule.run_started()
    assert active(rule, waiting()) == [0, 1, 2]


@pytest.mark.parametrize("rule", [Utility(retry_s=60), Cache(retry_s=60)])
def test_a_pause_of_moves_is_forgotten_in_another_run(rule: Utility | Cache) -> None:
    view = WarehouseView(small_world({}, {str(i): ["a"] for i in range(len(small_layout().storage_locations))}))
    assert rule.move_pods(view, 2) == []
    assert rule.wake_at(view) == 60
    assert rule.wake_at(WarehouseView(small_world({}, {"p": ["a"]}))) is None


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
    """Return a world with one slot, and orders of which the last one is due first."""
    names = [str(i) for i in range(orders)]
    return small_world({name: ["a"] for name in names}, {"p": ["a"]}, capacities=[1], due_s={names[-1]: 9})


def test_it_needs_what_its_rules_need_and_forgets_with_them() -> None:
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
