"""What rules see: what `rmfs_core.warehouse` has."""

from rmfs.lazy import module_of

__path__: list[str] = []  # not that of the other: its modules could be imported twice
__getattr__, __dir__ = module_of("rmfs_core.warehouse")
