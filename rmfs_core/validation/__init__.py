"""Whether a recorded run is possible at all, judged from its trace, whatever planned or simulated it.

Read are the trace, with the layout and the scenario in its header, and the metrics of ``result.json`` beside it. Shared
with the simulation are the layout, the closed formulas of `rmfs_core.motion` and the classes of events; nothing else.
"""

from rmfs_core.validation.fault import KINDS, Fault
from rmfs_core.validation.reading import Report, check_trace, validate_trace
from rmfs_core.validation.validator import faults_of

__all__ = ["KINDS", "Fault", "Report", "check_trace", "faults_of", "validate_trace"]
