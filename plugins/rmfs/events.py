"""What observers are told: what `rmfs_core.events` has."""

from rmfs.lazy import module_of

__path__: list[str] = []  # not that of the other: its modules could be imported twice
__getattr__, __dir__ = module_of("rmfs_core.events")
