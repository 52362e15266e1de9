"""Functions that draw layouts, for authors of generators."""

from rmfs_commands.layouts import *
from rmfs_commands.layouts import __all__ as __all__
