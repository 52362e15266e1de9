"""Compiled looks at what pods hold; `sending` says what is decided with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import njit
from rmfs_core.warehouse import BUSY, STORED, Stock

if TYPE_CHECKING:
    from rmfs_rules.helpers.searching import Plain

Ids = NDArray[np.int64]


@njit(cache=True, interpreted=True)
def servers(columns: Plain, at: Ids, skus: Ids, station: int, fetch: bool) -> Ids:
    """Pods that can be sent to a station and have a free item of one of the SKUs, ascending.

    Parameters
    ----------
    columns
        Columns of the pods' `Stock`.
    at
        As `Stock.at`, with what this decision has sent.
    skus
        SKUs of the requests that are uncovered.
    station
        Its id.
    fetch
        Whether stored pods can be sent, besides pods that are about to leave a station.
    """
    stock = Stock(*columns)
    found, number = np.zeros(len(at), np.bool_), 0
    for sku in skus:
        for index in range(stock.of_sku[sku], stock.of_sku[sku + 1]):
            entry = stock.by_sku[index]
            pod = stock.pod[entry]
            where = at[pod]
            if stock.items[entry] > 0 and where not in (BUSY, station) and (fetch or where != STORED):
                number += not found[pod]
                found[pod] = True
    pods, number = np.empty(number, np.int64), 0
    for pod in range(len(found)):
        if found[pod]:
            pods[number] = pod
            number += 1
    return pods


@njit(cache=True, interpreted=True)
def worth(of_pod: Ids, sku: Ids, items: Ids, pods: Ids, wanted: Ids) -> Ids:
    """Of each pod the sum over its SKUs of min(free items, items wanted); of `Stock` it takes what it reads."""
    sums = np.zeros(len(pods), np.int64)
    for i in range(len(pods)):
        for entry in range(of_pod[pods[i]], of_pod[pods[i] + 1]):
            sums[i] += min(items[entry], wanted[sku[entry]])
    return sums


@njit(cache=True, interpreted=True)
def held(of_pod: Ids, sku: Ids, items: Ids, values: Ids) -> Ids:
    """Of all pods the sum of values by SKU over the SKUs that each has free; of `Stock` it takes what it reads."""
    sums = np.zeros(len(of_pod) - 1, np.int64)
    for pod in range(len(sums)):
        for entry in range(of_pod[pod], of_pod[pod + 1]):
            if items[entry] > 0:
                sums[pod] += values[sku[entry]]
    return sums
