"""Layouts: RAWSim-O's blocks and text maps, entry points of the group ``rmfs.layouts``."""

from rmfs_commands.layouts.block import block_map, blocks
from rmfs_commands.layouts.textmap import parse_map, text_map

__all__ = ["block_map", "blocks", "parse_map", "text_map"]
