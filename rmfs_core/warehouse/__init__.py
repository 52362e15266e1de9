"""The warehouse: its state, which the kernel changes, and the read-only view of it that rules get."""

from rmfs_core.warehouse.backlog import BacklogLines, FreeItems
from rmfs_core.warehouse.column_keeping import columns_of, shown, stock_of
from rmfs_core.warehouse.columns import BUSY, CAPACITY, STORED, Lines, Stock
from rmfs_core.warehouse.packing import PackingStation, PackingTask
from rmfs_core.warehouse.parts import UNLIMITED, Bundle, Order, OrderLine, OrderPacking, Pod, Request, Robot, Station
from rmfs_core.warehouse.state import Warehouse
from rmfs_core.warehouse.view import WarehouseView

__all__ = [
    "BUSY",
    "CAPACITY",
    "STORED",
    "UNLIMITED",
    "BacklogLines",
    "Bundle",
    "FreeItems",
    "Lines",
    "Order",
    "OrderLine",
    "OrderPacking",
    "PackingStation",
    "PackingTask",
    "Pod",
    "Request",
    "Robot",
    "Station",
    "Stock",
    "Warehouse",
    "WarehouseView",
    "columns_of",
    "shown",
    "stock_of",
]
