"""What a run's decisions meant for one order or one pod: told from the recorded states."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from attrs import define, frozen

from rmfs_commands.states.recorded import Recorded
from rmfs_core.roles import Role
from rmfs_core.world.grid import where

Content = Mapping[str, Any]


@frozen
class Episode:
    """Something that happened to an order or a pod, or that went on for some time.

    Parameters
    ----------
    number
        Number of the (first) decision.
    periods
        First and last period.
    times_s
        Time of the first and the last decision.
    decides, rule
        Who decided.
    what
        In words.
    """

    number: int
    periods: tuple[int, int]
    times_s: tuple[float, float]
    decides: Role
    rule: str
    what: str


@define
class _Waiting:
    """Decisions one after another in which an order waited for the same reason."""

    first: Recorded
    last: Recorded
    reason: str

    def episode(self) -> Episode:
        first, last = self.first, self.last
        return Episode(
            first.number,
            (first.period, last.period),
            (first.time_s, last.time_s),
            first.decides,
            first.rule,
            self.reason,
        )


def order_story(decisions: Iterable[Recorded], order: str) -> Iterator[Episode]:
    """Tell why an order waited, where its lines were assigned, and which pods were sent for them."""
    waiting: _Waiting | None = None
    without_stock: _Waiting | None = None
    for decision in decisions:
        if order not in decision.content["orders"]:
            continue
        given = decision.content["orders"][order]
        if given.get("waits_for_stock"):
            without_stock = without_stock or _Waiting(decision, decision, "")
            without_stock.last = decision
            without_stock.reason = f"waits for stock since {given['arrival_s']:,.0f} s"
            continue
        if without_stock is not None:
            since = f"waited for stock from {given['arrival_s']:,.0f} s"
            without_stock.reason = f"{since} to {decision.time_s:,.0f} s"
            yield without_stock.episode()
            without_stock = None
        here = [_episode(decision, what) for what in _done_for(decision, order)]
        reason = None
        if decision.decides.assigns:
            reason = _why_waiting(decision, order)
            if waiting is not None and (reason != waiting.reason or here):
                yield waiting.episode()
                waiting = None
        yield from here
        if reason is not None:
            waiting = waiting or _Waiting(decision, decision, reason)
            waiting.last = decision
    for left in (without_stock, waiting):
        if left is not None:
            yield left.episode()


def pod_story(decisions: Iterable[Recorded], pod: str) -> Iterator[Episode]:
    """Tell where a pod was sent, which robot fetched it, and where it was stored."""
    for decision in decisions:
        content, decided = decision.content, decision.decision or {}
        for trip in decided.get("trips", ()):
            if trip["pod"] == pod:
                yield _episode(decision, f"sent to station {trip['station']}{_serves(decision, trip)}")
        for task in decided.get("tasks", ()):
            if task["pod"] == pod:
                yield _episode(decision, f"robot {task['robot']} fetches it")
        for store in decided.get("stores", ()):
            if store["pod"] == pod:
                yield _episode(decision, f"chosen for bundle {store['bundle']}{_brings(content, store)}")
        for move in decided.get("moves", ()):
            if move["pod"] == pod:
                yield _episode(decision, f"carried to {where_in(content, move['cell'])}, without a visit")
        if content["ask"].get("pod") == pod and "cell" in decided:
            yield _episode(decision, f"stored at {where_in(content, decided['cell'])}")


def where_in(content: Content, cell: int) -> str:
    """Say where a cell of a recorded state is: row and column, counted from 1."""
    return where(cell, max(map(len, content["layout"]["map"])))


def open_lines(content: Content, order: str) -> dict[str, int]:
    """Return the lines of an order that are not assigned, and their numbers of items."""
    given = content["orders"][order]
    assigned = {sku for part in given["parts"] for sku in part["skus"]}
    return {sku: n for sku, n in given["lines"].items() if sku not in assigned}


def free_capacity(content: Content, station: str) -> int:
    """Return what a station has room for: items, or orders with order capacity; nothing while it is closed."""
    given = content["stations"][station]
    if not is_open(given):
        return 0
    parts = {(r["order"], _part_of(content, station, r)): r["order"] for r in _kept(given)}
    if "order_capacity" in given:
        return int(given["order_capacity"] - len({order for order, _ in parts}))
    items = 0
    for order, part in parts:
        lines = content["orders"][order]["lines"]
        items += sum(lines[sku] for sku in content["orders"][order]["parts"][part]["skus"])
    return max(int(given["item_capacity"] - items), 0)


def is_open(station: Content) -> bool:
    """Return whether a station takes work."""
    return bool(station.get("staffed", True) and station.get("active", True))


def _kept(station: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return what takes up room at a station: its requests, and the item that is picked and not yet handled."""
    return [*station["requests"], *([station["in_hand"]] if "in_hand" in station else [])]


