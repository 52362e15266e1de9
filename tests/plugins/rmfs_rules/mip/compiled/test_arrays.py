"""A period as flat arrays."""

from __future__ import annotations

import pytest

from rmfs_rules.mip.compiled.arrays import arrays_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model


@pytest.mark.parametrize("model", [Model.INTEGRATED, Model.SPLIT_AMONG_STATIONS])
def test_the_lists_are_those_of_the_period(periods, model):
    """Lines by order, SKUs by pod and pods by SKU say the same as the period does."""
    for period in periods[:100]:
        reduced = Reduced(period, model)
        a, pods = arrays_of(reduced, splits=1)
        lines = [
            sorted(zip(a.line_sku[first:last].tolist(), a.line_items[first:last].tolist(), strict=True))
            for first, last in zip(a.order_start, a.order_start[1:], strict=False)
        ]
        assert lines == [sorted(period.lines[order]) for order in reduced.orders]
        brought = {
            (pod, int(sku)) for pod in range(len(pods)) for sku in a.pod_sku[a.pod_start[pod] : a.pod_start[pod + 1]]
        }
        assert brought == {
            (int(pod), sku)
            for sku in range(period.stock.n_skus)
            for pod in a.sku_pod[a.sku_start[sku] : a.sku_start[sku + 1]]
        }
        assert all(sku in period.stock.contents[pods[pod]] for pod, sku in brought)
        assert a.rooms.tolist() == list(period.capacities)
        assert (a.whole, a.splits) == (model is Model.INTEGRATED, 1)
