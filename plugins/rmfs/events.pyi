from rmfs_core.events import *  # noqa: F403
