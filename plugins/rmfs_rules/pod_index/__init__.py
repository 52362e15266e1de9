"""Joint rule ``pod-index``."""

from rmfs_rules.pod_index.rule import PodIndex

__all__ = ["PodIndex"]
