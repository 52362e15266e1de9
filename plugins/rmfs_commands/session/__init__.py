"""Sessions that run a warehouse: facts of the floor come in, commands go out; the kernel's rounds decide."""

from rmfs_commands.session.hall import Hall, StaleBatchError

__all__ = ["Hall", "StaleBatchError"]
