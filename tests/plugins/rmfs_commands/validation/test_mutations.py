"""Traces of runs of many kinds, corrupted in every way that `corruptions` knows: each corruption shows."""

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve, frozen

import rmfs_core
from cases import cases
from corruptions import KINDS, NotThereError, Raw
from rmfs_commands.cli.csv_writing import orders_csv, pods_csv
from rmfs_commands.validation import KINDS as ALL_FAULTS
from rmfs_commands.validation import check_trace
from rmfs_core.errors import InputError
from rmfs_core.world import make_instance

HALL = ("instance.orders=14", "instance.skus=12", "instance.pods=12")
SMALL = (*HALL, "layout.block_columns=2")
BASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "text map with one-way cells": ("examples/text-map", HALL),
    "windowed paths, pods at stations from the start, orders that are refilled": (
        "examples/small",
        (
            *SMALL,
            "seed=2",
            "robots.count=6",
            "rules.pp=whca-n",
            "rules.pr=random",
            "instance.pods_at_stations={1 = ['1', '2'], 2 = ['3']}",
            "instance.arrivals={process='refill', backlog=5}",
            "stations.release=handled",
            "stations.order_capacity=2",
        ),
    ),
    "finite stock, orders that arrive and are due": (
        "examples/small",
        (
            *SMALL,
            "instance.items_per_sku=12",
            "instance.arrivals={process='poisson', orders_per_hour=200}",
            "instance.due={allowance_s=300, spread_s=100, priority_share=0.3}",
            "rules.poa=earliest-due",
        ),
    ),
    "joint rule, robots that rest, pods that are carried elsewhere": (
        "examples/small",
        (
            *SMALL,
            *("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", "stations.item_capacity=5"),
            *(
                "rules.idle=rest-middle",
                "rules.move=utility",
                "instance.arrivals={process='poisson', orders_per_hour=150}",
            ),
        ),
    ),
    "order capacity, warm-up, orders left at the end": (
        "examples/small",
        (
            *SMALL,
            "instance.orders=30",
            "robots.count=5",
            "stations.order_capacity=[2, 3]",
            "run.until_s=200",
            "run.warmup_s=60",
            "rules.poa=first-come",
            "rules.pps=nearest-pod",
        ),
    ),
    "reorder points, pods with little room": (
        "examples/small",
        (
            *SMALL,
            "layout.stations_east=1",
            "layout.replenishment_west=1",
            "instance.orders=30",
            "instance.items_per_sku=3",
            "instance.pod_capacity=14",
            "instance.replenishment={process='reorder-point', reorder_point=3, order_up_to=8}",
            "instance.replenishment.bundle_items=3",
            "instance.replenishment.lead_s=60",
            "rules.roa=first-bundle",
            "rules.rps=emptiest-pod",
        ),
    ),
    "orders from files, some cancelled, robots that ignore each other": (
        "examples/from-csv",
        ("rules.pp=free-flow", "stations.item_capacity=3"),
    ),
    "stations that open and close, robots that come and go": (
        "examples/small",
        (
            *SMALL,
            'stations.open={1 = [["00:00", "00:01"]], 2 = [["00:01", "24:00"]]}',
            'robots.available=[["00:00", "00:02"], ["00:02", "24:00", 1]]',
        ),
    ),
    "packing stations with few boxes": (
        "examples/packing",
        (
            *SMALL,
            "instance.orders=24",
            "layout.block_rows=5",
            "packing={stations=2, boxes=2, packers=1, conveyor_s=20.0, pack_s=20.0}",
            "stations.item_capacity=6",
        ),
    ),
}
MAP, WINDOWS, STOCK, JOINT, PARTIAL, BUNDLES, FILES, HOURS, BOXES = BASES
MISSAID = ("dropped", "twice", "a second late")


@frozen
class Legitimate:
    """A corruption that need not show: in which of the runs, and why."""

    bases: frozenset[str]
    reason: str


LEGITIMATE = {
    "a wait that is none": Legitimate(
        frozenset({MAP, WINDOWS, STOCK, JOINT, PARTIAL, BUNDLES, HOURS, BOXES}),
        "a robot that waits for its run and one that rests before it stand in the same cell for the same time",
    ),
    "picks in another order": Legitimate(
        frozenset({WINDOWS, PARTIAL, BUNDLES}),
        "which of two open requests a pod serves first is for the simulation to choose, if no order ends otherwise",
    ),
    "a sku more on a pod": Legitimate(
        frozenset({FILES}), "what pods hold comes from a file, and it is enough for all picks either way"
    ),
    "other stock": Legitimate(
        frozenset({FILES}), "what pods hold comes from a file, and it is enough for all picks either way"
    ),
}

