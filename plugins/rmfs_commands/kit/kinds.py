"""What can be written besides rules."""

COMMAND = "command"
"""A command of `rmfs`."""
