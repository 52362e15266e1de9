"""Decisions as a Gymnasium environment."""

from rmfs_commands.gym import *
from rmfs_commands.gym import __all__ as __all__
