from .conformance import (
    ConformanceError,
    ConformanceReport,
    Finding,
    check_rule,
    conformance_report,
)
from .traces import Fault, validate_trace
from .worlds import small_instance, small_layout, small_world

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
