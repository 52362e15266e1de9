"""PP rule ``whca-n``."""

from rmfs_rules.whca.rule import WhcaN

__all__ = ["WhcaN"]
