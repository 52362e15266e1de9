"""Rules held against each other in the same worlds: how good their decisions are, and how long they take."""

from rmfs_core.benchmarking.bench import Contestant, Measured, bench, contestant
from rmfs_core.benchmarking.worlds import WORLDS

__all__ = ["WORLDS", "Contestant", "Measured", "bench", "contestant"]
