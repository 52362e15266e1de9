"""What watches a run: metrics, tables, trace and display are observers and nothing but observers."""

from rmfs_core.observers.metrics import Metrics
from rmfs_core.observers.tables import Tables
from rmfs_core.observers.trace import TraceWriter
from rmfs_core.observers.trace_reader import Trace, read_trace

__all__ = ["Metrics", "Tables", "Trace", "TraceWriter", "read_trace"]
