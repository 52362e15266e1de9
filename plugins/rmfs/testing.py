"""Tools for testing rules."""

from rmfs_commands.testing import *
from rmfs_commands.testing import __all__ as __all__
