"""Files of results, whole or not at all; the figures of a run by the clock on the wall, and how notebooks show it."""
