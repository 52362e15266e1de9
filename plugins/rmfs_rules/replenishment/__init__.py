"""Rules for replenishment: for ROA, for RPS, and for both at once."""

from rmfs_rules.replenishment.both import PodFirst
from rmfs_rules.replenishment.pods import (
    Correlated,
    EmptiestPod,
    LeastDemand,
    NearestPodWithRoom,
    SameSku,
    SpreadSku,
    TurnoverPod,
)
from rmfs_rules.replenishment.stations import FirstBundle, SamePod

__all__ = [
    "Correlated",
    "EmptiestPod",
    "FirstBundle",
    "LeastDemand",
    "NearestPodWithRoom",
    "PodFirst",
    "SamePod",
    "SameSku",
    "SpreadSku",
    "TurnoverPod",
]
