"""From a state's orders and requests to those of the warehouse."""

from __future__ import annotations

from collections.abc import Sequence

from rmfs_core.warehouse import Request, Station, Warehouse
from rmfs_core.warehouse.state import _promise
from rmfs_states.names import Names
from rmfs_states.state import OrderState, PartState, State, StationState

Requested = dict[str, dict[str, list[str]]]
"""Order -> station -> SKUs that have requests there."""


def assign_parts(warehouse: Warehouse, names: Names, state: State) -> None:
    """Assign what a state says was assigned, and leave open of it only what the state still requests."""
    requested = _requested(names, state)
    for name, given in state.orders.items():
        order = warehouse.orders[names.order(name)]
        for i, part in enumerate(_parts(given, requested.get(name, {}))):
            path = ("orders", name, "parts", i)
            station = warehouse.stations[names.station(part.station, *path, "station")]
            skus = [names.sku(sku, *path, "skus") for sku in part.skus]
            for sku, sku_name in zip(skus, part.skus, strict=True):
                if sku not in order._open or skus.count(sku) > 1:
                    problem = f'names SKU "{sku_name}", which is no line of the order that is still to be assigned'
                    names.wrong((*path, "skus"), problem)
            if skus:
                warehouse.assign(order, station, skus, part.period)
    for station, given_station in zip(warehouse.stations, state.stations.values(), strict=True):
        _keep_open(warehouse, names, station, given_station)


def promise_items(warehouse: Warehouse, names: Names, state: State) -> None:
    """Promise items on inbound pods to requests: first as the state says, then to whatever is left over."""
    for station, given in zip(warehouse.stations, state.stations.values(), strict=True):
        for i, (request, wanted) in enumerate(zip(station.open_requests, given.requests, strict=True)):
            if wanted.pod is None:
                continue
            path = ("stations", station.name, "requests", i, "pod")
            pod = warehouse.pods[names.pod(wanted.pod, *path)]
            if station.id not in pod.bound_for or pod.free_items(request.sku) <= 0:
                names.wrong(path, f'pod "{wanted.pod}" is not inbound here with an item of "{wanted.sku}" to spare')
            _promise(request, pod)
    for station in warehouse.stations:
        for request in station.uncovered_requests:
            warehouse._promise_from_inbound(station, request)


def _requested(names: Names, state: State) -> Requested:
    found: Requested = {}
    for station, given in state.stations.items():
        for i, request in enumerate(given.requests):
            path = ("stations", station, "requests", i)
            names.order(request.order, *path, "order")
            names.sku(request.sku, *path, "sku")
            found.setdefault(request.order, {}).setdefault(station, []).append(request.sku)
    return found


def _parts(order: OrderState, requested: dict[str, list[str]]) -> Sequence[PartState]:
    if order.parts is not None:
        return order.parts
    return [PartState(station, tuple(dict.fromkeys(skus))) for station, skus in requested.items()]


def _keep_open(warehouse: Warehouse, names: Names, station: Station, given: StationState) -> None:
    """Leave a station with the requests that the state lists, in their order and with their numbers."""
    assigned: dict[tuple[int, int], list[Request]] = {}
    for request in station.open_requests:
        assigned.setdefault((request.order.id, request.sku), []).append(request)
    kept: list[Request] = []
    for i, wanted in enumerate(given.requests):
        same = assigned.get((names.orders[wanted.order], names.skus[wanted.sku]))
        if not same:
            problem = (
                f'requests more of SKU "{wanted.sku}" for order "{wanted.order}" than `lines` and `parts` of the order '
                "assign to this station"
            )
            names.wrong(("stations", station.name, "requests", i), problem)
        kept.append(same.pop(0))
    for requests in assigned.values():
        for request in requests:
            warehouse.close(request)
    station._requests.clear()
    station._by_sku.clear()
    for request, wanted in zip(kept, given.requests, strict=True):
        number = warehouse._next_request if wanted.id is None else wanted.id
        if number in station._requests:
            names.wrong(("stations", station.name, "requests"), f"found the id {number} twice; expected each once")
        warehouse._next_request = max(warehouse._next_request, number + 1)
        object.__setattr__(request, "id", number)  # of a request that nobody has seen yet
        station._requests[number] = request
        station._by_sku.setdefault(request.sku, {})[number] = request
