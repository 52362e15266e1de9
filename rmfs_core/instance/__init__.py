"""Orders, pods and SKUs of a run: generated after the paper, or read from CSV files."""

from rmfs_core.instance.model import Instance, OrderData, PodData

__all__ = ["Instance", "OrderData", "PodData"]
