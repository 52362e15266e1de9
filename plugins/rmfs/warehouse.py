"""The warehouse as rules see it."""

from rmfs_core.warehouse import *
from rmfs_core.warehouse import __all__ as __all__
