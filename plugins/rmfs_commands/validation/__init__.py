"""Whether a recorded run is possible at all, judged from its trace, whatever planned or simulated it.

Reads the trace, with the layout and the scenario in its header, and ``result.json`` and the tables next to it. Shared
with the simulation are what a scenario makes (layout and instance, `rmfs_core.world`), the closed formulas of
`rmfs_core.motion` and the classes of events; nothing else.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
