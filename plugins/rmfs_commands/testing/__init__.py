"""Tools for testing rules: tiny worlds written down in a line or two, a conformance suite, the validation of runs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
