"""The decisions of a run about one order or one pod: told from the recorded states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

from attrs import define, field, frozen

from rmfs_commands.states.rebuilding import OpenState, open_state
from rmfs_commands.states.recorded import Recorded
from rmfs_commands.states.state import FORMAT, VERSIONS
from rmfs_commands.states.state_json import state_from_dict
from rmfs_core.roles import Role
from rmfs_core.warehouse import Order, WarehouseView
from rmfs_core.world.grid import where

Content = Mapping[str, Any]

_OF_STATIONS = {"item_capacity", "order_capacity", "staffed", "active", "in_service"}
"""Attributes of a station that determine its free capacity, besides what is assigned there."""

LONG_S = 600
"""From so many seconds on it is told that no rule was asked: it is not while stations are full, mostly for less."""


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


def _folded(waits: Sequence[_Waiting]) -> Iterator[_Waiting]:
    """Yield waits one after another; those for reasons that return are one, with all of these reasons."""
    at = 0
    while at < len(waits):
        last = max(i for i, one in enumerate(waits) if one.reason == waits[at].reason)
        reasons = dict.fromkeys(one.reason for one in waits[at : last + 1])
        while len(reasons) > 1 and last + 1 < len(waits) and waits[last + 1].reason in reasons:
            last += 1
        told = f"{'in turn: ' if len(reasons) > 1 else ''}{'; '.join(reasons)}"
        yield _Waiting(waits[at].first, waits[last].last, told)
        at = last + 1


@define
class _Story:
    """Decisions about an order, one by one."""

    order: str
    waits: list[_Waiting] = field(factory=list)
    without_stock: _Waiting | None = None
    assigned: Recorded | None = None
    asked_s: float | None = None
    last: Recorded | None = None
    gone: bool = False

    def tell(self, decision: Recorded) -> Iterator[Episode]:
        """Yield what a decision ends or is for the order."""
        if self.gone or self.order not in decision.content["orders"]:
            return
        if self.assigned is not None:
            for what in _inbound_for(self.assigned, decision.content, self.order):
                yield _episode(self.assigned, what)
            self.assigned = None
        given = decision.content["orders"][self.order]
        if given.get("waits_for_stock"):
            self.without_stock = self.without_stock or _Waiting(decision, decision, "")
            self.without_stock.last = decision
            self.without_stock.reason = f"waits for stock since {given['arrival_s']:,.0f} s"
            return
        if self.without_stock is not None:
            since = f"waited for stock from {given['arrival_s']:,.0f} s"
            self.without_stock.reason = f"{since} to {decision.time_s:,.0f} s"
            yield self.without_stock.episode()
            self.without_stock, self.asked_s = None, decision.time_s
        if given.get("cancelled"):
            yield from self.end()
            self.gone, self.last = True, None
            yield _episode(decision, f"cancelled before {decision.time_s:,.0f} s, with nothing of it assigned")
            return
        self.last = decision
        here = [_episode(decision, what) for what in _done_for(decision, self.order)]
        if any(one["order"] == self.order for one in (decision.decision or {}).get("assignments", ())):
            self.assigned = decision
        reason = None
        if decision.decides.assigns:
            told = self._unasked(given, decision.time_s)
            self.asked_s = decision.time_s
            reason = _why_waiting(decision, self.order)
            if told or here:
                yield from self._waited()
            if told:
                yield _episode(decision, told)
        yield from here
        if reason is not None:
            if not self.waits or self.waits[-1].reason != reason:
                self.waits.append(_Waiting(decision, decision, reason))
            self.waits[-1].last = decision

    def _unasked(self, given: Content, now_s: float) -> str | None:
        """Say that until now no rule was asked to assign the order, where that is worth saying."""
        if self.asked_s is not None:
            told = f"between {self.asked_s:,.0f} s and {now_s:,.0f} s no rule was asked to assign it"
            return told if now_s >= self.asked_s + LONG_S and _open_lines(given) else None
        since = f"it arrived at {given['arrival_s']:,.0f} s; in this run no rule was asked to assign it before"
        return f"{since} {now_s:,.0f} s" if not given["parts"] and now_s >= given["arrival_s"] + 1 else None

    def _waited(self) -> Iterator[Episode]:
        yield from (one.episode() for one in _folded(self.waits))
        self.waits = []

    def end(self) -> Iterator[Episode]:
        """Yield what goes on when there is no more decision."""
        if self.without_stock is not None:
            yield self.without_stock.episode()
        yield from self._waited()
        if (last := self.last) is not None and (told := self._unasked(last.content["orders"][self.order], last.time_s)):
            yield _episode(last, told)


def order_stories(decisions: Iterable[Recorded], orders: Iterable[str]) -> dict[str, list[Episode]]:
    """Tell of each order why it waited, where its lines were assigned, and which pods were sent for them."""
    stories = [_Story(order) for order in orders]
    told: dict[str, list[Episode]] = {story.order: [] for story in stories}
    for decision in decisions:
        for story in stories:
            told[story.order] += story.tell(decision)
    for story in stories:
        told[story.order] += story.end()
        told[story.order].sort(key=lambda episode: episode.number)
    return told


def order_story(decisions: Iterable[Recorded], order: str) -> list[Episode]:
    """Tell this of one order."""
    return order_stories(decisions, [order])[order]


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


def reduced(content: Content, order: str) -> tuple[OpenState, Order]:
    """Return the warehouse of a recorded state with what an order's assignment depends on alone, and the order in it.

    That is the order with its open lines, and the picking stations with as many items as determine their free
    capacity. Robots, what pods hold, other orders of the backlog and what was picked make no difference, but would
    take most of the time.
    """
    stations: dict[str, dict[str, Any]] = {
        name: {key: given[key] for key in _OF_STATIONS & given.keys()} | {"requests": _taking(content, name)}
        for name, given in content["stations"].items()
        if "item_capacity" in given or "order_capacity" in given
    }
    left = {order: Counter[str]()}  # items by SKU that use capacity
    for given in stations.values():
        for request in given["requests"]:
            left.setdefault(request["order"], Counter())[request["sku"]] += 1
    orders = {name: _cut(content["orders"][name], items, asked=name == order) for name, items in left.items()}
    held = dict.fromkeys(sku for given in orders.values() for sku in given["lines"])
    told = {"format": FORMAT, "version": VERSIONS[-1], "stations": stations, "orders": orders}
    state = open_state(state_from_dict(told | {"pods": {"any": {"contents": held}}}))
    return state, state.view.order(state.names.orders[order])


def _taking(content: Content, name: str) -> list[Content]:
    """Return what uses a station's capacity, as requests: items of parts that are not done, no more than it takes.

    Where it counts orders, that is one item each.
    """
    station, found = content["stations"][name], list[Content]()
    here = [*station["requests"], *filter(None, [station.get("in_hand")])]
    for order, skus in _by_order(here).items():
        lines, parts = content["orders"][order]["lines"], content["orders"][order]["parts"]
        undone = (part["skus"] for part in parts if part["station"] == name and not skus.isdisjoint(part["skus"]))
        of_order = ({"order": order, "sku": sku} for part in undone for sku in part for _ in range(lines[sku]))
        found += islice(of_order, station.get("item_capacity", 1))
    return found[: station.get("item_capacity")]


def _by_order(requests: Iterable[Content]) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for request in requests:
        found.setdefault(request["order"], set()).add(request["sku"])
    return found


def _cut(order: Content, left: Mapping[str, int], *, asked: bool) -> Content:
    """Return an order with no more of its assigned lines than is left, and if it is asked about with its open lines."""
    lines = {**left, **(_open_lines(order) if asked else {})}
    parts = [part | {"skus": skus} for part in order["parts"] if (skus := [sku for sku in part["skus"] if sku in left])]
    return {key: one for key, one in order.items() if key != "packing"} | {"lines": lines, "parts": parts}


def _open_lines(order: Content) -> Mapping[str, int]:
    assigned = {sku for part in order["parts"] for sku in part["skus"]}
    return {sku: items for sku, items in order["lines"].items() if sku not in assigned}


def _episode(decision: Recorded, what: str) -> Episode:
    period, time_s = decision.period, decision.time_s
    return Episode(decision.number, (period, period), (time_s, time_s), decision.decides, decision.rule, what)


def _done_for(decision: Recorded, order: str) -> Iterator[str]:
    """Yield what a decision did for an order."""
    decided, content = decision.decision or {}, decision.content
    wanted: dict[str, set[str]] = {}
    assigned = [given for given in decided.get("assignments", ()) if given["order"] == order]
    left = len(_open_lines(content["orders"][order])) if assigned else 0
    left -= sum(len(given["skus"]) for given in assigned)
    for given in assigned:
        wanted.setdefault(given["station"], set()).update(given["skus"])
        last = left and given is assigned[-1]
        rest = f"; {left} of its lines {'stays' if left == 1 else 'stay'} in the backlog" if last else ""
        yield f"assigned to station {given['station']}: {_skus(given['skus'])}{rest}"
    for given in decided.get("packing", ()):
        if given["order"] == order:
            yield f"bound for packing station {given['station']}"
    if "task" in decided and (task := task_in(content, decided["task"]))["order"] == order:
        yield f"{in_words(task)} at packing station {content['ask']['station']}"
    for station, given in content["stations"].items():
        for request in given["requests"]:
            if request["order"] == order and "pod" not in request:
                wanted.setdefault(station, set()).add(request["sku"])
    for trip in decided.get("trips", ()):
        held = content["pods"][trip["pod"]]["contents"]
        skus = [sku for sku in sorted(wanted.get(trip["station"], ())) if sku in held]
        if skus:
            yield f"pod {trip['pod']} sent to station {trip['station']}: it holds {_skus(skus)}"


def _inbound_for(assigned: Recorded, after: Content, order: str) -> Iterator[str]:
    """Yield which pods, bound for the order's stations before, have what a decision assigned, by the state after it."""
    decided = assigned.decision or {}
    sent = {(trip["station"], trip["pod"]) for trip in decided.get("trips", ())}
    lines = {(g["station"], sku) for g in decided["assignments"] if g["order"] == order for sku in g["skus"]}
    found: dict[tuple[str, str], dict[str, None]] = {}
    for station, given in after["stations"].items():
        for request in (one for one in given["requests"] if one["order"] == order and "pod" in one):
            at = station, request["pod"]
            if at not in sent and (station, request["sku"]) in lines:
                found.setdefault(at, {})[request["sku"]] = None
    for (station, pod), skus in found.items():
        yield f"pod {pod}, bound for station {station} already, holds {_skus([*skus])}"


