"""The event trace of a run: `TraceWriter`, an observer, writes it; `read_trace` reads it back."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
