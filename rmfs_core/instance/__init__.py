"""Orders, pods and SKUs of a run: generated after the paper, or read from CSV files."""

from rmfs_core.instance.generator import generate_instance
from rmfs_core.instance.making import make_instance
from rmfs_core.instance.model import Instance, OrderData, PodData
from rmfs_core.instance.reading import read_instance
from rmfs_core.instance.writing import orders_csv, pods_csv

__all__ = [
    "Instance",
    "OrderData",
    "PodData",
    "generate_instance",
    "make_instance",
    "orders_csv",
    "pods_csv",
    "read_instance",
]
