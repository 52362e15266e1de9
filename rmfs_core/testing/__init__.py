"""Tools for testing rules: tiny worlds written down in a line or two, a conformance suite, the validation of runs."""

from rmfs_core.testing.conformance import (
    ConformanceError,
    ConformanceReport,
    Finding,
    check_rule,
    conformance_report,
)
from rmfs_core.testing.worlds import small_instance, small_layout, small_world
from rmfs_core.validation import Fault, validate_trace

__all__ = [
    "ConformanceError",
    "ConformanceReport",
    "Fault",
    "Finding",
    "check_rule",
    "conformance_report",
    "small_instance",
    "small_layout",
    "small_world",
    "validate_trace",
]
