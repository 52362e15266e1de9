"""Instances are held against the scenario that they shall run in."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.world import make_instance

SCENARIO = """\
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
pods_at_stations = {at}
[stations]
item_capacity = [2, 3, 2, 1]
oversize = "refuse"
[rules]
poa = "pod-match"
pps = "demand"
"""

WRONG = [
    # a SKU that nobody has
    (
        "1,0,a,1\n2,0,a,1\n2,0,b,1\n",
        "p,a,\n",
        "{}",
        "{orders}, line 4: order 2 wants SKU b, which is on no pod",
    ),
    # more than there is
    (
        "1,0,a,2\n2,0,a,2\n",
        "p,a,1\nq,a,2\n",
        "{}",
        "{orders}, line 3: from order 2 on, the orders want more than all pods hold: SKU a (4 wanted, 3 there)",
    ),
    # too large for the largest station
    (
        "1,0,a,3\n2,0,a,4\n",
        "p,a,\n",
        "{}",
        "{orders}, line 3: order 2 has 4 items, more than any station takes at a time (3); "
        'expected a larger `stations.item_capacity` or `stations.oversize` = "alone"',
    ),
    # pods at stations
    (
        "1,0,a,1\n",
        "pod1,a,\n",
        '{ 1 = ["pod2"] }',
        "{file}, line 4, instance.pods_at_stations.1: there is no pod pod2 with contents (did you mean `pod1`?)",
    ),
    (
        "1,0,a,1\n",
        "p,a,\n",
        '{ 1 = ["p"], 2 = ["p"] }',
        "{file}, line 4, instance.pods_at_stations.2: pod p already stands at station 1",
    ),
]


def write(folder: Path, orders: str, pods: str, at: str = "{}") -> Path:
    """Write a scenario with its CSV files."""
    (folder / "orders.csv").write_text("order,arrival_s,sku,quantity\n" + orders, encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\n" + pods, encoding="utf-8")
    file = folder / "scenario.toml"
    file.write_text(SCENARIO.replace("{at}", at), encoding="utf-8")
    return file


@pytest.mark.parametrize(("orders", "pods", "at", "message"), WRONG)
def test_what_cannot_be_run_is_refused(orders: str, pods: str, at: str, message: str, tmp_path: Path) -> None:
    """An order nobody can pick, or an unknown pod at a station, is named before anything runs."""
    file = write(tmp_path, orders, pods, at)
    with pytest.raises(InputError) as caught:
        make_instance(load_scenario(file))
    expected = message.replace("{orders}", str(tmp_path / "orders.csv")).replace("{file}", str(file))
    assert str(caught.value) == expected


def test_unlimited_stock_on_one_pod_is_enough(tmp_path: Path) -> None:
    """A SKU that is unlimited on one pod never runs out."""
    instance = make_instance(load_scenario(write(tmp_path, "1,0,a,3\n2,0,a,3\n", "p,a,1\nq,a,\n", '{ 2 = ["q"] }')))
    assert len(instance.orders) == 2


def test_the_size_of_orders_does_not_matter_where_orders_are_counted(tmp_path: Path) -> None:
    """With an order capacity, an order may have any number of items."""
    file = write(tmp_path, "1,0,a,9\n", "p,a,\n")
    assert make_instance(load_scenario(file, ["stations.order_capacity=2"])).orders[0].items == 9


def test_orders_larger_than_any_station_may_go_to_one_alone(tmp_path: Path) -> None:
    """That is the default; only who asks for it has them refused."""
    file = write(tmp_path, "1,0,a,9\n", "p,a,\n")
    assert make_instance(load_scenario(file, ["stations.oversize=alone"])).orders[0].items == 9
    assert load_scenario("paper-250").stations.oversize == "alone"


def test_generated_orders_that_are_too_large_say_what_to_change() -> None:
    """A small station and long generated orders: the message names both keys."""
    with pytest.raises(InputError) as caught:
        make_instance(load_scenario("paper-250", ["stations.item_capacity=2", "stations.oversize=refuse"]))
    assert str(caught.value).endswith(
        "more, more than any station takes at a time (2); expected a smaller `instance.max_lines`, "
        'a larger `stations.item_capacity` or `stations.oversize` = "alone"'
    )


def test_example_2_is_the_papers() -> None:
    """The shipped example has the orders, pods and stations of the paper's example 2."""
    scenario = load_scenario("examples/example-2-sequential")
    instance = make_instance(scenario)
    orders = {order.name: {instance.skus[sku] for sku, _ in order.lines} for order in instance.orders}
    pods = {pod.name: {instance.skus[sku] for sku, _ in pod.contents} for pod in instance.pods}
    assert orders == {"1": set("vab"), "2": set("xab"), "3": set("ucd"), "4": set("ycd")}
    assert pods == {"1": set("xu"), "2": set("yv"), "3": set("vab"), "4": set("ucd")}
    assert scenario.instance.pods_at_stations == {"1": ("1",), "2": ("2",)}
    assert instance.unlimited_stock
