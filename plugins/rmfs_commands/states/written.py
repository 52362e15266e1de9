"""The format of answers: a rule's decision in a state as JSON, every key with its meaning and unit."""

# ruff: noqa: RUF009
# (`key` is attrs' `field` with its documentation: it makes a field, not a default.)

from __future__ import annotations

from collections.abc import Mapping

from attrs import frozen

from rmfs_core.errors import InputError
from rmfs_core.scenario.checks import key, within
from rmfs_core.scenario.source import Source
from rmfs_core.scenario.structuring import KeyProblem, structure_as
from rmfs_core.wording import shown_short


@frozen
class WrittenAssignment:
    """Lines of an order for a station."""

    order: str = key("The order")
    station: str = key("The station")
    skus: tuple[str, ...] | None = key("SKUs of the lines; left out: all open lines of the order", None)


@frozen
class WrittenTrip:
    """A pod for a station."""

    pod: str = key("The pod")
    station: str = key("The station")


@frozen
class WrittenTask:
    """A robot for a pod."""

    robot: str = key("The robot")
    pod: str = key("The pod")


@frozen
class WrittenBundle:
    """A bundle for a replenishment station."""

    bundle: str = key("The bundle")
    station: str = key("The station")


@frozen
class WrittenStore:
    """A pod for a bundle."""

    bundle: str = key("The bundle")
    pod: str = key("The pod")


@frozen
class WrittenRest:
    """A cell where a robot rests or charges."""

    robot: str = key("The robot")
    cell: int = key("The cell")
    charge: float | None = key("Share of the battery to charge to, at a charger", None)


@frozen
class WrittenMove:
    """A storage location for a stored pod."""

    pod: str = key("The pod")
    cell: int = key("The storage location")


@frozen
class WrittenPacking:
    """A packing station for an order."""

    order: str = key("The order")
    station: str = key("Packing station: its number, from 1")


@frozen
class WrittenReport:
    """The report of a solver."""

    status: str = key("`optimal`, `gap`, `effort` and the like: why the search ended")
    objective: float | None = key("Value of what was found", None)
    bound: float | None = key("No decision has a better value; left out: not known", None)
    stopped_early: bool = key("Whether the search ended before the proof", False)


@frozen
class WrittenOutcome:
    """The outcome of a decision."""

    orders: int | None = key("Orders that lines were assigned of", None)
    bundles: int | None = key("Bundles that were assigned to stations", None)
    items: int | None = key("Items assigned; of bundles: of those that a pod was chosen for", None)
    visits: int | None = key("New visits of pods to stations", None)
    unused: int | None = key("Capacity that stays free at the stations: items, orders or bundles", None)
    uncovered: int | None = key("Open requests that no inbound pod has an item for, afterwards", None)
    without_pod: int | None = key("Bundles at stations that no pod is chosen for, afterwards", None)


@frozen
class WrittenRepair:
    """Trips for requests that a joint decision leaves without a pod."""

    rule: str = key("PPS rule that decided them")
    trips: int = key("How many: the last of `trips`", 0)


@frozen
class WrittenPromise:
    """An open request, and what it is promised."""

    station: str = key("The station")
    order: str = key("The order")
    sku: str = key("The SKU")
    items: int = key("Items that are still to be picked", 1)
    pod: str | None = key("Inbound pod that they are promised from; left out: none has them", None)


@frozen
class WrittenPick:
    """The item that is picked next from a pod at a station."""

    station: str = key("The station")
    pod: str = key("The pod")
    order: str = key("The order")
    sku: str = key("The SKU")


@frozen
class WrittenArrival:
    """When a pod is expected at a station."""

    pod: str = key("The pod")
    station: str = key("The station")
    expected_s: float = key("When it would be there without other robots", unit="s")


@frozen
class WrittenDue:
    """The due time of an order."""

    due_s: float = key("When it is due", unit="s")
    priority: int = key("How urgent it is, higher first", 0)
    slack_s: float | None = key("Time left until then, negative: it is late", None, unit="s")


@frozen
class WrittenLeg:
    """A straight run of a path: wait, turn, drive to a cell and stop."""

    cell: int = key("The cell")
    wait_s: float = key("How long to wait before", 0.0, unit="s")


@frozen
class WrittenAnswer:
    """A rule's decision in a state; which keys it has depends on what was asked."""

    assignments: tuple[WrittenAssignment, ...] = key("POA, POA+PPS: orders for stations", ())
    trips: tuple[WrittenTrip, ...] = key("PPS, POA+PPS: pods for stations", ())
    tasks: tuple[WrittenTask, ...] = key("TA: robots for waiting pods", ())
    cell: int | None = key("PR: the storage location of `ask.pod`", None)
    bundles: tuple[WrittenBundle, ...] = key("ROA, ROA+RPS: bundles for stations", ())
    stores: tuple[WrittenStore, ...] = key("RPS, ROA+RPS: pods for bundles", ())
    active: tuple[str, ...] = key("activation: stations that take orders", ())
    rests: tuple[WrittenRest, ...] = key("idle: where robots rest or charge", ())
    moves: tuple[WrittenMove, ...] = key("repositioning: storage locations for pods", ())
    packing: tuple[WrittenPacking, ...] = key("packing: packing stations for `ask.orders`", ())
    task: int | None = key("packing-task: position of the task among waiting tasks, from 0", None)
    legs: tuple[WrittenLeg, ...] = key("PP: the path of `ask.robot`; none: there is no path, or it is there", ())
    rule: str | None = key("Name of the rule", None)
    distribution: str | None = key("Distribution that the rule comes from", None)
    version: str | None = key("Its version", None)
    decides: str | None = key("What was asked", None)
    report: WrittenReport | None = key("What a solver says of it", None)
    repair: WrittenRepair | None = key("POA+PPS: trips for requests that it left without a pod", None)
    outcome: WrittenOutcome | None = key("What it comes to", None)
    due: Mapping[str, WrittenDue] | None = key("Each decided order with a due time", None)
    waiting_for_stock: tuple[str, ...] = key("Orders that the rule did not see: the pods hold too little", ())
    promises: tuple[WrittenPromise, ...] = key("Where asked for: open requests and what they are promised", ())
    next: tuple[WrittenPick, ...] = key("Where asked for: what is picked next at the stations", ())
    arrivals: tuple[WrittenArrival, ...] = key("Where asked for: when pods are expected at stations", ())
    leaving: tuple[str, ...] = key("Where asked for: pods that may leave their station", ())
    warehouse: str | None = key("As in the request", None)
    revision: str | None = key("Revision of the state, the `base` of a change", None)
    ask_again_s: float | None = key(
        "Seconds until the next decision round, where none comes sooner; of a rule `remote`",
        None,
        unit="s",
        check=within(0.001, 1e9),
    )


def read_answer(data: object, name: str = "answer") -> WrittenAnswer:
    """Return the answer that JSON's objects, lists and values describe.

    Raises
    ------
    InputError
        For the first thing that is wrong in it. Whether names lead anywhere is seen when the answer is used.
    """
    if not isinstance(data, Mapping):
        raise InputError(name, f"expected a JSON object, found {shown_short(data)}")
    try:
        return structure_as(WrittenAnswer, data)
    except KeyProblem as problem:
        raise InputError(Source(name).place_of(problem.path), problem.problem) from None
