from rmfs_commands.testing import *  # noqa: F403
