from .parts import PARTS, choose_parts
from .reproducing import Reproduction, reproduce

__all__ = ["PARTS", "Reproduction", "choose_parts", "reproduce"]
