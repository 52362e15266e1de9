"""The sections of a scenario: defaults, and what does not go together."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import attrs
import pytest

from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.scenario import load_scenario
from rmfs_core.scenario.model import (
    DRAWN,
    GENERATED,
    Arrivals,
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
    replaced_keys,
)

ONE, OTHER = RuleChoice("one"), RuleChoice("other")
RULES = RulesSection(poa=ONE, pps=OTHER)
SECTIONS = (Arrivals, InstanceSection, LayoutSection, RobotsSection, RulesSection, RunSection, StationsSection)


def test_the_defaults_are_the_papers() -> None:
    """Section 4.1 and Appendix D of the paper: instance, grid, robots and stations."""
    scenario = Scenario(rules=RULES)
    instance, layout, robots, stations = scenario.instance, scenario.layout, scenario.robots, scenario.stations
    assert (instance.orders, instance.skus, instance.pods, instance.skus_per_pod) == (250, 100, 100, 3)
    assert layout.block_rows * layout.block_columns * 2 * layout.block_length == 504
    assert int(layout.pod_fill * 504) == 428
    assert (layout.stations_east + layout.stations_west, robots.count) == (4, 8)
    assert (stations.item_capacity, stations.queue_length, stations.pick_s, stations.handle_s) == (15, None, 7.0, 13.0)
    assert instance.items_per_sku is None
    motion = Motion()
    assert (robots.acceleration_m_per_s2, robots.top_speed_m_per_s) == (
        motion.acceleration_m_per_s2,
        motion.top_speed_m_per_s,
    )
    assert (robots.full_turn_s, robots.lift_s) == (motion.full_turn_s, motion.lift_s)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Arrivals("poisson"), 'expected `orders_per_hour` with process "poisson", and only there'),
        (lambda: Arrivals("start", 3.0), 'expected `orders_per_hour` with process "poisson", and only there'),
        (lambda: InstanceSection(orders_file="o.csv"), "expected `orders_file` and `pods_file` together, or neither"),
        (lambda: InstanceSection(pods_file="p.csv"), "expected `orders_file` and `pods_file` together, or neither"),
        (lambda: InstanceSection(skus=2), "expected skus_per_pod <= skus, found 3 > 2"),
        (lambda: StationsSection(handle_s=6.9), "expected handle_s >= pick_s, found 6.9 < 7.0"),
        (RulesSection, "expected `poa` and `pps`, or `poa_pps`"),
        (lambda: RulesSection(poa=ONE), "expected `poa` and `pps`, or `poa_pps`, found `poa` alone"),
        (lambda: RulesSection(pps=ONE), "expected `poa` and `pps`, or `poa_pps`, found `pps` alone"),
        (
            lambda: RulesSection(poa_pps=ONE, pps=OTHER),
            "expected either `poa_pps` or `poa` and `pps`, found both",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(make: Callable[[], object], message: str) -> None:
    """One sentence names the keys."""
    with pytest.raises(ValueError) as caught:
        make()
    assert str(caught.value) == message


def test_what_goes_together_is_accepted() -> None:
    """At the bounds: as many SKUs a pod as there are, the pod leaves when the item is handled, any SKUs of a file."""
    InstanceSection(skus=3, skus_per_pod=3)
    InstanceSection(skus=2, skus_per_pod=3, orders_file="o.csv", pods_file="p.csv")
    StationsSection(pick_s=13.0)
    Arrivals("poisson", 60.0)
    RulesSection(poa_pps=ONE)


def keys() -> Iterator[tuple[str, attrs.Attribute[Any]]]:
    """Yield every key of a section."""
    for section in (*SECTIONS, Scenario):
        for attribute in attrs.fields(section):
            if not attribute.metadata.get("internal"):
                yield f"{section.__name__}.{attribute.name}", attribute


def test_every_key_is_documented_with_its_unit() -> None:
    """What a key means stands beside it; a name that ends in a unit has that unit."""
    units = {"_s": "s", "_per_s": "m/s", "_per_s2": "m/s^2", "_per_hour": "1/h"}
    for name, attribute in keys():
        assert attribute.metadata["doc"], name
        ending = max((end for end in units if name.endswith(end)), key=len, default=None)
        if ending is not None:
            assert attribute.metadata["unit"] == units[ending], name


def test_keys_that_a_file_takes_the_place_of() -> None:
    """They exist, and are named only where the file is."""
    assert attrs.fields_dict(InstanceSection).keys() >= GENERATED
    assert attrs.fields_dict(LayoutSection).keys() >= DRAWN
    assert replaced_keys(InstanceSection(orders_file="o", pods_file="p")) == ("orders_file", GENERATED)
    refilled = InstanceSection(orders_file="o", pods_file="p", arrivals=Arrivals("refill", backlog=3))
    assert replaced_keys(refilled) == ("orders_file", GENERATED - {"arrivals"})
    assert replaced_keys(LayoutSection(map_file="m")) == ("map_file", DRAWN)
    for section in (InstanceSection(), LayoutSection(), RunSection()):
        assert replaced_keys(section) == ("", frozenset())


def test_another_seed_is_another_scenario_and_another_folder_is_not() -> None:
    """Where a scenario was read from is no part of what it says."""
    scenario = Scenario(rules=RULES, seed=1)
    assert scenario.with_seed(2).seed == 2
    assert scenario.with_seed(2).with_seed(1) == scenario
    assert scenario.with_seed(2) != scenario
    assert attrs.evolve(scenario, folder="elsewhere") == scenario


@pytest.mark.parametrize(
    ("setting", "problem"),
    [
        ("instance.orders=1000000000", "expected a whole number from 0 to 2,000,000, found 1000000000"),
        ("instance.orders=1000000000000000000", "expected a whole number from 0 to 2,000,000"),
        ("instance.pods=10000000000", "expected a whole number from 1 to 100,000"),
        ("robots.count=10000000000", "expected a whole number from 1 to 100,000"),
        ("layout.block_rows=100000", "expected at most 1,000,000 cells in all, found blocks and halls of about"),
        ("instance.lines=[" + "0," * 999 + "1]", "`lines` with weights from 0 to 1e9, not all 0 up to"),
        ("instance.items_per_sku=10000000000000000000", "expected a whole number from 1 to 1,000,000,000"),
        ("stations.queue_length=1000000000", "expected a whole number from 1 to 10,000"),
        ("layout.hall_width=1000000000000000000", "expected a whole number from 1 to 100,000"),
        ("instance.max_lines=10000000000000000000", "expected a whole number from 1 to 2,000,000"),
        ("instance.demand={exponent=1, groups=10000000000000000000}", "expected a whole number from 1 to 2,000,000"),
    ],
)
def test_what_no_memory_has_room_for_is_refused_at_once(setting: str, problem: str) -> None:
    """Before anything of it is made."""
    started = time.perf_counter()
    with pytest.raises(InputError, match=problem):
        load_scenario("examples/small", [setting])
    assert time.perf_counter() - started < 2


def test_many_skus_on_many_pods_are_refused() -> None:
    """Each number alone is one that there could be."""
    few = ["instance.skus=100000", "instance.skus_per_pod=100000"]
    assert load_scenario("examples/small", few).instance.skus == 100_000
    with pytest.raises(InputError, match="expected at most 8 GB of memory, found about 10 GB of"):
        load_scenario("examples/small", [*few, "instance.pods=400"])


def test_many_lines_of_many_orders_are_refused() -> None:
    """Their memory is estimated from the weights of the lengths; nothing is estimated of files."""
    long = ["instance.skus=1000", f"instance.lines=[{'0,' * 999}1]"]
    assert load_scenario("examples/small", [*long, "instance.orders=20000"]).instance.orders == 20_000
    with pytest.raises(InputError, match="expected at most 8 GB of memory, found about 605 GB of"):
        load_scenario("examples/small", [*long, "instance.orders=2000000"])
    with pytest.raises(InputError, match="as `profile`, not all 0"):
        load_scenario("examples/poisson", [f"instance.arrivals.profile=[{'0,' * 23}1e308]"])


def test_orders_that_arrive_over_centuries_are_refused() -> None:
    """Every hour from time 0 on is a row of hours.csv."""
    slow = "instance.arrivals.orders_per_hour=0.001"
    assert load_scenario("examples/poisson", [slow, "instance.orders=1000"]).instance.orders == 1000
    with pytest.raises(InputError, match="expected orders that arrive within 1,000,000 hours, found about 1,001,000"):
        load_scenario("examples/poisson", [slow, "instance.orders=1001"])


@pytest.mark.parametrize("key", ["filters", "observers"])
def test_more_rules_than_anybody_wants_are_refused(key: str) -> None:
    """Each is looked up and loaded on its own, which takes its time; fifty are no mistake."""
    rule = '"most-covered",'
    assert len(getattr(load_scenario("examples/small", [f"rules.{key}=[{50 * rule}]"]).rules, key)) == 50
    with pytest.raises(InputError, match="expected at most 50 `filters` and as many `observers`, found 51"):
        load_scenario("examples/small", [f"rules.{key}=[{51 * rule}]"])
