"""Joint rules alternating, two-stage, lns and pod-index; test_oracles.py has what they decide."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import pytest

import rmfs_rules.pod_index
from rmfs_commands.testing import small_world
from rmfs_core import run
from rmfs_rules.pod_index import PodIndex


def test_nothing_is_compiled_once_a_run_has_begun() -> None:
    """Prepared functions are those that decisions call, also with whole numbers for seconds and shares."""
    modules = [
        import_module(f"rmfs_rules.pod_index.{found.name}") for found in iter_modules(rmfs_rules.pod_index.__path__)
    ]
    searches = [called for module in modules for called in vars(module).values() if hasattr(called, "signatures")]
    PodIndex().prepare(small_world({"1": ["a"]}, {"p": ["a"]}).travel)
    before = [len(search.signatures) for search in searches]
    whole = [f"rules.poa_pps.{name}={value}" for name, value in {"visit_s": 300, "finish": 1, "due_factor": 1}.items()]
    run("examples/small", overrides=["rules.poa_pps=pod-index", *whole])
    assert any(before)
    assert [len(search.signatures) for search in searches] == before


def test_a_pod_is_sent_when_it_is_urgent_and_not_when_something_happens(tmp_path: Path) -> None:
    """A whole run: the second order comes at 10 s; a pick that takes 1,000 s is all that happens around 200 s."""
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,a,1\n2,10,b,1\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,9\nq,b,9\n", encoding="utf-8")
    files = [f"instance.{kind}_file={tmp_path / kind}.csv" for kind in ("orders", "pods")]
    slow = ["stations.pick_s=1000", "stations.handle_s=1000", "rules.pp=free-flow", "rules.poa_pps=pod-index"]
    slow.append("rules.poa_pps.urge_s=200")
    _, second = run("examples/from-csv", overrides=[*files, *slow]).orders
    assert second["turnover_backlog_s"] == 190.0


@pytest.mark.parametrize("parameters", [{}, {"packing_capacity": 1}])
def test_orders_with_long_lines_are_completed(tmp_path: Path, parameters: dict[str, Any]) -> None:
    """One line of four items at stations that take three, from two pods; then two such lines and a short one."""
    lines = ["1,0,A,4", "2,10,A,5", "2,10,B,7", "2,10,C,1", "3,10,C,2"]
    stock = [f"{pod},{sku},3" for pod in ("p", "q", "r") for sku in "ABC"]
    (tmp_path / "orders.csv").write_text("\n".join(["order,arrival_s,sku,quantity", *lines]), encoding="utf-8")
    (tmp_path / "pods.csv").write_text("\n".join(["pod,sku,quantity", *stock]), encoding="utf-8")
    files = [f"instance.{kind}_file={tmp_path / kind}.csv" for kind in ("orders", "pods")]
    given = [f"rules.poa_pps.{name}={value}" for name, value in parameters.items()]
    rules = ["rules.poa_pps=pod-index", *given, "rules.pp=free-flow", "stations.item_capacity=3"]
    result = run("examples/from-csv", overrides=[*files, *rules])
    assert result.status == "complete"
    assert result.orders[0]["parts"] == result.orders[0]["stations"].count(" ") + 1 == 1


@pytest.mark.parametrize("seed", [1, 2])
def test_fewer_visits_and_a_shorter_turn_over_than_the_sequential_rules(seed: int) -> None:
    """Few visits, on sixty orders of the paper's generator."""
    size = ["instance.orders=60", "instance.skus=30", "instance.pods=40", "rules.pp=free-flow"]
    usual = run("paper-250", seed=seed, overrides=size).metrics
    index = run("paper-250", seed=seed, overrides=[*size, "rules.poa_pps=pod-index"]).metrics
    assert index["psv_per_order"] < 0.5 * usual["psv_per_order"]
    assert index["turnover_s"] < usual["turnover_s"]
