"""The old name of `rmfs_traffic`, until 0.3.0."""

import sys

from rmfs_core.former import former

__path__: list[str] = []
__getattr__ = former(__name__, "rmfs_traffic")
sys.modules.update({f"{__name__}.{old}": sys.modules[__name__] for old in ("paths", "reservations", "roads")})
