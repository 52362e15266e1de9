from rmfs_commands.layouts import *  # noqa: F403
