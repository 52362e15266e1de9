"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems.

What ``__init__.pyi`` names is the public surface. It is imported on first use: ``import rmfs_core`` costs next to
nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
