"""The fewest robots and stations that are enough."""
