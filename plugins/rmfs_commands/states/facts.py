"""Facts that the kernel works out from a state: promises, next picks, expected arrivals, pods that may leave."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rmfs_commands.states.rebuilding import OpenState
from rmfs_core.warehouse.promises import next_request

Facts = list[dict[str, Any]] | list[str]


def facts_of(opened: OpenState) -> dict[str, Facts]:
    """Return the facts that a state asks for (``ask.tell``), as they are before anything is decided."""
    return {fact: _FACTS[fact](opened) for fact in opened.state.ask.tell}


def _promises(opened: OpenState) -> Facts:
    """Each open request with the inbound pod that its items are promised from."""
    return [
        {
            "station": station.name,
            "order": request.order.name,
            "sku": opened.instance.skus[request.sku],
            "items": request.items,
            **({} if request.pod is None else {"pod": request.pod.name}),
        }
        for station in opened.view.stations
        for request in station.open_requests
    ]


def _next(opened: OpenState) -> Facts:
    """For each pod that stands at a picking station, the item that is picked from it next."""
    found: list[dict[str, Any]] = []
    for station in opened.view.stations:
        pod = opened.warehouse.pod_at(station)
        request = None if pod is None else next_request(station, pod)
        if pod is not None and request is not None:
            sku = opened.instance.skus[request.sku]
            found.append({"station": station.name, "pod": pod.name, "order": request.order.name, "sku": sku})
    return found


def _arrivals(opened: OpenState) -> Facts:
    """When each pod that a robot carries or fetches is expected at its next station, without other robots."""
    return [
        {"pod": pod.name, "station": opened.warehouse.stations[pod.bound_for[0]].name, "expected_s": expected}
        for pod in opened.view.pods
        if (expected := pod.expected_arrival_s) is not None
    ]


def _leaving(opened: OpenState) -> Facts:
    """Pods that stand at a station, serve nothing there any more and are bound for no other: they may leave."""
    return [pod.name for pod in opened.view.leaving_pods]


_FACTS: Mapping[str, Callable[[OpenState], Facts]] = {
    "promises": _promises,
    "next": _next,
    "arrivals": _arrivals,
    "leaving": _leaving,
}
