"""Name of rmfs in messages: its version is in pyproject.toml alone."""

from importlib.metadata import version

RMFS = f"rmfs {version('rmfs')}"
