"""Tools for testing rules: tiny worlds written down in a line or two, and the validation of recorded runs."""

from rmfs_core.testing.worlds import small_instance, small_layout, small_world
from rmfs_core.validation import Fault, validate_trace

__all__ = ["Fault", "small_instance", "small_layout", "small_world", "validate_trace"]
