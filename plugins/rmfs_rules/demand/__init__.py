"""PPS rule ``demand``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import PodTrip, hookimpl
from rmfs_rules.helpers.sending import ByStock, Ids, nearest, send, worth

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, Stock, WarehouseView


@define
class Demand(ByStock):
    """Send the pod whose contents are wanted most in the whole system.

    Among the pods not in use (or leaving a station with no next one) that can serve at least one uncovered request of
    the station, the pod p with the highest

        sum over the SKUs i of p of min(D_i, n_ip)

    is sent; D_i is the open demand of the whole system (items of all orders that have arrived, not yet picked; orders
    that wait for stock count as well) and n_ip the number of items on the pod. Ties go to the pod with the shorter
    loaded driving time to the station, then to the lowest id. The station with the fewest inbound pods chooses first.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send the most wanted pods to the stations that lack one."""

        def most_wanted(stock: Stock, station: Station, pods: Ids) -> int:
            wanted = worth(stock, pods, warehouse.open_demand())  # nothing on a pod that can be sent is promised
            return nearest(warehouse, stock, pods[wanted == wanted.max()], station)

        return send(warehouse, max_fetches, most_wanted)
