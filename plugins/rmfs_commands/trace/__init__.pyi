from .reader import KnownIds, Trace, TraceStream, fitting, read_trace, trace_file, trace_of
from .writer import FILE, TraceWriter

__all__ = ["FILE", "KnownIds", "Trace", "TraceStream", "TraceWriter", "fitting", "read_trace", "trace_file", "trace_of"]
