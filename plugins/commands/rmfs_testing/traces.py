"""The validation of recorded runs, among the tools for tests."""

from rmfs_validation import Fault, validate_trace

__all__ = ["Fault", "validate_trace"]
