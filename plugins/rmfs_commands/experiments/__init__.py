"""Experiments: scenarios, rule sets and seeds crossed into runs, computed once each, stored, and compared in pairs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
