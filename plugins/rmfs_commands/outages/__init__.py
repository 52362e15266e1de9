"""Robots and stations that fail or are maintained: what the kernel asks for where a scenario has any that do."""

from rmfs_commands.outages.outages import Outages

__all__ = ["Outages"]
