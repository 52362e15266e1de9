"""Processes of a run where a scenario asks for them: entry points of the group ``rmfs.processes``."""
