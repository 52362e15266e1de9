from rmfs_commands.gym import *  # noqa: F403
