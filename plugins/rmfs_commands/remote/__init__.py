"""Rule ``remote``: another program decides, in any language, by JSON."""

from rmfs_commands.remote.rule import Remote

__all__ = ["Remote"]
