from .bench import Contestant, Measured, bench, contestant
from .worlds import WORLDS

__all__ = ["WORLDS", "Contestant", "Measured", "bench", "contestant"]
