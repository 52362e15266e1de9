from .bounds import BOUNDED, Bound, bounds_of, find_bounds

__all__ = ["BOUNDED", "Bound", "bounds_of", "find_bounds"]
