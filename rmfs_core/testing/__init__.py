"""Tools for testing rules: tiny worlds written down in a line or two."""

from rmfs_core.testing.worlds import small_instance, small_layout, small_world

__all__ = ["small_instance", "small_layout", "small_world"]
