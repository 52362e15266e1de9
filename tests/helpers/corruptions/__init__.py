"""Kinds of corruption of a recorded trace, each a small function under the name that a test shows.

A corruption is made in what the file holds, header and lines, and is as small as a mistake of a simulation, or of
somebody who changes a trace by hand, can be. `NotThereError` says that a trace has nothing of the kind.
"""

from corruptions import bundles, driving, header, packing, working  # they register their kinds
from corruptions.raw import KINDS, NotThereError, Raw

__all__ = ["KINDS", "NotThereError", "Raw", "bundles", "driving", "header", "packing", "working"]
