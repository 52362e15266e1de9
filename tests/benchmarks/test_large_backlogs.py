"""How long a call takes with 50,000 orders or 5,000 pods: rules read columns, and look at what counts alone."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pluggy
import pytest

import rmfs_core
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.simulation.asking import Asker

FIRST = 5
"""Periods that are left out: in the first ones the whole backlog joins."""


BARS_US = {10_000: 200, 50_000: 450}
"""Most time of a call for POA and one for PPS together, by the size of the backlog: `pod-match` and `demand`."""


def hold_to(benchmark: Any, run: Callable[[int], float], few: int, many: int, most: float, untimed: int) -> None:
    """Let a run with many take so many times the time of one with few; where nothing is timed, the last number do."""
    took = {few: run(few)} if benchmark.enabled else {}
    took[many] = benchmark.pedantic(run, args=(many if benchmark.enabled else untimed,), rounds=1)
    if benchmark.enabled:
        benchmark.extra_info["us"] = took
        assert took[many] <= most * took[few], took


def times_us(benchmark: Any, monkeypatch: pytest.MonkeyPatch, overrides: list[str], roles: tuple[Role, ...]) -> float:
    """Return the mean CPU time of a call in a run, summed over roles: of each call the shortest of two runs.

    Where nothing is timed, one run will do.
    """
    asked, runs = Asker.ask, []

    def ask(asker: Asker, rule: BoundRule, arguments: dict[str, Any], hook: pluggy.HookCaller | None = None) -> Any:
        begin = time.thread_time_ns()
        answer = asked(asker, rule, arguments, hook)
        if hook is None and rule.role in runs[-1]:
            runs[-1][rule.role].append(time.thread_time_ns() - begin)
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(Asker, "ask", ask)
        for _ in range(2 if benchmark.enabled else 1):
            runs.append({role: [] for role in roles})
            rmfs_core.run("paper-250", overrides=overrides)
    least = [np.min([run[role] for run in runs], axis=0)[FIRST:].mean() for role in roles]
    return float(np.sum(least)) / 1e3


SKUS = ["instance.skus=1000", "instance.skus_per_pod=12", "robots.count=16", "rules.pp=free-flow"]
BLOCKS = ["layout.block_rows=30", "layout.block_columns=22"]
JOINT = ("alternating", "two-stage", "lns")
"""Rules that assign orders and send pods at once."""
COUNTS = pytest.mark.parametrize("counts", [[], ["stations.order_capacity=6"]], ids=["items", "orders"])
"""Whether stations count items or orders."""


def run_of(benchmark: Any, monkeypatch: pytest.MonkeyPatch, rule: str, counts: list[str]) -> Callable[[int], float]:
    """Return what tells the time of a period in us by the size of a backlog that is refilled."""
    world = [*SKUS, "instance.pods=428", "run.until_s=600"]
    match rule:
        case "most-covered":
            rules, roles = ["rules.filters=[{rule='most-covered',n=20}]"], (Role.FILTER, Role.POA, Role.PPS)
        case "pod-index" | "alternating" | "two-stage" | "lns":
            rules, roles = [f"rules.poa_pps={rule}"], (Role.POA_PPS,)
        case _:
            rules, roles = [f"rules.poa={rule}", "rules.pps=demand"], (Role.POA, Role.PPS)

    def run(backlog: int) -> float:
        orders = [f"instance.orders={backlog + 2000}", f"instance.arrivals.backlog={backlog}"]
        told = [*world, *rules, *counts, "instance.arrivals.process=refill", *orders]
        return times_us(benchmark, monkeypatch, told, roles)

    return run


@COUNTS
def test_a_period_of_the_default_rules(benchmark: Any, monkeypatch: pytest.MonkeyPatch, counts: list[str]) -> None:
    """Bar: `BARS_US`; where nothing is timed, 500 orders do."""
    run = run_of(benchmark, monkeypatch, "pod-match", counts)
    took = benchmark.pedantic(lambda: [*map(run, BARS_US if benchmark.enabled else (500,))], rounds=1)
    if benchmark.enabled:
        benchmark.extra_info["us"] = took
        assert all(one <= most for one, most in zip(took, BARS_US.values(), strict=True)), took


@COUNTS
@pytest.mark.parametrize("rule", ["station-queue", *JOINT, "pod-index", "most-covered"])
def test_a_period_of_a_large_backlog(
    benchmark: Any, monkeypatch: pytest.MonkeyPatch, rule: str, counts: list[str]
) -> None:
    """Bar: ten times the orders take ten times as long at most; where nothing is timed, 500 orders do."""
    hold_to(benchmark, run_of(benchmark, monkeypatch, rule, counts), 5000, 50_000, 10, 500)


LARGE = {
    Role.POA_PPS: [
        *(f"rules.poa_pps.rule={rule} rules.poa_pps.max_wait_s=200" for rule in JOINT),
        "rules.poa_pps.rule=two-stage rules.poa_pps.first_orders=oldest",
    ],
    Role.POA: [
        *(f"rules.poa={rule} rules.poa.tie_break=random" for rule in ("first-come", "near-best-pod", "workload")),
        *("rules.poa=random", "rules.poa=random rules.poa.max_wait_s=200"),
        "rules.poa=pod-match rules.poa.late_first=true",
        "rules.poa=common-lines run.until_s=800",  # its orders have many lines, so that few calls are needed
    ],
    Role.PPS: [
        *(f"rules.pps=work-amount rules.pps.value={value}" for value in ("age", "lateness")),
        *(f"rules.pps={rule} rules.pps.count_backlog=true" for rule in ("completes", "lexicographic")),
        "rules.pps=completes rules.pps.count_backlog=true instance.items_per_sku=400",
    ],
}


@pytest.mark.parametrize(("role", "rule"), [(role, rule) for role, rules in LARGE.items() for rule in rules])
def test_a_call_of_a_large_backlog(benchmark: Any, monkeypatch: pytest.MonkeyPatch, role: Role, rule: str) -> None:
    """Bar: ten times the orders, all there at first, take ten times as long at most; untimed, 500 orders do."""
    due = "instance.due={allowance_s=400,spread_s=390}"
    world = [*SKUS, "instance.pods=428", due, "run.until_s=400", "stations.order_capacity=6", *rule.split()]

    def run(backlog: int) -> float:
        return times_us(benchmark, monkeypatch, [*world, f"instance.orders={backlog}"], (role,))

    hold_to(benchmark, run, 5000, 50_000, 10, 500)


MANY_PODS = {
    Role.PPS: ("demand", "random", "completes", "work-amount", "lexicographic", "nearest-pod"),
    Role.POA: ("near-best-pod",),
    Role.POA_PPS: JOINT,
    Role.PR: ("nearest", "station-based", "turnover-classes", "cache", "utility"),
}


@pytest.mark.parametrize(("role", "rule"), [(role, rule) for role, rules in MANY_PODS.items() for rule in rules])
def test_a_period_of_many_pods(benchmark: Any, monkeypatch: pytest.MonkeyPatch, role: Role, rule: str) -> None:
    """Bar: a call takes at most twice the time; where nothing is timed, 600 pods do."""
    world = [
        *(*SKUS, *BLOCKS, "instance.orders=3000", "run.until_s=300"),
        *("instance.arrivals.process=refill", "instance.arrivals.backlog=1000"),
        *([] if role is Role.POA_PPS else ["rules.poa=pod-match", "rules.pps=demand"]),
        f"rules.{role.value}={rule}",
    ]

    def run(pods: int) -> float:
        return times_us(benchmark, monkeypatch, [*world, f"instance.pods={pods}"], (role,))

    hold_to(benchmark, run, 500, 5000, 2, 600)


def times_of_new_us(monkeypatch: pytest.MonkeyPatch, overrides: list[str]) -> float:
    """Return the mean CPU time of those calls of PPS in a run before which a pod was given a SKU that it never held."""
    asked, entries = Asker.ask, [0]
    times: list[int] = []

    def ask(asker: Asker, rule: BoundRule, arguments: dict[str, Any], hook: pluggy.HookCaller | None = None) -> Any:
        begin = time.thread_time_ns()
        answer = asked(asker, rule, arguments, hook)
        took = time.thread_time_ns() - begin
        if hook is None and rule.role is Role.PPS:
            entries.append(len(arguments["warehouse"].stock.sku))
            if entries[-1] > entries[-2] > 0:
                times.append(took)
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(Asker, "ask", ask)
        rmfs_core.run("examples/replenished", overrides=overrides)
    return float(np.mean(times)) / 1e3


def test_a_pod_is_given_a_sku_that_it_never_held(benchmark: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bar: the next call of ``demand`` takes at most twice the time; where nothing is timed, 600 pods do."""
    world = [
        *(*SKUS, *BLOCKS, "instance.pod_capacity=100", "instance.orders=3000", "run.until_s=600"),
        "instance.arrivals={process='refill',backlog=1000}",
        "instance.replenishment={process='poisson',bundles_per_hour=600,bundle_items=2}",
    ]

    def run(pods: int) -> float:
        return times_of_new_us(monkeypatch, [*world, f"instance.pods={pods}"])

    hold_to(benchmark, run, 500, 5000, 2, 600)


WORLDS = {
    "grocery-day": ("grocery-day", ["rules.ta=nearest-robot"], 25_200),
    "10,000 orders": ("paper-250", ["instance.orders=10000"], 300),
}


@pytest.mark.parametrize("world", WORLDS)
def test_decisions_an_order(benchmark: Any, world: str) -> None:
    """Time that ``pod-index`` took, to the orders that were completed; where nothing is timed, the beginning will do.

    The aim is 1 ms on a machine that does nothing else; no run fails for that.
    """
    name, more, short_s = WORLDS[world]
    end_s = 8000 if world == "10,000 orders" else 10**6
    overrides = ["rules.poa_pps=pod-index", *more, f"run.until_s={end_s if benchmark.enabled else short_s}"]
    result = benchmark.pedantic(lambda: rmfs_core.run(name, overrides=overrides), rounds=1)
    orders = result.metrics["orders_completed"]
    assert orders > 0
    benchmark.extra_info["decisions_ms_an_order"] = 1000 * sum(one["seconds"] for one in result.periods) / orders
