"""Events that observers are told."""

from rmfs_core.events import *
from rmfs_core.events import __all__ as __all__
