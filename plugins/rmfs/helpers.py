"""Loops and look-ups for authors of rules."""

from rmfs_rules.helpers import *
from rmfs_rules.helpers import __all__ as __all__
