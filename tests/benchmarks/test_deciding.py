"""How long a decision outside a run takes, from the bytes of a state to those of the answer. `make bench` measures."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rmfs_commands.serve.service import SMALL, Service


def hall(orders: int) -> dict[str, Any]:
    """Return a state with eight stations and 1,000 pods."""
    contents = [{f"s{7 * i % 500}": 3, f"s{11 * i % 500}": 2} for i in range(1000)]
    return {
        "format": "rmfs-state",
        "version": 2,
        "pods": {f"p{i}": {"contents": held} for i, held in enumerate(contents)},
        "stations": {f"st{i}": {"item_capacity": 15} for i in range(8)},
        "orders": {f"o{i}": {"lines": {f"s{13 * i % 500}": 1}, "arrival_s": i} for i in range(orders)},
        "skus": [f"s{i}" for i in range(500)],
    }


@pytest.mark.parametrize("state", [SMALL, hall(10_000)], ids=["small", "10,000 orders"])
def test_a_request(benchmark: Any, state: dict[str, Any]) -> None:
    """One rule, the plainest, so that it is what is around it that is measured."""
    service, request = Service.of(["first-come"]), json.dumps(dict(state)).encode()
    assert benchmark(service.answer, request).status == 200
