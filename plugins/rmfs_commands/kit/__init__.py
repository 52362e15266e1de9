"""The kit for authors of rules: a distribution of one's own, written from templates that work as they are."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
