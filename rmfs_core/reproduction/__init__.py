"""The evaluation of the paper that rmfs follows, run again and held against its figures."""

from rmfs_core.reproduction.parts import PARTS, choose_parts
from rmfs_core.reproduction.reproducing import Reproduction, reproduce

__all__ = ["PARTS", "Reproduction", "choose_parts", "reproduce"]
