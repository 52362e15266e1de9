from .reader import Trace, read_trace
from .writer import FILE, TraceWriter

__all__ = ["FILE", "Trace", "TraceWriter", "read_trace"]
