"""Joint rule ``pod-index``."""

from rmfs_pod_index.rule import PodIndex

__all__ = ["PodIndex"]
