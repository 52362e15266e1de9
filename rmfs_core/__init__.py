"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems.

The way of the data: a TOML file becomes a `Scenario` (``scenario``); of it are made what is there when a run begins,
layout and instance (``world``), and the rules that it names (``rules``). The simulation (``simulation``) changes the
``warehouse``, asks the rules through hooks (``hookspecs``) and says what happened (``events``); metrics and tables are
observers that count it, and what they counted is the `Result` (``results``). `run` goes all of this way.

What ``__init__.pyi`` names is the public surface. It is imported on first use: ``import rmfs_core`` costs next to
nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