def _part_of(content: Content, station: str, request: Mapping[str, Any]) -> int:
    """Return which part of an order a request belongs to: each line is in one part."""
    parts = content["orders"][request["order"]]["parts"]
    return next(i for i, part in enumerate(parts) if part["station"] == station and request["sku"] in part["skus"])


def _episode(decision: Recorded, what: str) -> Episode:
    period, time_s = decision.period, decision.time_s
    return Episode(decision.number, (period, period), (time_s, time_s), decision.decides, decision.rule, what)


def _done_for(decision: Recorded, order: str) -> Iterator[str]:
    """Yield what a decision did for an order."""
    decided, content = decision.decision or {}, decision.content
    wanted: dict[str, set[str]] = {}
    assigned = [given for given in decided.get("assignments", ()) if given["order"] == order]
    left = len(open_lines(content, order)) - sum(len(given["skus"]) for given in assigned)
    for given in assigned:
        wanted.setdefault(given["station"], set()).update(given["skus"])
        last = left and given is assigned[-1]
        rest = f"; {left} of its lines {'stays' if left == 1 else 'stay'} in the backlog" if last else ""
        yield f"assigned to station {given['station']}: {_skus(given['skus'])}{rest}"
    for station, given in content["stations"].items():
        for request in given["requests"]:
            if request["order"] == order and "pod" not in request:
                wanted.setdefault(station, set()).add(request["sku"])
    for trip in decided.get("trips", ()):
        held = content["pods"][trip["pod"]]["contents"]
        skus = [sku for sku in sorted(wanted.get(trip["station"], ())) if sku in held]
        if skus:
            yield f"pod {trip['pod']} sent to station {trip['station']}: it holds {_skus(skus)}"


def _why_waiting(decision: Recorded, order: str) -> str | None:
    """Say why all open lines of an order stay in the backlog; None when there are none, or some do not."""
    content, decided = decision.content, decision.decision
    lines = open_lines(content, order)
    given = (decided or {}).get("assignments", ())
    if not lines or any(assignment["order"] == order for assignment in given):
        return None
    if decided is None:
        return "the rule decided nothing valid, which ended the run"
    if order not in content.get("backlog", (order,)):
        return "the prefilters left it out"
    return _why_not_chosen(content, lines, "preferred others" if given else "assigned nothing")


def _why_not_chosen(content: Content, lines: Mapping[str, int], did: str) -> str:
    picking = [
        name for name, given in content["stations"].items() if "item_capacity" in given or "order_capacity" in given
    ]
    room = {name: free_capacity(content, name) for name in picking}
    counts_orders = {name for name, station in content["stations"].items() if "order_capacity" in station}
    items = sum(lines.values())
    if any(free >= (1 if name in counts_orders else items) for name, free in room.items()):
        return f"it fitted a station, but the rule {did}"
    n_closed = sum(not is_open(content["stations"][name]) for name in picking)
    if n_closed == len(picking):
        return "all stations were closed"
    no_room = f"no {'open ' if n_closed else ''}station had room for its {items} open item{'s' if items > 1 else ''}"
    # What a rule that splits orders could have done, too; whether this one does, the recording does not tell.
    some = any(free >= min(lines.values()) for name, free in room.items() if name not in counts_orders)
    return f"{no_room}, only for some of them" if some else no_room


def _serves(decision: Recorded, trip: Mapping[str, str]) -> str:
    """Say what a pod is sent for: the SKUs that are requested and uncovered at the station, or assigned with it."""
    content, decided = decision.content, decision.decision or {}
    held = content["pods"][trip["pod"]]["contents"]
    wanted = {r["sku"] for r in content["stations"][trip["station"]]["requests"] if "pod" not in r}
    for given in decided.get("assignments", ()):
        if given["station"] == trip["station"]:
            wanted.update(given["skus"])
    skus = [sku for sku in held if sku in wanted]
    return f": it holds {_skus(skus)}" if skus else ""


def _brings(content: Content, store: Mapping[str, str]) -> str:
    """Say what a bundle has, as far as the state tells of it."""
    told = [one for one in content.get("bundles", ()) if one["name"] == store["bundle"]]
    return "".join(f": {one['items']} of SKU {one['sku']}" for one in told)


def _skus(names: Sequence[str]) -> str:
    return f"SKU{'s' if len(names) > 1 else ''} {', '.join(names)}"
