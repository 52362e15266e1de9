"""Rules of packing stations: ``least-reserved``, ``pack-first``, ``due-first`` and ``shortest``."""

from rmfs_rules.packing.rules import DueFirst, LeastReserved, PackFirst, Shortest

__all__ = ["DueFirst", "LeastReserved", "PackFirst", "Shortest"]