def _why_waiting(decision: Recorded, order: str) -> str | None:
    """Say why all open lines of an order stay in the backlog; None when there are none, or some do not."""
    content, decided = decision.content, decision.decision
    given = (decided or {}).get("assignments", ())
    if any(assignment["order"] == order for assignment in given):
        return None
    if not _open_lines(content["orders"][order]):
        return None
    if decided is None:
        return "the rule decided nothing valid, which ended the run"
    if order not in content.get("backlog", (order,)):
        return "the prefilters left it out"
    state, asked = reduced(content, order)
    why = _why_not_chosen(state.view, asked, "preferred others" if given else "assigned nothing")
    begun = bool(content["orders"][order]["parts"])
    return why if begun or free_boxes(content) != 0 else f"{why}, and no box was free to split it"


def free_boxes(content: Content) -> int | None:
    """Return how many more orders could be split in a recorded state; None where no box counts until it is packed."""
    packing = content.get("packing")
    if packing is None or packing["section"]["packing_from"] != "packed":
        return None
    told = [order["packing"] for order in content["orders"].values() if "packing" in order]
    taken = sum("box" in one and not one["packed"] for one in told)
    return int(packing["section"]["boxes"]) * len(packing["stations"]) - taken


def task_in(content: Content, at: int) -> Mapping[str, Any]:
    """Return the task at a position among the tasks that a packer could begin in a recorded state."""
    packing = content["packing"]
    station, section = packing["stations"][int(content["ask"]["station"]) - 1], packing["section"]
    tasks = [*station["tasks"]]
    if section["sorters"]:  # who is asked does either
        sorting = sum(task["kind"] == "put" for task in station["working"]) < section["sorters"]
        puts = [task for task in tasks if task["kind"] == "put"]
        tasks = puts if puts and sorting else [task for task in tasks if task["kind"] == "pack"]
    found: Mapping[str, Any] = tasks[at]
    return found


def in_words(task: Mapping[str, Any]) -> str:
    """Say what a packer does."""
    what = "order" if task["kind"] == "pack" else f"tote {task['tote']}, into the box of order"
    return f"{task['kind']} {what} {task['order']}"


def _why_not_chosen(warehouse: WarehouseView, order: Order, did: str) -> str:
    """Say why an order was assigned nowhere, although it was shown to the rule."""
    stations = [station for station in warehouse.stations if station.open]
    if any(warehouse.size_at(order, station) <= station.free_capacity for station in stations):
        return f"it fitted a station, but the rule {did}"
    if not stations:
        return "all stations were closed"
    items, kind = order.open_items, "" if len(stations) == len(warehouse.stations) else "open "
    no_room = f"no {kind}station could take its {items} open item{'s' if items > 1 else ''}"
    # What a rule that splits orders could have done, too; whether this one does, the recording does not tell.
    least = min(line.quantity for line in order.open_lines)
    some = any(station.free_capacity >= least for station in stations if not station.counts_orders)
    return f"{no_room}, only some of them" if some else no_room


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
