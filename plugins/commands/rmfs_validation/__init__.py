"""Whether a recorded run is possible at all, judged from its trace, whatever planned or simulated it.

Read are the trace, with the layout and the scenario in its header, and the metrics of ``result.json`` beside it. Shared
with the simulation are the layout, the closed formulas of `rmfs_core.motion` and the classes of events; nothing else.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
