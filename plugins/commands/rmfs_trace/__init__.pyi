from .reader import Trace, TraceStream, read_trace
from .writer import FILE, TraceWriter

__all__ = ["FILE", "Trace", "TraceStream", "TraceWriter", "read_trace"]