Recorded = Callable[[str], Path]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Return what makes the folder of a run, once each."""
    made: dict[str, Path] = {}

    def folder(name: str) -> Path:
        if name not in made:
            scenario, overrides = BASES[name]
            out = made[name] = tmp_path_factory.mktemp("base")
            if name == FILES:
                overrides = (*overrides, *cancelled(tmp_path_factory.mktemp("files")))
            result = rmfs_core.run(scenario, overrides=overrides, out=out, record=["trace"])
            assert result.status == ("horizon" if name == PARTIAL else "complete")
        return made[name]

    return folder


def cancelled(folder: Path) -> list[str]:
    """Write the orders and pods of a scenario, every other order cancelled a second after it came; name the files."""
    instance = make_instance(rmfs_core.load_scenario("examples/from-csv"))
    orders = tuple(
        evolve(order, cancelled_tick=order.arrival_tick + 1000 if number % 2 else None)
        for number, order in enumerate(instance.orders)
    )
    (folder / "orders.csv").write_text(orders_csv(evolve(instance, orders=orders)))
    (folder / "pods.csv").write_text(pods_csv(instance))
    return [f"instance.{what}_file={folder / what}.csv" for what in ("orders", "pods")]


def missed(folder: Path, kinds: list[str], tmp_path: Path) -> tuple[set[str], int]:
    """Return the kinds of corruption that did not show, and how many the trace had a place for."""
    raw = Raw.read(folder / "trace.jsonl.gz")
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    found, made = set(), 0
    for name in kinds:
        corrupted = raw.copy()
        try:
            KINDS[name](corrupted)
        except NotThereError:
            continue
        made += 1
        corrupted.write(tmp_path / "trace.jsonl.gz")
        try:
            if not check_trace(tmp_path).faults:
                found.add(name)
        except InputError:
            pass  # refused with a sentence, and exit code 2
    return found, made


def legitimate(base: str) -> set[str]:
    return {name for name, found in LEGITIMATE.items() if base in found.bases}


@pytest.mark.parametrize("base", BASES)
def test_some_corruptions_show(base: str, recorded: Recorded, tmp_path: Path) -> None:
    """A part of all kinds in each run, another one in each; as it was recorded, no run has a fault."""
    assert check_trace(recorded(base)).faults == []
    kinds = list(KINDS)[list(BASES).index(base) :: 2 * len(BASES)]
    found, made = missed(recorded(base), kinds, tmp_path)
    assert found == legitimate(base) & {*kinds}
    assert made >= 8


NAMED = (
    *((FILES, name, "cancelled") for name in KINDS if "cancellation" in name),
    (STOCK, "an assignment to another station", "not-assigned"),
    (STOCK, "an assignment before the arrival", "assigned-before-arrival"),
    (STOCK, "a decision of another rule", "rule"),
    (STOCK, "a decision of another status", "report"),
    (STOCK, "a lift by another robot", "robot-loaded"),
    (STOCK, "a task for another pod", "fetched-twice"),
    (WINDOWS, "an arrival of another order", "arrival"),
    (WINDOWS, "an arrival at the start", "arrival"),
    (WINDOWS, "an arrival after the next decision", "arrival"),
    (WINDOWS, "a completion a tick late", "completed-late"),
    (JOINT, "a bound above the objective", "bound"),
    (JOINT, "a robot that rests without being sent", "rested"),
    (JOINT, "a rest in the next cell", "rested"),
    (JOINT, "a robot sent to rest on the floor", "no-rest"),
    (JOINT, "a robot sent to rest where another stands", "no-rest"),
    (JOINT, "a trip of a pod that is carried elsewhere", "moved-bound"),
    (JOINT, "a pod carried to another location", "moved-elsewhere"),
    (HOURS, "the last assignment to another station", "station-closed"),
    (HOURS, "a task for a robot off duty", "off-duty"),
    *((HOURS, f"{what} {how}", "station-hours") for what in ("an opening", "a closing") for how in MISSAID),
    *((HOURS, f"a change of robots on duty {how}", "robot-hours") for how in MISSAID),
    (HOURS, "another number of robots on duty", "robot-hours"),
    (BUNDLES, "a bundle's arrival dropped", "bundle-arrival"),
    (BUNDLES, "a bundle's assignment dropped", "bundle-elsewhere"),
    (BUNDLES, "a bundle for another station", "bundle-capacity"),
    (BUNDLES, "a bundle's storing dropped", "left-early"),
    (BUNDLES, "other stock", "pod-capacity"),
    (BUNDLES, "an item lost in storing", "bundle-items"),
    (BUNDLES, "a bundle stored a tick faster", "store-time"),
    (BUNDLES, "a bundle stored in another visit", "no-visit"),
    *((BUNDLES, f"a bundle's {what} twice", "bundle-twice") for what in ("assignment", "choice of a pod", "storing")),
    (BUNDLES, "an order assigned that waits", "assigned-without-stock"),
    (BOXES, "a split order without a box", "packing-bound"),
    (BOXES, "a box that two orders have", "box"),
    (BOXES, "a part sent by another station", "tote"),
    (BOXES, "a arrival of a part a tick early", "conveyor-time"),
    (BOXES, "a part put a tick faster", "put"),
    (BOXES, "a part put with an item more", "consolidated"),
    (BOXES, "a consolidation of another order", "packed-early"),
    (BOXES, "a beginning to pack a tick early", "pack-time"),
    (BOXES, "a packing dropped", "not-packed"),
)


@cases("base name fault", *NAMED)
def test_corruptions_are_named(base: str, name: str, fault: str, recorded: Recorded, tmp_path: Path) -> None:
    corrupted = Raw.read(recorded(base) / "trace.jsonl.gz")
    KINDS[name](corrupted)
    corrupted.write(tmp_path / "trace.jsonl.gz")
    faults = check_trace(tmp_path).faults
    assert fault in {fault.kind for fault in faults}
    assert all(fault.kind in ALL_FAULTS and len(fault.sentence) > 20 for fault in faults)
    assert [fault.tick for fault in faults] == sorted(fault.tick for fault in faults)


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_every_corruption_shows(base: str, recorded: Recorded, tmp_path: Path) -> None:
    found, made = missed(recorded(base), list(KINDS), tmp_path)
    assert found == legitimate(base)
    assert made >= 170
