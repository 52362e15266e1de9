"""Bounds on all runs of a scenario, whatever the rules: docs/explanation/bounds.md has the proofs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
