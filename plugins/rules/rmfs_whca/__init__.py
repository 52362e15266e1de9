"""PP rule ``whca-n``."""

from rmfs_whca.rule import WhcaN

__all__ = ["WhcaN"]
